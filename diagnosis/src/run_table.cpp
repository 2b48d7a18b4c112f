#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "grouser/diagnosis/design.h"
#include "grouser/diagnosis/runs.h"
#include "grouser/diagnosis/wheel_fit.h"
#include "grouser/terrain/csv.h"

namespace grouser::diagnosis {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A quantity by the beginning of its column's name; the rest is its unit.
struct Quantity {
  const char *base, *unit, *written;  ///< written: the name as the interface has it
};
constexpr Quantity quantities[] = {{"slip_radius", "m", "slip_radius_m"}, {"load", "N", "load_N"},
                                   {"omega", "rad/s", "omega_rad_s"},     {"travel_speed", "m/s", "travel_speed_m_s"},
                                   {"slope", "rad", "slope_deg"},         {"time", "s", "time_s"},
                                   {"drawbar", "N", "drawbar_N"},         {"torque", "N m", "torque_Nm"},
                                   {"sinkage", "m", "sinkage_m"},         {"drawbar_sd", "N", "drawbar_sd_N"},
                                   {"torque_sd", "N m", "torque_sd_Nm"},  {"sinkage_sd", "m", "sinkage_sd_m"}};
constexpr const char* plain[] = {"slip", "slip_definition", "pass", "order", "wheel", "batch", "replicate"};

/// Units as file headers write them.
std::optional<double> scale_of(std::string suffix, const char* wanted) {
  if (suffix == "Nm") suffix = "N m";
  if (suffix == "rad_s") suffix = "rad/s";
  if (suffix == "deg_s") suffix = "deg/s";
  if (suffix == "m_s") suffix = "m/s";
  if (suffix == "mm_s") suffix = "mm/s";
  try {
    const UnitScale u = parse_unit(suffix);
    if (u.compatible(parse_unit(wanted))) return u.scale;
  } catch (const std::invalid_argument&) {
  }
  return std::nullopt;
}

class Reader {
 public:
  Reader(const std::filesystem::path& file) : errors_(file) {
    records_ = CsvRecords::read(file, errors_);
    if (records_.columns.empty() && !errors_.any()) errors_.add(1, 1, "no header; the first line names the columns");
    find_columns();
  }
  FileErrors& errors() { return errors_; }
  const CsvRecords& records() const { return records_; }
  std::size_t rows() const { return records_.rows.size(); }
  bool has(const std::string& base) const { return column_.count(base) > 0; }
  const std::string& text(const std::string& base, std::size_t row) const {
    return records_.rows[row].cells[column_.at(base)].text;
  }
  /// An empty cell is NaN where `may_be_empty`.
  double number(const std::string& base, std::size_t row, bool may_be_empty) {
    const CsvCell& cell = records_.rows[row].cells[column_.at(base)];
    if (may_be_empty && cell.text.empty()) return nan;
    const auto x = parse_number(cell.text);
    if (x) return *x * scale_.at(base);
    const std::string name = records_.columns[column_.at(base)];
    std::string remedy =
        may_be_empty ? "; leave the cell empty where nothing was measured" : "; give its value or leave out the row";
    errors_.add(records_.rows[row].line, cell.column,
                "column '" + name + "': '" + cell.text + "' is not a finite number" + remedy);
    return nan;
  }
  void error(std::size_t row, const std::string& base, const std::string& message) {
    errors_.add(records_.rows[row].line, records_.rows[row].cells[column_.at(base)].column, message);
  }
  int header_column(std::size_t c) const {
    int at = 1;
    for (std::size_t i = 0; i < c; ++i) at += static_cast<int>(records_.columns[i].size()) + 1;
    return at;
  }

 private:
  void take(const std::string& base, std::size_t c, double scale) {
    if (!column_.emplace(base, c).second)
      errors_.add(1, header_column(c),
                  "column '" + records_.columns[c] + "' is there twice, in whatever unit; keep one");
    scale_[base] = scale;
  }
  void find_columns() {
    for (std::size_t c = 0; c < records_.columns.size(); ++c) {
      const std::string& name = records_.columns[c];
      if (std::find(std::begin(plain), std::end(plain), name) != std::end(plain)) {
        take(name, c, 1);
        continue;
      }
      const Quantity* best = nullptr;  // the longest base that fits: drawbar_sd before drawbar
      for (const Quantity& q : quantities) {
        const std::string b = q.base;
        const bool fits = name == b || name.rfind(b + "_", 0) == 0;
        if (fits && (!best || b.size() > std::string(best->base).size())) best = &q;
      }
      if (!best) {
        // A misspelt name would be a column that is not there.
        std::vector<std::string> known(std::begin(plain), std::end(plain));
        for (const Quantity& q : quantities) known.push_back(q.written);
        const auto meant = did_you_mean(name, known);
        if (meant || name.rfind("slip_", 0) == 0)
          errors_.add(
              1, header_column(c),
              "column '" + name + "' is not known" + (meant ? "; did you mean '" + *meant + "'?" : "") +
                  " Known are slip, slip_definition, slip_radius_m, load_N, ...; rename it if it is something else");
        continue;
      }
      const std::string b = best->base;
      if (name == b) {
        errors_.add(1, header_column(c),
                    "column '" + name + "' has no unit in its name; write '" + best->written + "'");
        continue;
      }
      const auto scale = scale_of(name.substr(b.size() + 1), best->unit);
      if (scale)
        take(b, c, *scale);
      else if (name.find("_sd") == std::string::npos || b.find("_sd") != std::string::npos)
        errors_.add(1, header_column(c),
                    "column '" + name + "': '" + name.substr(b.size() + 1) + "' is not a unit of " + b + "; write '" +
                        best->written + "', or rename the column if it is something else");
    }
  }
  FileErrors errors_;
  CsvRecords records_;
  std::map<std::string, std::size_t> column_;
  std::map<std::string, double> scale_;
};

/// Numbers texts in the order in which they come.
class Labels {
 public:
  int of(const std::string& text) { return known_.emplace(text, static_cast<int>(known_.size())).first->second; }
  std::size_t size() const { return known_.size(); }

 private:
  std::map<std::string, int> known_;
};

/// Number of the condition that a run repeats, or a new one. Where a column says what is a repeat, conditions are as good as weights
/// and motors make them; else they must agree.
int condition_of(const std::vector<Run>& earlier, const Run& r, bool stated) {
  const double share = stated ? 0.1 : 1e-6, slip = stated ? 0.01 : 1e-6;
  int next = 0;
  for (const Run& e : earlier) {
    next = std::max(next, e.condition + 1);
    if (std::abs(e.slip - r.slip) <= slip && std::abs(e.load - r.load) <= share * e.load &&
        std::abs(e.omega - r.omega) <= share * e.omega + 1e-12 && e.pass == r.pass &&
        std::abs(e.slope - r.slope) <= 1e-3)
      return e.condition;
  }
  return next;
}

std::string plain_number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

void read_slip(Reader& in, std::size_t i, const DiagnosisCase& c, Run& r) {
  r.stated_slip = in.number("slip", i, false);
  const double radius = in.has("slip_radius") ? in.number("slip_radius", i, false) : nan;
  const std::string definition = in.has("slip_definition") ? in.text("slip_definition", i) : "larger";
  if (definition != "larger" && definition != "rim")
    in.error(
        i, "slip_definition",
        "slip_definition '" + definition + "' is not known; larger: (r w - v)/max(|r w|, |v|), rim: (r w - v)/(r w)");
  const bool rim = definition == "rim";
  if (!rim && !(std::abs(r.stated_slip) <= 1) && std::isfinite(r.stated_slip))
    in.error(
        i, "slip",
        "slip " + in.text("slip", i) + " is outside -1..1; write per cent as a fraction, or slip_definition 'rim'");
  if (rim && !(r.stated_slip < 1) && std::isfinite(r.stated_slip))
    in.error(i, "slip", "slip " + in.text("slip", i) + " is not below 1, as (r w - v)/(r w) of a rolling wheel is");
  if (std::isfinite(radius) && !(radius > 0)) in.error(i, "slip_radius", "slip_radius_m must be above 0");
  const double share = radius / c.wheel.radius;
  if (share > 0 && (share < 0.67 || share > 1.5))
    in.error(i, "slip_radius",
             "slip was computed with a radius of " + in.text("slip_radius", i) + " where the wheel of the case has " +
                 plain_number(c.wheel.radius) + " m; check the unit in the column's name and the case");
  if (std::isfinite(radius) && radius > 0) r.slip = slip_at_radius(r.stated_slip, rim, radius, c.wheel.radius);
}

}  // namespace

namespace {

/// A sensor that shows one value whatever the wheel does measures nothing. Notes conditions that never change.
void look_for_constants(Reader& in, bool planned, RunTable& t) {
  const auto same = [&](auto of) {
    return std::all_of(t.runs.begin(), t.runs.end(), [&](const Run& r) { return of(r) == of(t.runs[0]); });
  };
  const bool slip = same([](const Run&r) { return r.slip; }), load = same([](const Run&r) { return r.load; });
  if (t.runs.size() < 2) return;
  if (slip)
    t.notes.push_back("slip never changes: most causes are told apart by slip; measure at -0.5, 0, 0.1, 0.3 and 0.7");
  if (load) t.notes.push_back("load_N never changes: measure at half or twice the load to tell causes apart");
  if (planned || t.runs.size() < 5 || (slip && load)) return;
  for (std::size_t k = 0; k < channel_count; ++k)
    if (t.measured[k] && std::isfinite(t.runs[0].value[k]) && same([k](const Run& r) { return r.value[k]; }))
      in.error(
          0, channel_names()[k].short_name,
          std::string("column '") + channel_names()[k].column +
              "' is the same in every row while slip or load change: the sensor did not answer; check the file, or "
              "remove the column");
}

/// Depths that no wheel has: another unit or another sign.
void look_at_sinkage(Reader& in, const DiagnosisCase& c, const RunTable& t) {
  bool below = false, above = false;
  for (std::size_t i = 0; i < t.runs.size(); ++i) {
    const double z = t.runs[i].value[2];
    if (std::abs(z) > 2 * c.wheel.radius)
      in.error(i, "sinkage",
               "a sinkage of " + plain_number(z) + " m is more than the diameter of the wheel (" +
                   plain_number(2 * c.wheel.radius) + " m); millimetres are written under the name sinkage_mm");
    below = below || z > 0, above = above || z < 0;
  }
  if (above && !below)
    in.error(0, "sinkage", "every sinkage is negative; it counts downwards from the undisturbed ground");
}

/// planned: no values; the channels are those whose errors are stated.
/// Two runs of one condition whose readings (two at least) agree to the last digit are more likely one run copied than two.
void look_for_copies(RunTable& t) {
  const auto copied = [](const Run& a, const Run& b) {
    int alike = 0;
    for (std::size_t c = 0; c < channel_count; ++c) {
      const bool had = std::isfinite(a.value[c]), has = std::isfinite(b.value[c]);
      if (had != has || (has && a.value[c] != b.value[c])) return false;
      alike += has ? 1 : 0;
    }
    return a.condition == b.condition && alike >= 2;
  };
  std::string lines;
  for (std::size_t i = 0; i < t.runs.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (!copied(t.runs[k], t.runs[i])) continue;
      lines += (lines.empty() ? "" : ", ") + std::to_string(t.runs[i].line) + " of " + std::to_string(t.runs[k].line);
      break;
    }
  if (!lines.empty())
    t.notes.push_back("lines with the readings of another to the last digit: " + lines +
                      "; each counts as a run of its own: remove what was copied");
}

RunTable read_table(const std::filesystem::path& csv, const DiagnosisCase& c, bool planned) {
  RunTable t;
  t.file = csv;
  Reader in(csv);
  if (in.records().columns.empty()) in.errors().check();
  const auto need = [&](const char* base, const char* written, const char* why) {
    if (!in.has(base)) in.errors().add(1, 1, std::string("column '") + written + "' is missing: " + why);
    return in.has(base);
  };
  // Rim and travel speed of each row say the slip as well.
  const bool by_speeds = !in.has("slip") && in.has("omega") && in.has("travel_speed");
  bool good = by_speeds || need("slip", "slip", "without it no run can be compared");
  good &= by_speeds ||
          need("slip_radius", "slip_radius_m",
               "slip without the radius it was computed with (with or without lugs) has two meanings; add the column");
  good &= need("load", "load_N", "add the vertical load of each run");
  for (int k = 0; k < channel_count; ++k) {
    const std::string base = channel_names()[static_cast<std::size_t>(k)].short_name;
    t.measured[static_cast<std::size_t>(k)] = in.has(planned ? base + "_sd" : base);
    t.stated_sd[static_cast<std::size_t>(k)] = in.has(base + "_sd");
    if (!t.measured[static_cast<std::size_t>(k)])
      t.notes.push_back("no column '" + std::string(channel_names()[static_cast<std::size_t>(k)].column) +
                        "': this channel is not used");
  }
  if (!t.measured[0] && !t.measured[1] && !t.measured[2]) {
    in.errors().add(1, 1,
                    planned ? "nothing would be measured: give drawbar_sd_N, torque_sd_Nm or sinkage_sd_m"
                            : "nothing was measured: give drawbar_N, torque_Nm or sinkage_m");
    good = false;
  }
  if (in.rows() == 0 && !in.errors().any()) in.errors().add(2, 1, "no runs below the header");
  if (!good) in.errors().check();
  t.has_order = in.has("order"), t.has_omega = in.has("omega"), t.has_batch = in.has("batch");
  t.has_slope = in.has("slope"), t.has_time = in.has("time");
  Labels batches, wheels;
  for (std::size_t i = 0; i < in.rows(); ++i) {
    Run r;
    r.line = in.records().rows[i].line;
    if (by_speeds) {
      const double rim = in.number("omega", i, false) * c.wheel.radius, travel = in.number("travel_speed", i, false);
      const double larger = std::max(std::abs(rim), std::abs(travel));
      if (larger == 0)
        in.error(i, "omega", "the wheel neither turns nor travels: slip has no meaning here; leave out the row");
      if (rim * travel < 0) in.error(i, "omega", "the wheel turns against its travel; the law has no such wheel");
      r.slip = r.stated_slip = larger > 0 ? (rim - travel) / larger : 0;
    } else {
      read_slip(in, i, c, r);
    }
    r.load = in.number("load", i, false);
    if (std::isfinite(r.load) && !(r.load > 0)) in.error(i, "load", "the load must be above 0");
    r.omega = t.has_omega ? in.number("omega", i, false) : 0.3;
    if (in.has("travel_speed") && r.slip <= -1) r.omega = in.number("travel_speed", i, false) / c.wheel.radius;
    r.pass = in.has("pass") ? static_cast<int>(in.number("pass", i, false)) : 1;
    r.order = t.has_order ? in.number("order", i, false) : static_cast<double>(i);
    r.time = t.has_time ? in.number("time", i, false) : 0;
    r.slope = t.has_slope ? in.number("slope", i, false) : 0;
    for (std::size_t k = 0; k < channel_count; ++k) {
      const std::string base = channel_names()[k].short_name;
      r.value[k] = !t.measured[k] ? nan : planned ? 0 : in.number(base, i, true);
      r.sd[k] = t.stated_sd[k] ? in.number(base + "_sd", i, true) : nan;
      if (t.stated_sd[k] && std::isfinite(r.value[k]) && !(r.sd[k] > 0))
        in.error(i, base + "_sd", "the standard deviation of a measured value must be above 0");
    }
    if (in.has("wheel") && wheels.of(in.text("wheel", i)) > 0)
      in.error(i, "wheel",
               "'" + in.text("wheel", i) + "' is a second wheel; one diagnosis takes one wheel: split the file");
    const std::string batch = t.has_batch ? in.text("batch", i) : "run " + std::to_string(i);
    r.batch = batches.of(batch);
    r.condition = condition_of(t.runs, r, in.has("replicate"));
    r.cells = {{"slip", r.stated_slip},  {"load_N", r.load},
               {"omega_rad_s", r.omega}, {"pass", static_cast<double>(r.pass)},
               {"order", r.order},       {"slope_deg", r.slope * 57.29577951308232},
               {"time_s", r.time}};
    t.runs.push_back(r);
  }
  if (in.has("replicate")) {  // the same condition and replicate on the same preparation twice is one run copied
    std::map<std::string, int> seen;
    for (std::size_t i = 0; i < t.runs.size(); ++i) {
      const Run& r = t.runs[i];
      const auto [at, fresh] = seen.emplace(
          std::to_string(r.condition) + "/" + std::to_string(t.has_batch ? r.batch : 0) + "/" + in.text("replicate", i),
          r.line);
      if (!fresh)
        in.error(i, "replicate",
                 "replicate " + in.text("replicate", i) + " of this condition is already in line " +
                     std::to_string(at->second) + "; number the repeats, or remove the copy");
    }
  }
  if (!in.errors().any()) look_for_constants(in, planned, t);
  if (!planned) look_for_copies(t);
  if (!planned && t.measured[2]) look_at_sinkage(in, c, t);
  in.errors().check();
  double low = INFINITY, high = -INFINITY;
  for (const Run& r : t.runs) low = std::min(low, r.order), high = std::max(high, r.order);
  for (Run& r : t.runs) r.order = high > low ? (r.order - low) / (high - low) : 0;
  if (!t.has_order) t.notes.push_back("no column 'order': causes that need the order of the runs are left out");
  if (!t.has_omega)
    t.notes.push_back("no column 'omega_rad_s': 0.3 rad/s for every run; effects of speed cannot be seen");
  if (!t.has_batch) t.notes.push_back("no column 'batch': each run counts as a preparation of its own");
  for (std::size_t k = 0; k < channel_count; ++k)
    if (t.measured[k] && !t.stated_sd[k])
      t.notes.push_back(std::string("no column '") + channel_names()[k].sd_column +
                        "': the noise of this channel is taken from the data");
  return t;
}

}  // namespace

RunTable read_runs(const std::filesystem::path& csv, const DiagnosisCase& c) { return read_table(csv, c, false); }
RunTable read_plan(const std::filesystem::path& csv, const DiagnosisCase& c) { return read_table(csv, c, true); }

}  // namespace grouser::diagnosis
