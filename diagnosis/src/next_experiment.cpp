#include "next_experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>
#include <set>

#include "bench_check.h"
#include "chance.h"

namespace grouser::diagnosis {
namespace {

constexpr std::array<int, 3> repeats{4, 8, 12};
constexpr std::array<int, 3> readings{4, 8, 16};  // of a bench check
constexpr int full_draws = 8;
constexpr double wanted = 0.9;
constexpr std::size_t most_members = 4, shown = 3;

struct Member {
  const Rival* rival;
  Eigen::MatrixXd V;
};

/// One holds all effects of the other: no run decides between a cause and the same cause with a trace of a second.
bool nested(const Member& a, const Member& b) {
  const auto holds = [](const std::vector<int>& all, const std::vector<int>& some) {
    return std::all_of(some.begin(), some.end(),
                       [&](int e) { return std::find(all.begin(), all.end(), e) != all.end(); });
  };
  const auto &x = a.rival->candidate.effects, &y = b.rival->candidate.effects;
  return holds(x, y) || holds(y, x);
}

/// What a fitted member says of a run that was not made: value, its spread by the fit, and scatter of the soil.
struct Said {
  Eigen::Vector3d y;
  Eigen::Matrix3d spread, scatter;
};

bool say(const Search& s, const Member& m, const Run& run, double width, Said& out) {
  const Series& series = s.series();
  const Candidate& c = m.rival->candidate;
  const Inputs in = series.inputs_of(c, m.rival->fit.x, 0);
  double theta = 0;
  Outputs y;
  Slopes d;
  bekker::EffectWheel wheel = series.given().wheel;
  wheel.width *= width;
  if (!model_run(wheel, run, in, Wanted::soil_and_touched, series.touched(c), theta, y, &d)) return false;
  Eigen::MatrixXd J(channel_count, m.rival->fit.x.size());
  for (int i = 0; i < series.soil_parameters(); ++i) J.col(i) = d.col(series.parameter(i).input);
  for (std::size_t t = 0; t < c.terms.size(); ++t)
    J.col(series.soil_parameters() + static_cast<Eigen::Index>(t)) = d.col(c.terms[t].input);
  for (int k = 0; k < channel_count; ++k) out.y[k] = y[static_cast<std::size_t>(k)];
  out.spread = J * m.V * J.transpose();
  out.scatter.setZero();
  for (std::size_t k = 0; k < scattered.size(); ++k)
    out.scatter += s.noise().omega[k] * s.noise().omega[k] * d.col(scattered[k]) * d.col(scattered[k]).transpose();
  return true;
}

template <class Get>
std::vector<double> levels(const std::vector<Run>& runs, Get get) {
  std::set<double> seen;
  for (const Run& r : runs) seen.insert(get(r));
  return {seen.begin(), seen.end()};
}

struct Choice {
  Run run;
  double width = 1;  ///< of another wheel, over that of this one
  int repeats = 0;
  double chance = 0, cost = 0;
};

/// Runs that the rig had, and a step beyond: half and double load, a third and three times the speed, a wheel twice as wide. Speed and pass only where a
/// member looks at them. cost: without the repeats.
std::vector<Choice> possible(const Search& s, const std::vector<Member>& members) {
  const std::vector<Run>& runs = s.series().runs();
  const std::vector<double> loads = levels(runs, [](const Run&r) { return r.load; }),
                            speeds = levels(runs, [](const Run&r) { return r.omega; });
  bool speed = false, pass = false;
  for (const Member& m : members)
    for (const Term& t : m.rival->candidate.terms) {
      speed = speed || t.input == input_of(bekker::Effect::pressure_rate) ||
              t.input == input_of(bekker::Effect::shear_rate) || t.input == input_of(Map::torque_viscous);
      pass = pass || t.input == input_of(bekker::Effect::repetitive_loading) ||
             t.input == input_of(bekker::Effect::pass_strength);
    }
  std::set<double> W{loads.front(),       loads[loads.size() / 2], loads.back(),
                     0.5 * loads.front(), 1.5 * loads.back(),      2 * loads.back()},
      w{speeds[speeds.size() / 2]};
  if (speed) w.insert({speeds.front(), speeds.back(), speeds.front() / 3, 3 * speeds.back()});
  std::vector<Choice> out;
  for (const double load : W)
    for (const double omega : w)
      for (const double slip : {-0.7, -0.5, -0.3, -0.1, -0.05, 0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9})
        for (int p = 1; p <= (pass ? 2 : 1); ++p) {
          Choice c;
          c.run.load = load, c.run.omega = omega, c.run.slip = c.run.stated_slip = slip, c.run.pass = p;
          c.run.order = 0.5;
          c.cost = (load < loads.front() || load > loads.back() ? 2 : 0) +
                   (omega < speeds.front() || omega > speeds.back() ? 2 : 0);
          out.push_back(c);
          if (p > 1 || (load != loads.front() && load != loads.back())) continue;
          c.width = 2, c.cost += 6;
          out.push_back(c);
        }
  return out;
}

/// Least share of draws in which the member that is true gets ten times the probability of every other that is not nested with it.
double chance_of(const std::vector<Member>& members, const std::vector<Said>& said, const std::vector<double>& ln_prior,
                 const Eigen::Matrix3d& sensor, int n) {
  std::vector<Eigen::Vector3d> mean;
  std::vector<Eigen::Matrix3d> covariance;
  for (const Said& x : said) {
    mean.push_back(x.y);
    covariance.push_back((sensor + x.scatter) / n + x.spread);
  }
  return chance_to_decide(mean, covariance, ln_prior, decisive,
                          [&](std::size_t m, std::size_t truth) { return nested(members[m], members[truth]); });
}

/// Old and new runs together, each member refitted: how often the true one ends at ten times the others.
double simulate(const Search& s, const std::vector<Member>& members, const std::vector<double>& ln_prior,
                const Choice& c) {
  std::vector<Run> runs = s.series().runs();
  auto sd = s.stated_sd();
  const auto usual = s.usual_sd();
  Noise noise = s.noise();
  int batch = 0;
  for (const Run& r : runs) batch = std::max(batch, r.batch);
  const std::size_t old = runs.size();
  for (int k = 0; k < c.repeats; ++k) {
    runs.push_back(c.run);
    runs.back().batch = ++batch;
    for (std::size_t ch = 0; ch < channel_count; ++ch)
      runs.back().value[ch] = usual[ch] > 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
    sd.push_back(usual);
    noise.weight.push_back(1);
  }
  int decided = 0, tried = 0;
  for (std::size_t truth = 0; truth < members.size(); ++truth) {
    const Member& m = members[truth];
    std::mt19937_64 random(4711 + truth);
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(m.V).matrixL();
    for (int k = 0; k < full_draws / static_cast<int>(members.size()); ++k) {
      Eigen::VectorXd e(root.cols());
      for (Eigen::Index i = 0; i < e.size(); ++i) e[i] = normal(random);
      const Eigen::VectorXd x = m.rival->fit.x + root * e;
      double unused = 0;
      Outputs y;
      const Inputs in = s.series().inputs_of(m.rival->candidate, x, 0);
      if (!model_run(s.series().given().wheel, c.run, in, Wanted::value, {}, unused, y, nullptr)) continue;
      for (std::size_t r = old; r < runs.size(); ++r)
        for (std::size_t ch = 0; ch < channel_count; ++ch)
          if (usual[ch] > 0) runs[r].value[ch] = y[ch] + normal(random) * noise.scale[ch] * usual[ch];
      const Series both(s.series().given(), runs, sd);
      const Eigen::MatrixXd J = both.scatter_slopes(m.rival->candidate, m.rival->fit);
      const Whitener w(both.layout(), noise, J);
      std::vector<double> theta = m.rival->fit.theta;
      theta.resize(runs.size(), 0.0);
      double own = -INFINITY, other = -INFINITY;
      for (std::size_t o = 0; o < members.size(); ++o) {
        const Fit f = both.fit(members[o].rival->candidate, w, members[o].rival->fit.x, theta, 6);
        const double score = f.ok ? ln_prior[o] - 0.5 * (f.objective() - members[o].rival->fit.objective()) : -INFINITY;
        if (o == truth)
          own = score;
        else if (!nested(members[o], m))
          other = std::max(other, score);
      }
      ++tried;
      decided += own - other > std::log(decisive) ? 1 : 0;
    }
  }
  return tried > 0 ? static_cast<double>(decided) / tried : 0;
}

/// Whether more readings make a check better: a balance, a level and a tape have an error of their own.
bool read_by_sensor(int entry) {
  const auto map = static_cast<Map>(entry - model_effects);
  return map != Map::bed_slope && map != Map::wheel_radius_error && map != Map::load_error;
}

/// Bench checks of the sensor effects among the members.
std::vector<NextExperiment> bench_checks(const Search& s, const std::vector<Member>& members) {
  std::vector<NextExperiment> out;
  for (const Member& m : members) {
    if (m.rival->candidate.effects.size() != 1) continue;
    const int entry = m.rival->candidate.effects[0];
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
    if (!e.bench_check) continue;
    NextExperiment check;
    check.bench_check = e.bench_check;
    check.bench_effect = e.id;
    for (const Member& o : members) check.decides.push_back(o.rival->candidate.id);
    const Eigen::Index i = s.series().soil_parameters();
    for (const int n : readings) {
      const double error = bench_sd(s, entry) * (read_by_sensor(entry) ? std::sqrt(4.0 / n) : 1);
      check.runs = n;
      check.chance = bench_chance(m.rival->fit.x[i], std::sqrt(std::max(m.V(i, i), 0.0)), error);
      if (check.chance >= wanted || !read_by_sensor(entry)) break;
    }
    check.cost = 1;
    // Shows this member or clears it: among three that leaves two.
    if (members.size() > 2) check.decides = {e.id, "the others"};
    out.push_back(check);
  }
  return out;
}

}  // namespace

std::vector<NextExperiment> next_experiments(const Search& s, const std::vector<std::string>& ids) {
  std::vector<Member> members;
  for (const Rival& r : s.rivals())
    if (r.refitted && r.fit.ok && r.candidate.named() && members.size() < (ids.empty() ? 2 : most_members) &&
        (ids.empty() || std::find(ids.begin(), ids.end(), r.candidate.id) != ids.end()))
      members.push_back({&r, s.covariance(r.fit)});
  if (members.empty()) return {};
  std::vector<NextExperiment> out = bench_checks(s, members);
  if (members.size() < 2) return out;
  std::vector<double> ln_prior;
  for (const Member& m : members) ln_prior.push_back(std::log(std::max(m.rival->posterior, 1e-9)));
  Eigen::Matrix3d sensor = Eigen::Matrix3d::Zero();
  for (int c = 0; c < channel_count; ++c) {
    const auto ch = static_cast<std::size_t>(c);
    const double usual = s.usual_sd()[ch], sd = usual > 0 ? s.noise().scale[ch] * usual : 1e6;
    sensor(c, c) = sd * sd;
  }
  std::vector<Choice> choices;
  for (const Choice& c : possible(s, members)) {
    std::vector<Said> said(members.size());
    bool good = true;
    for (std::size_t i = 0; i < members.size() && good; ++i) good = say(s, members[i], c.run, c.width, said[i]);
    if (!good) continue;
    Choice best = c;
    for (const int n : repeats) {
      best.repeats = n;
      best.chance = chance_of(members, said, ln_prior, sensor, n);
      if (best.chance >= wanted) break;
    }
    best.cost += best.repeats;
    choices.push_back(best);
  }
  // Those that decide come first, the cheapest of them before the surest; else the surest.
  std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
    const bool x = a.chance >= wanted, y = b.chance >= wanted;
    if (x != y) return x;
    if (x && a.cost != b.cost) return a.cost < b.cost;
    return a.chance > b.chance;
  });
  std::vector<NextExperiment> runs;
  for (std::size_t i = 0; i < std::min(shown, choices.size()); ++i) {
    const Run& r = choices[i].run;
    NextExperiment e;
    e.condition = {
        {"load_N", r.load}, {"slip", r.slip}, {"omega_rad_s", r.omega}, {"pass", static_cast<double>(r.pass)}};
    for (const Member& m : members) e.decides.push_back(m.rival->candidate.id);
    e.chance = choices[i].chance, e.cost = choices[i].cost, e.runs = choices[i].repeats;
    if (choices[i].width > 1) e.condition["wheel_width_m"] = s.series().given().wheel.width * choices[i].width;
    if (i == 0 && choices[i].width == 1) e.simulated = simulate(s, members, ln_prior, choices[i]);
    runs.push_back(e);
  }
  // A bench check that settles the class costs less than runs on soil.
  out.insert(out.end(), runs.begin(), runs.end());
  std::stable_sort(out.begin(), out.end(), [&](const NextExperiment& a, const NextExperiment& b) {
    const auto settles = [&](const NextExperiment& e) {
      return e.chance >= wanted && (e.bench_check.empty() || members.size() == 2);
    };
    if (settles(a) != settles(b)) return settles(a);
    if (settles(a) && a.cost != b.cost) return a.cost < b.cost;
    return a.chance > b.chance;
  });
  return out;
}

}  // namespace grouser::diagnosis
