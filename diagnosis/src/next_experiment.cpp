#include "next_experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <random>
#include <set>

#include "bench_check.h"
#include "chance.h"

namespace grouser::diagnosis {
namespace {

constexpr std::array<int, 3> repeats{4, 8, 12};
constexpr std::array<int, 2> many_repeats{24, 48};  // where twelve decide nothing
constexpr std::array<int, 3> readings{4, 8, 16};    // of a bench check
constexpr int full_draws = 24;
constexpr double wanted = 0.95;  // foretold by slopes, which is somewhat too good: simulated, `enough` is left
constexpr std::size_t most_members = 4, shown = 3, simulated = 3, most_again = 6;

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
  if (!model_run({wheel, series.given()}, run, in, Wanted::soil_and_touched, series.touched(c), theta, y, &d))
    return false;
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
  std::optional<double> simulated = std::nullopt;
};

/// Runs that the rig had, and a step beyond: half and double load, a third and three times the speed, a wheel twice as wide. Speed and pass only where a
/// member looks at them. cost: without the repeats.
/// further: also a quarter, three and four times the load, a wheel half as wide, and another width at every load.
std::vector<Choice> possible(const Search& s, const std::vector<Member>& members, bool further) {
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
  if (further) W.insert({0.25 * loads.front(), 3 * loads.back(), 4 * loads.back()});
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
          if (!further && (p > 1 || (load != loads.front() && load != loads.back()))) continue;
          c.cost += 6;
          for (const double width : {2.0, 0.5}) {
            c.width = width;
            if (width > 1 || further) out.push_back(c);
          }
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

/// Old and new runs together, each member refitted: how often the true one ends at ten times the others, whichever is true.
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
  double least = 1;
  for (std::size_t truth = 0; truth < members.size(); ++truth) {
    const Member& m = members[truth];
    int decided = 0, tried = 0;
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
      if (!model_run(s.series().given(), c.run, in, Wanted::value, {}, unused, y, nullptr)) continue;
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
    least = std::min(least, tried > 0 ? static_cast<double>(decided) / tried : 0);
  }
  return least;
}

/// Whether more readings make a check better: a balance, a level and a tape have an error of their own.
bool read_by_sensor(int entry) {
  const auto map = static_cast<Map>(entry - model_effects);
  return map != Map::bed_slope && map != Map::wheel_radius_error && map != Map::load_error;
}

/// Bench checks of the sensor effects that some members have and others have not.
std::vector<NextExperiment> bench_checks(const Search& s, const std::vector<Member>& members) {
  std::vector<NextExperiment> out;
  std::set<int> asked;
  for (const Member& m : members)
    for (std::size_t t = 0; t < m.rival->candidate.effects.size(); ++t) {
      const int entry = m.rival->candidate.effects[t];
      const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
      const auto has = [&](const Member& o) {
        const std::vector<int>& all = o.rival->candidate.effects;
        return std::find(all.begin(), all.end(), entry) != all.end();
      };
      if (!e.bench_check || (members.size() > 1 && std::all_of(members.begin(), members.end(), has)) ||
          !asked.insert(entry).second)
        continue;
      NextExperiment check;
      check.bench_check = e.bench_check;
      check.bench_effect = e.id;
      for (const Member& o : members) check.decides.push_back(o.rival->candidate.id);
      const Eigen::Index i = s.series().soil_parameters() + static_cast<Eigen::Index>(t);
      for (const int n : readings) {
        const double error = bench_sd(s, entry) * (read_by_sensor(entry) ? std::sqrt(4.0 / n) : 1);
        check.runs = n;
        check.chance = bench_chance(m.rival->fit.x[i], std::sqrt(std::max(m.V(i, i), 0.0)), error);
        if (check.chance >= wanted || !read_by_sensor(entry)) break;
      }
      check.cost = 1;
      // Shows this effect or clears it: among three that leaves two.
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
  const auto judged = [&](const Choice& c, const auto& counts) -> std::optional<Choice> {
    std::vector<Said> said(members.size());
    for (std::size_t i = 0; i < members.size(); ++i)
      if (!say(s, members[i], c.run, c.width, said[i])) return std::nullopt;
    Choice best = c;
    for (const int n : counts) {
      best.repeats = n;
      best.chance = chance_of(members, said, ln_prior, sensor, n);
      if (best.chance >= wanted) break;
    }
    best.cost += best.repeats;
    return best;
  };
  // Those that decide come first, the cheapest of them before the surest; else the surest.
  const auto better = [](const Choice& a, const Choice& b) {
    const bool x = a.chance >= wanted, y = b.chance >= wanted;
    if (x != y) return x;
    if (x && a.cost != b.cost) return a.cost < b.cost;
    return a.chance > b.chance;
  };
  std::vector<Choice> choices;
  for (const Choice& c : possible(s, members, false))
    if (const auto j = judged(c, repeats)) choices.push_back(*j);
  std::stable_sort(choices.begin(), choices.end(), better);
  // Nothing decides: other loads and wheels, then many repeats of what is surest.
  const bool bench_decides = members.size() == 2 && std::any_of(out.begin(), out.end(), [](const NextExperiment& e) {
                               return e.chance >= wanted;
                             });
  if (!bench_decides && !s.series().given().rig.model() && (choices.empty() || choices[0].chance < wanted)) {
    for (const Choice& c : possible(s, members, true))
      if (const auto j = judged(c, repeats)) choices.push_back(*j);
    std::stable_sort(choices.begin(), choices.end(), better);
    if (!choices.empty() && choices[0].chance < wanted) {
      const std::size_t n = std::min(most_again, choices.size());
      for (std::size_t i = 0; i < n; ++i) {
        Choice c = choices[i];
        c.cost -= c.repeats;
        const auto j = judged(c, many_repeats);
        if (j && j->chance >= wanted) choices.push_back(*j);
      }
      std::stable_sort(choices.begin(), choices.end(), better);
    }
  }
  // The first few again with refits of old and new runs; what that says is the chance. Another width is another wheel: not refitted.
  const std::size_t tried = bench_decides ? 0 : std::min(simulated, choices.size());
  for (std::size_t i = 0; i < tried; ++i)
    if (choices[i].width == 1 && choices[i].chance > 0.3) {
      choices[i].simulated = simulate(s, members, ln_prior, choices[i]);
      choices[i].chance = std::min(choices[i].chance, *choices[i].simulated);
      if (choices[i].chance >= enough) break;
    }
  std::stable_sort(choices.begin(), choices.begin() + static_cast<std::ptrdiff_t>(tried),
                   [](const Choice& a, const Choice& b) { return a.chance > b.chance; });
  std::vector<NextExperiment> runs;
  for (std::size_t i = 0; i < std::min(shown, choices.size()); ++i) {
    const Run& r = choices[i].run;
    NextExperiment e;
    e.condition = {
        {"load_N", r.load}, {"slip", r.slip}, {"omega_rad_s", r.omega}, {"pass", static_cast<double>(r.pass)}};
    for (const Member& m : members) e.decides.push_back(m.rival->candidate.id);
    e.chance = choices[i].chance, e.cost = choices[i].cost, e.runs = choices[i].repeats;
    if (choices[i].width > 1) e.condition["wheel_width_m"] = s.series().given().wheel.width * choices[i].width;
    e.simulated = choices[i].simulated;
    runs.push_back(e);
  }
  // A bench check that settles the class costs less than runs on soil.
  out.insert(out.end(), runs.begin(), runs.end());
  std::stable_sort(out.begin(), out.end(), [&](const NextExperiment& a, const NextExperiment& b) {
    const auto settles = [&](const NextExperiment& e) {
      return e.chance >= enough && (e.bench_check.empty() || members.size() == 2);
    };
    if (settles(a) != settles(b)) return settles(a);
    if (settles(a) && a.cost != b.cost) return a.cost < b.cost;
    return a.chance > b.chance;
  });
  return out;
}

}  // namespace grouser::diagnosis
