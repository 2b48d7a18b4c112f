#include "grouser/diagnosis/design.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "candidates.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"

namespace grouser::diagnosis {
namespace {

constexpr double named_distance = 6;

/// Scores of every effect of the case for a plan; the order of the effects is that of `ids`.
struct Judged {
  std::vector<int> entries;
  std::vector<std::vector<double>> likeness;
  std::vector<double> distance;
  std::size_t alike = 0;
  bool good = false;
};

Judged judge(const DiagnosisCase& c, const RunTable& plan, const std::vector<Run>& runs) {
  Judged out;
  std::vector<std::array<double, channel_count>> sd;
  for (const Run& r : runs) sd.push_back(r.sd);
  const Series series(c, runs, sd);
  Noise noise;
  noise.weight.assign(runs.size(), 1);
  const Whitener w(series.layout(), noise, Eigen::MatrixXd::Zero(series.layout().size(), 2));
  std::vector<Candidate> effects;
  out.entries = visible_effects(c, plan, runs);
  for (const int e : out.entries) effects.push_back(effect_candidate(e));
  const Fit at_mean = series.fit(nominal_candidate(), w, series.prior_mean(), std::vector<double>(runs.size(), 0.0), 0);
  if (!at_mean.ok) return out;
  const ScoreTable scores(series, nominal_candidate(), at_mean, w, effects);
  if (!scores.ok()) return out;
  out.good = true;
  for (std::size_t a = 0; a < effects.size(); ++a) {
    out.distance.push_back(scores.visible(a));
    out.likeness.emplace_back();
    for (std::size_t b = 0; b < effects.size(); ++b) {
      out.likeness[a].push_back(a == b ? 1 : scores.likeness(a, b));
      if (b < a && out.likeness[a][b] > alike_limit) ++out.alike;
    }
  }
  return out;
}

std::vector<Run> addable(const RunTable& plan) {
  std::set<double> loads, speeds;
  int passes = 1;
  for (const Run& r : plan.runs) loads.insert(r.load), speeds.insert(r.omega), passes = std::max(passes, r.pass);
  const double low = *loads.begin(), high = *loads.rbegin();
  std::vector<Run> out;
  for (const double load : {0.5 * low, low, high, 2 * high})
    for (const double omega : {*speeds.begin() / 3, *speeds.rbegin(), 3 * *speeds.rbegin()})
      for (const double slip : {-0.5, 0.0, 0.1, 0.3, 0.7})
        for (int pass = 1; pass <= passes; ++pass) {
          Run r = plan.runs[0];
          r.load = load, r.omega = omega, r.slip = r.stated_slip = slip, r.pass = pass, r.order = 0.5;
          out.push_back(r);
        }
  return out;
}

}  // namespace

Design judge_design(const DiagnosisCase& c, const RunTable& plan) {
  const Judged now = judge(c, plan, plan.runs);
  if (!now.good)
    throw ConfigError(plan.file.string(), 0, 0,
                      "the wheel carries the load of no run, or not of all of them, at the prior means of the soil; "
                      "check loads, units and reference_width");
  Design d;
  d.runs = static_cast<int>(plan.runs.size());
  d.notes = plan.notes;
  d.notes.insert(d.notes.end(), c.notes.begin(), c.notes.end());
  d.likeness = now.likeness;
  d.alike_pairs = now.alike;
  std::vector<std::size_t> cluster(now.entries.size());
  for (std::size_t i = 0; i < cluster.size(); ++i) cluster[i] = i;
  for (std::size_t a = 0; a < cluster.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (now.likeness[a][b] > alike_limit && cluster[a] != cluster[b])
        std::replace(cluster.begin(), cluster.end(), cluster[a], cluster[b]);
  std::size_t invisible = 0;
  for (std::size_t i = 0; i < now.entries.size(); ++i) {
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(now.entries[i])];
    DesignEffect x{e.id, e.unit, 0, now.distance[i], 0, true};
    const double size = e.typical - e.off,
                 needed = now.distance[i] > 1e-6 ? size * named_distance / now.distance[i] : INFINITY;
    const auto show = [&](double amplitude) {
      return e.inverse ? (amplitude > 0 ? 1 / amplitude : INFINITY) : (e.off + amplitude) * e.shown;
    };
    x.typical = show(size);
    x.smallest = show(needed);
    x.within_bounds = e.off + needed >= e.lower && e.off + needed <= e.upper;
    invisible += x.within_bounds ? 0 : 1;
    d.effects.push_back(x);
  }
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    std::vector<std::string> members;
    for (std::size_t k = 0; k < cluster.size(); ++k)
      if (cluster[k] == cluster[i]) members.push_back(d.effects[k].id);
    if (members.size() > 1 && members[0] == d.effects[i].id) d.clusters.push_back(members);
  }
  struct Tried {
    std::size_t alike;
    double total;
    DesignRun run;
  };
  std::vector<Tried> tried;
  for (const Run& extra : addable(plan)) {
    std::vector<Run> runs = plan.runs;
    DesignRun add;
    int batch = 0;
    for (const Run& r : runs) batch = std::max(batch, r.batch);
    for (int k = 0; k < add.repeats; ++k) runs.push_back(extra), runs.back().batch = ++batch;
    const Judged then = judge(c, plan, runs);
    if (!then.good || then.entries.size() != now.entries.size()) continue;
    add.condition = {{"load_N", extra.load},
                     {"slip", extra.slip},
                     {"omega_rad_s", extra.omega},
                     {"pass", static_cast<double>(extra.pass)}};
    add.alike_pairs = then.alike;
    double total = 0;
    for (std::size_t a = 0; a < then.likeness.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (now.likeness[a][b] > 0.8) total += then.likeness[a][b];
    tried.push_back({then.alike, total, add});
  }
  std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) {
    return a.alike != b.alike ? a.alike < b.alike : a.total < b.total;
  });
  for (std::size_t i = 0; i < std::min<std::size_t>(3, tried.size()); ++i) d.add.push_back(tried[i].run);
  d.sentence = "With these " + std::to_string(d.runs) + " runs " + std::to_string(d.alike_pairs) +
               " pairs of effects look alike to a few per cent, and " + std::to_string(invisible) + " of " +
               std::to_string(d.effects.size()) + " effects would have to be larger than physics allows to be seen.";
  return d;
}

RunTable grid_plan(const std::string& text) {
  const auto wrong = [](const std::string& what) { return ConfigError("--plan", 0, 0, what); };
  std::map<std::string, std::vector<double>> axis{{"slip", {}},         {"load_N", {}},      {"omega_rad_s", {0.3}},
                                                  {"pass", {1}},        {"repeats", {1}},    {"drawbar_sd_N", {}},
                                                  {"torque_sd_Nm", {}}, {"sinkage_sd_m", {}}};
  std::vector<std::string> known;
  for (const auto& [name, values] : axis) known.push_back(name);
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    at = end + 1;
    if (word.empty()) continue;
    const std::size_t eq = word.find('=');
    const std::string name = word.substr(0, eq);
    if (eq == std::string::npos || axis.count(name) == 0) {
      const auto near = did_you_mean(name, known);
      throw wrong("'" + word + "' is not understood" + (near ? "; did you mean '" + *near + "=...'?" : "") +
                  "; a file ending in .csv, or words like slip=-0.5,0,0.5 load_N=60,225 pass=1,2 drawbar_sd_N=2");
    }
    axis[name].clear();
    for (std::size_t from = eq + 1; from <= word.size();) {
      const std::size_t comma = std::min(word.find(',', from), word.size());
      const auto x = parse_number(word.substr(from, comma - from));
      if (!x) throw wrong("'" + word.substr(from, comma - from) + "' in '" + word + "' is not a number");
      axis[name].push_back(*x);
      from = comma + 1;
    }
  }
  RunTable t;
  t.file = "--plan";
  t.has_omega = t.has_order = t.has_batch = true;
  if (axis["slip"].empty() || axis["load_N"].empty()) throw wrong("a grid needs slip=... and load_N=...");
  for (std::size_t k = 0; k < channel_count; ++k)
    t.measured[k] = t.stated_sd[k] = !axis[channel_names()[k].sd_column].empty();
  if (!t.measured[0] && !t.measured[1] && !t.measured[2])
    throw wrong("nothing would be measured: give drawbar_sd_N=..., torque_sd_Nm=... or sinkage_sd_m=...");
  for (const double load : axis["load_N"])
    for (const double omega : axis["omega_rad_s"])
      for (const double pass : axis["pass"])
        for (const double slip : axis["slip"])
          for (int k = 0; k < static_cast<int>(axis["repeats"][0]); ++k) {
            if (!(std::abs(slip) <= 1) || !(load > 0)) throw wrong("slip must be within -1..1 and load_N above 0");
            Run r;
            r.slip = r.stated_slip = slip, r.load = load, r.omega = omega, r.pass = static_cast<int>(pass);
            r.batch = r.condition = static_cast<int>(t.runs.size());
            for (std::size_t c = 0; c < channel_count; ++c) {
              r.value[c] = t.measured[c] ? 0 : std::numeric_limits<double>::quiet_NaN();
              r.sd[c] = t.measured[c] ? axis[channel_names()[c].sd_column][0] : r.value[c];
            }
            t.runs.push_back(r);
          }
  // An order that is not aligned with any condition: steps of a golden section.
  for (std::size_t i = 0; i < t.runs.size(); ++i)
    t.runs[i].order = std::fmod(0.6180339887498949 * static_cast<double>(i), 1.0);
  return t;
}

}  // namespace grouser::diagnosis
