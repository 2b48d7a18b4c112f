#include "next_experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <set>

namespace grouser::diagnosis {
namespace {

constexpr int repeats = 4;

struct Predicted {
  Eigen::Vector3d y;
  Eigen::Matrix3d spread;
};

/// What a fitted rival says of a run that was not made.
bool predict(const Search& s, const Rival& r, const Eigen::MatrixXd& V, const Run& run, Predicted& out) {
  const Series& series = s.series();
  std::vector<int> touched;
  for (const Term& t : r.candidate.terms)
    if (t.input >= soil_count && t.input < soil_count + static_cast<int>(bekker::effect_count))
      touched.push_back(t.input - soil_count);
  Inputs in = plain_inputs(series.soil_of(r.fit.x));
  for (std::size_t t = 0; t < r.candidate.terms.size(); ++t)
    in[static_cast<std::size_t>(r.candidate.terms[t].input)] +=
        r.fit.x[series.soil_parameters() + static_cast<Eigen::Index>(t)];
  double theta = 0;
  Outputs y;
  Slopes d;
  if (!model_run(series.given().wheel, run, in, Wanted::soil_and_touched, touched, theta, y, &d)) return false;
  Eigen::MatrixXd J(channel_count, r.fit.x.size());
  for (int i = 0; i < series.soil_parameters(); ++i) J.col(i) = d.col(series.free_soil()[static_cast<std::size_t>(i)]);
  for (std::size_t t = 0; t < r.candidate.terms.size(); ++t)
    J.col(series.soil_parameters() + static_cast<Eigen::Index>(t)) = d.col(r.candidate.terms[t].input);
  for (int c = 0; c < channel_count; ++c) out.y[c] = y[static_cast<std::size_t>(c)];
  out.spread = J * V * J.transpose();
  for (std::size_t k = 0; k < scattered.size(); ++k)
    out.spread +=
        s.noise().omega[k] * s.noise().omega[k] / repeats * d.col(scattered[k]) * d.col(scattered[k]).transpose();
  return true;
}

template <class Get>
std::vector<double> levels(const std::vector<Run>& runs, Get get) {
  std::set<double> seen;
  for (const Run& r : runs) seen.insert(get(r));
  return {seen.begin(), seen.end()};
}

/// What the runs had, and what lies a step beyond.
std::vector<Run> possible(const std::vector<Run>& runs) {
  const std::vector<double> loads = levels(runs, [](const Run&r) { return r.load; }),
                            speeds = levels(runs, [](const Run&r) { return r.omega; });
  std::set<double> W{loads.front(), 0.5 * loads.front(), loads.back(), 2 * loads.back()},
      w{speeds.front(), speeds.back(), 3 * speeds.back(), speeds.front() / 3};
  std::vector<Run> out;
  for (const double load : W)
    for (const double omega : w)
      for (const double slip : {-0.5, -0.2, 0.0, 0.1, 0.3, 0.5, 0.7})
        for (const int pass : {1, 2}) {
          Run r;
          r.load = load, r.omega = omega, r.slip = slip, r.pass = pass;
          r.order = 0.5;
          out.push_back(r);
        }
  return out;
}

}  // namespace

std::vector<NextExperiment> next_experiments(const Search& s, const std::vector<std::string>& members) {
  std::vector<NextExperiment> out;
  std::vector<const Rival*> rivals;
  for (const Rival& r : s.rivals())
    if (r.refitted && r.fit.ok && r.candidate.named() &&
        (members.empty() ? rivals.size() < 2
                         : std::find(members.begin(), members.end(), r.candidate.id) != members.end()))
      rivals.push_back(&r);
  if (rivals.size() > 3) rivals.resize(3);
  std::vector<Eigen::MatrixXd> V;
  for (const Rival* r : rivals) V.push_back(s.covariance(r->fit));
  Eigen::Matrix3d sensor = Eigen::Matrix3d::Zero();
  std::array<bool, channel_count> has{};
  for (int i = 0; i < s.series().layout().size(); ++i)
    has[static_cast<std::size_t>(s.series().layout()[i].channel)] = true;
  for (std::size_t c = 0; c < channel_count; ++c) {
    const double sd = has[c] ? s.noise().scale[c] * s.stated_sd()[0][c] : 1e6;
    sensor(static_cast<int>(c), static_cast<int>(c)) = sd * sd / repeats;
  }
  struct Choice {
    double d;
    const Run* run;
  };
  const std::vector<Run> grid = possible(s.series().runs());
  std::vector<Choice> choices;
  if (rivals.size() >= 2)
    for (const Run& run : grid) {
      std::vector<Predicted> p(rivals.size());
      bool good = true;
      for (std::size_t i = 0; i < rivals.size() && good; ++i) good = predict(s, *rivals[i], V[i], run, p[i]);
      if (!good) continue;
      double worst = INFINITY;
      for (std::size_t b = 1; b < p.size(); ++b) {  // the most probable against each of the others, which refits
        const Eigen::Vector3d delta = p[0].y - p[b].y;
        const Eigen::Matrix3d C = sensor + 0.5 * (p[0].spread + p[b].spread);
        worst = std::min(worst, std::sqrt(std::max(delta.dot(C.ldlt().solve(delta)), 0.0)));
      }
      choices.push_back({worst, &run});
    }
  std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) { return a.d > b.d; });
  const boost::math::normal normal;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, choices.size()); ++i) {
    const Run& r = *choices[i].run;
    NextExperiment e;
    e.condition = {
        {"load_N", r.load}, {"slip", r.slip}, {"omega_rad_s", r.omega}, {"pass", static_cast<double>(r.pass)}};
    for (const Rival* m : rivals) e.decides.push_back(m->candidate.id);
    const double d = choices[i].d;
    e.chance = d > 1e-9 ? boost::math::cdf(normal, 0.5 * d - std::log(decisive) / d) : 0;
    e.runs = repeats;
    out.push_back(e);
  }
  for (const Rival* m : rivals)
    for (const int e : m->candidate.effects) {
      const EffectEntry& entry = effect_entries()[static_cast<std::size_t>(e)];
      if (!entry.bench_check) continue;
      NextExperiment check;
      check.bench_check = entry.bench_check;
      for (const Rival* o : rivals) check.decides.push_back(o->candidate.id);
      check.chance = 0.95;
      out.push_back(check);
    }
  return out;
}

}  // namespace grouser::diagnosis
