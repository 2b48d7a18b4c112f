#include <algorithm>
#include <cmath>
#include <map>

#include "grouser/diagnosis/time_series.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"

namespace grouser::diagnosis {

const std::array<TimeEffectInfo, time_effect_count>& time_effects() {
  static const std::array<TimeEffectInfo, time_effect_count> list{
      {{"relaxation_length", "m", "the soil answers a change only after some travel"},
       {"filter", "s", "a sensor or the drive smooths in time, by first order"},
       {"delay", "s", "a sensor or the drive is late"},
       {"ripple", "N", "the lugs are felt one by one"}}};
  return list;
}

std::string TimeOptions::relaxation_over() const {
  return over == Over::travel ? "travel" : over == Over::rim ? "rim" : "larger";
}

bool is_time_case(const std::filesystem::path& yaml) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  return document.root().has("series");
}

TimeCase read_time_case(const std::filesystem::path& yaml) {
  TimeCase c;
  c.steady = read_case(yaml);
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode series = document.root().map("series");
  TimeOptions& o = c.options;
  o.lugs = static_cast<int>(series.integer_or("lugs", 0, 0, 1000));
  const std::string over = series.choice_or("relaxation_over", "travel", {"travel", "rim", "larger"});
  o.over = over == "travel" ? TimeOptions::Over::travel
           : over == "rim"  ? TimeOptions::Over::rim
                            : TimeOptions::Over::larger;
  o.free_start = series.choice_or("start", "steady", {"steady", "free"}) == "free";
  const ConfigNode scatter = series.optional_map("preparation");
  if (scatter.present()) {
    o.scatter[0] = scatter.quantity_or("ln_k_sd", 0, "1", Range::non_negative());
    o.scatter[1] = scatter.quantity_or("phi_sd", 0, "rad", Range::non_negative());
    scatter.text_or("source", "");
    scatter.finish();
  }
  const ConfigNode effects = series.node("effects");
  if (effects.present() && !(effects.is_scalar() && effects.as_text() == "all")) {
    std::vector<std::string> known;
    for (const TimeEffectInfo& e : time_effects()) known.emplace_back(e.id);
    o.considered.fill(false);
    if (!effects.is_list()) effects.error("series.effects: all, or a list of delay, filter, relaxation_length, ripple");
    for (const ConfigNode& item : effects.is_list() ? effects.items() : std::vector<ConfigNode>{}) {
      const std::string id = item.as_text();
      const auto found = std::find(known.begin(), known.end(), id);
      const auto near = did_you_mean(id, known);
      if (found == known.end())
        item.error("no effect of a series '" + id + "'" +
                   (near ? "; did you mean '" + *near + "'?" : ": delay, filter, relaxation_length, ripple"));
      else
        o.considered[static_cast<std::size_t>(found - known.begin())] = true;
    }
    if (o.considered[static_cast<int>(TimeEffect::ripple)] && o.lugs == 0)
      effects.error("ripple needs series.lugs, the number of lugs of the wheel");
  }
  if (o.lugs == 0) o.considered[static_cast<int>(TimeEffect::ripple)] = false;
  series.finish();
  document.check();
  return c;
}

TimeTable read_time_table(const std::filesystem::path& csv, const TimeCase& c) {
  TimeTable t;
  t.rows = read_runs(csv, c.steady);
  FileErrors errors(csv);
  if (!t.rows.has_time)
    errors.add(1, 1, "column 'time_s' is missing: the case has the key 'series', so rows are moments of a run");
  if (!t.rows.has_omega)
    errors.add(1, 1, "column 'omega_rad_s' is missing: travel and the angle turned follow from it");
  errors.check();
  if (!t.rows.has_batch)
    std::erase_if(t.rows.notes, [](const std::string& n) { return n.find("'batch'") != std::string::npos; });
  std::erase_if(t.rows.notes, [](const std::string& n) { return n.find("'order'") != std::string::npos; });
  if (!t.rows.has_batch) {
    t.rows.notes.emplace_back("no column 'batch': all rows are one run");
    for (Run& r : t.rows.runs) r.batch = 0;
  }
  std::map<int, TimeRun> by_batch;
  const double radius = c.steady.wheel.radius;
  for (Run r : t.rows.runs) {
    r.cells["batch"] = r.batch + 1;
    TimeRun& run = by_batch[r.batch];
    if (!run.rows.empty() && !(r.time > run.rows.back().time))
      errors.add(r.line, 1,
                 "time does not rise: the row before of this run is line " + std::to_string(run.rows.back().line) +
                     "; sort the rows, or tell the runs apart by a column 'batch'");
    const bool locked = r.slip <= -1;
    const double rim = locked ? 0 : r.omega * radius;
    double travel = locked ? r.omega * radius : r.slip < 0 ? rim / (1 + r.slip) : rim * (1 - r.slip);
    if (locked && !(travel > 0))
      errors.add(r.line, 1, "a locked wheel (slip -1) needs its speed of travel: add the column 'travel_speed_m_s'");
    if (r.omega < 0) errors.add(r.line, 1, "omega is negative; a series is of a wheel that rolls forward");
    if (locked) r.omega = 0;
    run.travel.push_back(travel);
    run.rim.push_back(rim);
    const double before =
        run.rows.empty() ? 0 : 0.5 * (run.rows.back().omega + r.omega) * (r.time - run.rows.back().time);
    run.turn.push_back(run.rows.empty() ? 0 : run.turn.back() + before);
    run.rows.push_back(std::move(r));
  }
  for (auto& [batch, run] : by_batch) {
    if (run.rows.size() < 12)
      errors.add(run.rows[0].line, 1,
                 "the run that begins here has " + std::to_string(run.rows.size()) +
                     " rows; fewer than 12 say nothing of its dynamics");
    std::vector<double> steps;
    for (std::size_t i = 1; i < run.rows.size(); ++i) steps.push_back(run.rows[i].time - run.rows[i - 1].time);
    if (steps.empty()) continue;
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    run.spacing = steps[steps.size() / 2];
    t.runs.push_back(std::move(run));
  }
  errors.check();
  return t;
}

}  // namespace grouser::diagnosis
