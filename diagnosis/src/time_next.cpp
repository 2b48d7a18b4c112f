#include "time_next.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <random>

#include "shares.h"

namespace grouser::diagnosis {

namespace {

constexpr int draws = 400, simulated_draws = 8;
constexpr std::size_t most_shown = 3;

/// A step of slip there and back, as a new run of the rig.
struct Plan {
  double speed_factor = 1, slip_from = 0, slip_to = 0, spacing = 0, duration = 0;
  double cost = 1;
};

TimeRun run_of(const TimeModel& m, const Plan& plan, double load, double radius, double speed) {
  TimeRun run;
  run.spacing = plan.spacing;
  const int rows = std::clamp(static_cast<int>(plan.duration / plan.spacing) + 1, 40, 240);
  const double dt = plan.duration / (rows - 1), ramp = 1.5 * dt;
  // Travel is held, the rim follows the slip: as a towed rig does it.
  const double travel = speed * plan.speed_factor;
  for (int i = 0; i < rows; ++i) {
    Run r;
    r.time = dt * i;
    const double up = std::clamp((r.time - 0.2 * plan.duration) / ramp, 0.0, 1.0),
                 down = std::clamp((r.time - 0.6 * plan.duration) / ramp, 0.0, 1.0);
    r.slip = plan.slip_from + (plan.slip_to - plan.slip_from) * (up - down);
    r.load = load;
    const double rim = r.slip <= -1 ? 0 : r.slip < 0 ? travel * (1 + r.slip) : travel / (1 - r.slip);
    r.omega = rim / radius;
    r.line = 0;
    for (std::size_t c = 0; c < channel_count; ++c) {
      r.value[c] = std::numeric_limits<double>::quiet_NaN(), r.sd[c] = r.value[c];
    }
    for (std::size_t k = 0; k < m.channels().size(); ++k) {
      std::vector<double> sd;
      for (const TimeModel::Item& item : m.items())
        if (item.channel == static_cast<int>(k)) sd.push_back(item.sd);
      std::nth_element(sd.begin(), sd.begin() + static_cast<std::ptrdiff_t>(sd.size() / 2), sd.end());
      const auto ch = static_cast<std::size_t>(m.channels()[k]);
      r.value[ch] = 0, r.sd[ch] = sd[sd.size() / 2];
    }
    run.travel.push_back(travel);
    run.rim.push_back(rim);
    run.turn.push_back(i == 0 ? 0 : run.turn.back() + 0.5 * (run.rows.back().omega + r.omega) * dt);
    run.rows.push_back(std::move(r));
  }
  return run;
}

std::array<bool, channel_count> measured(const TimeModel& m) {
  std::array<bool, channel_count> out{};
  for (const int ch : m.channels()) out[static_cast<std::size_t>(ch)] = true;
  return out;
}

/// What a member foretells of the new run: mean, root of the covariance, its inverse's use.
struct Foretold {
  Eigen::VectorXd mean;
  Eigen::MatrixXd root;  ///< Cholesky factor of C + J V J'
  double log_det = 0;
};

/// The fit's parameters on a model of the new run alone, with what is known of them as prior. Soil that scatters from run to run and
/// the state at the start are new there.
bool foretell(const TimeModel& fresh, const TimeModel& old, const TimeRival& r, Foretold& out, Eigen::VectorXd& x,
              double extra_gap) {
  const std::vector<TimeParameter> now = fresh.parameters(r.account), then = old.parameters(r.account);
  x = fresh.carried(r.account, fresh.start(r.account), r.account);
  const auto P = static_cast<Eigen::Index>(now.size());
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(P, P);
  std::vector<Eigen::Index> from;  // parameters that both have
  const int soil = old.soil_parameters();
  int tail_now = static_cast<int>(now.size()), tail_then = static_cast<int>(then.size()), tail = 0;
  while (tail < std::min(tail_now, tail_then) - soil &&
         now[static_cast<std::size_t>(tail_now - 1 - tail)].name ==
             then[static_cast<std::size_t>(tail_then - 1 - tail)].name &&
         now[static_cast<std::size_t>(tail_now - 1 - tail)].name != "start" &&
         now[static_cast<std::size_t>(tail_now - 1 - tail)].name.find("of run") == std::string::npos)
    ++tail;
  for (Eigen::Index i = 0; i < P; ++i) {
    Eigen::Index j = -1;
    if (i < soil) j = i;
    if (i >= tail_now - tail) j = i + tail_then - tail_now;
    from.push_back(j);
    if (j >= 0)
      x[i] = r.fit.x[j];
    else
      V(i, i) = std::pow(now[static_cast<std::size_t>(i)].sd, 2);
  }
  for (Eigen::Index i = 0; i < P; ++i)
    for (Eigen::Index j = 0; j < P; ++j)
      if (from[static_cast<std::size_t>(i)] >= 0 && from[static_cast<std::size_t>(j)] >= 0)
        V(i, j) = r.fit.covariance(from[static_cast<std::size_t>(i)], from[static_cast<std::size_t>(j)]);
  // A run begins where the steady wheel is, within the noise.
  RowMatrix y;
  Eigen::MatrixXd J;
  const TimeAccount steady{};
  if (now.size() > static_cast<std::size_t>(soil) && fresh.given().options.free_start) {
    RowMatrix still;
    if (!fresh.predict(steady, x.head(soil), still, nullptr)) return false;
    int c = 0;
    for (Eigen::Index i = 0; i < P; ++i)
      if (now[static_cast<std::size_t>(i)].name == "start") x[i] = still(0, c++);
  }
  if (!fresh.predict(r.account, x, y, &J)) return false;
  const auto N = static_cast<Eigen::Index>(fresh.items().size());
  const auto C = static_cast<Eigen::Index>(fresh.channels().size());
  out.mean = fresh.item_values(y);
  Eigen::MatrixXd D(N, P);
  for (Eigen::Index i = 0; i < N; ++i) {
    const TimeModel::Item& item = fresh.items()[static_cast<std::size_t>(i)];
    D.row(i) = J.row(item.row * C + item.channel);
  }
  Eigen::MatrixXd S = D * V * D.transpose();
  for (Eigen::Index i = 0; i < N; ++i)
    for (Eigen::Index j = 0; j < N; ++j) {
      const auto& a = fresh.items()[static_cast<std::size_t>(i)];
      const auto& b = fresh.items()[static_cast<std::size_t>(j)];
      if (a.channel != b.channel) continue;
      const TimeNoise& n = r.fit.noise[static_cast<std::size_t>(fresh.channels()[static_cast<std::size_t>(a.channel)])];
      const double gap = std::abs(a.row - b.row) * extra_gap;
      S(i, j) += n.scale * n.scale * a.sd * b.sd * (gap == 0 ? 1 : n.rho > 0 ? std::pow(n.rho, gap) : 0);
    }
  const Eigen::LLT<Eigen::MatrixXd> root(S);
  if (root.info() != Eigen::Success) return false;
  out.root = root.matrixL();
  out.log_det = 2 * out.root.diagonal().array().log().sum();
  return true;
}

double log_density(const Foretold& f, const Eigen::VectorXd& y) {
  const Eigen::VectorXd u = f.root.triangularView<Eigen::Lower>().solve(y - f.mean);
  return -0.5 * (u.squaredNorm() + f.log_det);
}

double chance_of(const std::vector<Foretold>& members, const std::vector<TimeRival>& rivals) {
  double least = 1;
  std::mt19937_64 random(20110522);
  std::normal_distribution<double> normal;
  for (std::size_t truth = 0; truth < members.size(); ++truth) {
    int won = 0;
    for (int k = 0; k < draws; ++k) {
      Eigen::VectorXd z(members[truth].mean.size());
      for (double& v : z) v = normal(random);
      const Eigen::VectorXd y = members[truth].mean + members[truth].root * z;
      double own = 0, others = -1e300;
      for (std::size_t i = 0; i < members.size(); ++i) {
        const double q = log_density(members[i], y) + std::log(std::max(rivals[i].posterior, 1e-12));
        if (i == truth)
          own = q;
        else
          others = std::max(others, q) + std::log1p(std::exp(-std::abs(others - q)));
      }
      if (own - others > std::log(decisive)) ++won;
    }
    least = std::min(least, won / static_cast<double>(draws));
  }
  return least;
}

/// Old rows and the new run together, members refitted: share of draws in which the truth gets ten times the odds of the others.
double simulate(const TimeModel& old, const TimeRun& run, const std::vector<Foretold>& foretold,
                const std::vector<TimeRival>& members) {
  std::mt19937_64 random(19990522);
  std::normal_distribution<double> normal;
  std::array<bool, channel_count> stated{};
  stated.fill(true);
  int won = 0;
  for (int k = 0; k < simulated_draws; ++k) {
    const std::size_t truth = static_cast<std::size_t>(k) % members.size();
    Eigen::VectorXd z(foretold[truth].mean.size());
    for (double& v : z) v = normal(random);
    const Eigen::VectorXd y = foretold[truth].mean + foretold[truth].root * z;
    TimeRun shown = run;
    const auto rows = static_cast<Eigen::Index>(run.rows.size());
    for (Eigen::Index i = 0; i < y.size(); ++i)
      shown.rows[static_cast<std::size_t>(i % rows)]
          .value[static_cast<std::size_t>(old.channels()[static_cast<std::size_t>(i / rows)])] = y[i];
    std::vector<TimeRun> all = old.runs();
    for (TimeRun& r : all)
      for (std::size_t i = 0; i < r.rows.size(); ++i)
        for (const int ch : old.channels())
          if (!(r.rows[i].sd[static_cast<std::size_t>(ch)] > 0))
            r.rows[i].sd[static_cast<std::size_t>(ch)] = run.rows[0].sd[static_cast<std::size_t>(ch)];
    all.push_back(shown);
    const TimeModel both(old.given(), all, measured(old), stated);
    std::vector<double> evidence;
    const TimeAccount none{};
    const TimeFit still = both.fit(none, both.start(none), members[0].fit.noise);
    for (const TimeRival& r : members) evidence.push_back(both.search(r.account, none, still).log_evidence);
    double others = -1e300;
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (i != truth) others = std::max(others, evidence[i]);
    if (evidence[truth] - others > std::log(decisive)) ++won;
  }
  return won / static_cast<double>(simulated_draws);
}

}  // namespace

std::vector<NextExperiment> next_series(const TimeModel& m, const std::vector<TimeRival>& members) {
  std::vector<NextExperiment> out;
  if (members.size() < 2) return out;
  std::vector<std::string> names;
  for (const TimeRival& r : members) names.push_back(r.account.id());
  double low = 1, high = -1, load = 0, rows = 0, speed = 0;
  double duration = 0;
  for (const TimeRun& r : m.runs()) {
    duration = std::max(duration, r.rows.back().time - r.rows.front().time);
    for (std::size_t i = 0; i < r.rows.size(); ++i) {
      low = std::min(low, r.rows[i].slip), high = std::max(high, r.rows[i].slip);
      load += r.rows[i].load, speed += r.travel[i], rows += 1;
    }
  }
  load /= rows, speed /= rows;
  low = std::max(low, -0.9);
  if (high - low < 0.2) low = 0, high = 0.5;
  const double radius = m.given().steady.wheel.radius;
  std::vector<Plan> plans;
  for (const double factor : {1.0, 1.0 / 3, 3.0, 10.0})
    for (const double spacing : {1.0, 0.2}) {
      Plan p{factor, low, high, m.spacing() * spacing, duration, 1};
      if (spacing < 1) p.duration = std::min(duration, 240 * p.spacing);
      p.cost = 1 + (factor == 1 ? 0 : 1) + (spacing == 1 ? 0 : 1);
      plans.push_back(p);
    }
  struct Judged {
    NextExperiment e;
    Plan plan;
  };
  std::vector<Judged> judged;
  std::array<bool, channel_count> stated{};
  stated.fill(true);
  for (const Plan& p : plans) {
    const TimeRun run = run_of(m, p, load, radius, speed);
    const TimeModel fresh(m.given(), {run}, measured(m), stated);
    std::vector<Foretold> foretold(members.size());
    bool good = true;
    Eigen::VectorXd x;
    const double gap = (run.rows[1].time - run.rows[0].time) / m.spacing();
    for (std::size_t i = 0; good && i < members.size(); ++i) good = foretell(fresh, m, members[i], foretold[i], x, gap);
    if (!good) continue;
    NextExperiment e;
    e.condition = {{"slip_from", p.slip_from}, {"slip_to", p.slip_to},
                   {"load_N", load},           {"travel_speed_m_s", speed * p.speed_factor},
                   {"spacing_s", p.spacing},   {"duration_s", p.duration}};
    e.runs = 1, e.cost = p.cost, e.decides = names;
    e.chance = chance_of(foretold, members);
    judged.push_back({e, p});
  }
  std::stable_sort(judged.begin(), judged.end(), [](const Judged& a, const Judged& b) {
    const bool ga = a.e.chance >= enough, gb = b.e.chance >= enough;
    if (ga != gb) return ga;
    return ga ? a.e.cost < b.e.cost : a.e.chance > b.e.chance;
  });
  if (judged.size() > most_shown) judged.resize(most_shown);
  for (Judged& one : judged) {
    const TimeRun run = run_of(m, one.plan, load, radius, speed);
    const TimeModel fresh(m.given(), {run}, measured(m), stated);
    std::vector<Foretold> foretold(members.size());
    Eigen::VectorXd x;
    const double gap = (run.rows[1].time - run.rows[0].time) / m.spacing();
    for (std::size_t i = 0; i < members.size(); ++i) foretell(fresh, m, members[i], foretold[i], x, gap);
    one.e.simulated = simulate(m, run, foretold, members);
    // Slopes and known noise foretell too much where refits bend and find their own noise: what refits reach is the chance.
    one.e.chance = std::min(one.e.chance, *one.e.simulated);
    if (one.e.chance >= enough) break;
  }
  std::stable_sort(judged.begin(), judged.end(), [](const Judged& a, const Judged& b) {
    return (a.e.simulated ? a.e.chance : 0) > (b.e.simulated ? b.e.chance : 0);
  });
  for (const Judged& one : judged) out.push_back(one.e);

  // A sensor's filter or delay shows on the bench: a known step without soil. Members that differ in it are told apart there.
  const auto sensor = [](const TimeRival& r) {
    return r.account.has(TimeEffect::filter) || r.account.has(TimeEffect::delay);
  };
  bool differ = false;
  for (const TimeRival& a : members) differ = differ || sensor(a) != sensor(members[0]);
  if (differ) {
    const bool force = std::any_of(m.channels().begin(), m.channels().end(), [](int c) { return c != 2; });
    NextExperiment e;
    e.bench_check =
        force ? "hang a known weight on the drawbar sensor and cut the string, rows as close as in the runs"
              : "let the wheel drop from a block of known height on a rigid plate, rows as close as in the runs";
    e.bench_effect = "filter";
    e.decides = names;
    e.cost = 1;
    // Step of the largest change that the runs show, through the filter or delay found, against a step that is there at once.
    double least = 1;
    for (const TimeRival& r : members) {
      if (!sensor(r)) continue;
      const int fi = m.index_of(r.account, TimeEffect::filter), di = m.index_of(r.account, TimeEffect::delay);
      const double tau = fi < 0 ? 0 : std::exp(r.fit.x[fi]), delay = di < 0 ? 0 : std::exp(r.fit.x[di]);
      double square = 0;
      for (std::size_t k = 0; k < m.channels().size(); ++k) {
        if (force && m.channels()[k] == 2) continue;
        const auto ch = static_cast<std::size_t>(m.channels()[k]);
        double top = -1e300, bottom = 1e300, sd = 1;
        for (const TimeModel::Item& item : m.items())
          if (item.channel == static_cast<int>(k)) {
            const double v = m.measured()[static_cast<Eigen::Index>(&item - m.items().data())];
            top = std::max(top, v), bottom = std::min(bottom, v), sd = item.sd;
          }
        const double step = (top - bottom) / (sd * r.fit.noise[ch].scale), rho = r.fit.noise[ch].rho;
        double last = 0;
        for (int i = 0; i < 400; ++i) {
          const double t = (i + 0.5) * m.spacing();
          const double now = t < delay ? step : tau > 0 ? step * std::exp(-(t - delay) / tau) : 0;
          square += std::pow(now - rho * last, 2) / (1 - rho * rho), last = now;
        }
        if (force) break;
      }
      // ln odds of the truth ~ N(D^2/2, D^2)
      const double D = std::sqrt(square);
      const boost::math::normal normal;
      const double share = D > 0 ? boost::math::cdf(normal, D / 2 - std::log(decisive) / D) : 0;
      least = std::min(least, share);
    }
    // It decides only where each side is a single member.
    int with = 0;
    for (const TimeRival& r : members) with += sensor(r) ? 1 : 0;
    e.chance = with == 1 && members.size() == 2 ? least : 0;
    if (e.chance > 0) out.push_back(e);
  }
  return out;
}

}  // namespace grouser::diagnosis
