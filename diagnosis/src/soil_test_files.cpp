// Reads the case and the measured curves of soil tests on grains.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "grouser/terrain/csv.h"
#include "soil_test_model.h"

namespace grouser::diagnosis {
namespace {

std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.5g", x);
  return text;
}

/// A column by the beginning of its name; the rest is its unit.
struct Quantity {
  const char *base, *unit, *written;
};
constexpr Quantity quantities[] = {
    {"normal_stress", "Pa", "normal_stress_Pa"}, {"speed", "m/s", "speed_mm_s"}, {"rest", "s", "rest_s"},
    {"displacement", "m", "displacement_mm"},    {"stress", "Pa", "stress_Pa"},  {"rise", "m", "rise_mm"}};

class CurveFile {
 public:
  explicit CurveFile(const std::filesystem::path& file) : errors_(file), t_(CsvRecords::read(file, errors_)) {
    if (t_.columns.empty()) return;
    for (std::size_t c = 0; c < t_.columns.size(); ++c) find(c);
    for (const char* name : {"test", "repeat"})
      if (const auto c = t_.column(name))
        column_[name] = *c;
      else if (std::string(name) == "test")
        errors_.add(1, 1, "no column 'test'; it says shear or plate");
    for (const char* base : {"speed", "displacement", "stress"})
      if (!has(base)) errors_.add(1, 1, std::string("no column '") + written(base) + "'");
  }
  FileErrors& errors() { return errors_; }
  const CsvRecords& table() const { return t_; }
  bool has(const std::string& base) const { return column_.count(base) > 0; }
  const CsvCell& cell(const CsvRecords::Row& row, const std::string& base) const { return row.cells[column_.at(base)]; }
  /// NaN where the cell is empty and may be.
  double number(const CsvRecords::Row& row, const std::string& base, bool may_be_empty = false) {
    const CsvCell& c = cell(row, base);
    if (may_be_empty && c.text.empty()) return std::numeric_limits<double>::quiet_NaN();
    if (const auto x = parse_number(c.text)) return *x * scale_.at(base);
    errors_.add(row.line, c.column,
                "column '" + t_.columns[column_.at(base)] + "': '" + c.text +
                    "' is not a finite number; give its value or leave out the row");
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  static const char* written(const std::string& base) {
    for (const Quantity& q : quantities)
      if (base == q.base) return q.written;
    return "";
  }
  void find(std::size_t c) {
    const std::string& name = t_.columns[c];
    for (const Quantity& q : quantities) {
      const std::string base = q.base;
      if (name != base && name.rfind(base + "_", 0) != 0) continue;
      std::string unit = name.size() > base.size() ? name.substr(base.size() + 1) : "";
      if (unit.size() > 2 && unit.substr(unit.size() - 2) == "_s") unit = unit.substr(0, unit.size() - 2) + "/s";
      try {
        const UnitScale u = parse_unit(unit.empty() ? "?" : unit);
        if (!u.compatible(parse_unit(q.unit))) throw std::invalid_argument("dimension");
        if (!column_.emplace(base, c).second)
          errors_.add(1, 1, "column '" + name + "' is there twice, in whatever unit; keep one");
        scale_[base] = u.scale;
      } catch (const std::invalid_argument&) {
        errors_.add(1, 1,
                    unit.empty() ? "column '" + name + "' has no unit in its name; write '" + q.written + "'"
                                 : "column '" + name + "': '" + unit + "' is not a unit of " + base + "; write '" +
                                       q.written + "'");
      }
    }
  }
  FileErrors errors_;
  CsvRecords t_;
  std::map<std::string, std::size_t> column_;
  std::map<std::string, double> scale_;
};

SoilPrior read_prior(const ConfigNode& soil, const GrainCoordinate& g) {
  SoilPrior p;
  const ConfigNode n = soil.map(g.key);
  p.mean = std::log(n.quantity("value", g.unit, Range::positive()));
  p.sd = n.quantity("ln_sd", "1", Range::positive());
  n.text_or("source", "");
  n.finish();
  return p;
}

}  // namespace

std::string SoilTestCondition::name() const {
  const std::string at = number(speed * 1e3) + " mm/s";
  return kind == SoilTestKind::plate ? "plate, " + at : "shear at " + number(normal_stress) + " Pa, " + at;
}

bool is_soil_test_case(const std::filesystem::path& yaml) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode root = document.root();
  return root.present() && root.is_map() && root.text_or("model", "") == "dem.soil_tests";
}

SoilTestCase read_soil_test_case(const std::filesystem::path& yaml) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode root = document.root();
  SoilTestCase c;
  c.file = yaml;
  root.choice("model", {"dem.soil_tests"});
  c.stored = root.existing_file("stored_runs");
  const ConfigNode soil = root.map("soil");
  for (std::size_t i = 0; i < grain_count; ++i) c.soil[i] = read_prior(soil, grain_coordinates()[i]);
  soil.finish();
  std::vector<std::string> known;
  for (const SoilTestEffect& e : soil_test_effects()) known.emplace_back(e.id);
  const ConfigNode effects = root.node("effects");
  if (!effects.present() || (effects.is_scalar() && effects.as_text() == "all")) {
    c.effects = known;
  } else if (effects.is_list()) {
    for (const ConfigNode& item : effects.items()) {
      const std::string id = item.as_text();
      if (std::find(known.begin(), known.end(), id) != known.end()) {
        c.effects.push_back(id);
        continue;
      }
      const auto near = did_you_mean(id, known);
      item.error("no effect '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
    }
  } else {
    effects.error("effects: all, or a list of ids");
  }
  root.finish();
  document.check();
  return c;
}

SoilTestData read_soil_test_curves(const std::filesystem::path& csv) {
  CurveFile in(csv);
  in.errors().check();
  SoilTestData d;
  d.file = csv;
  const bool rise = in.has("rise");
  bool every_rise = rise;
  for (const CsvRecords::Row& row : in.table().rows) {
    const CsvCell& test = in.cell(row, "test");
    if (test.text != "shear" && test.text != "plate") {
      in.errors().add(row.line, test.column, "'" + test.text + "' is no test; shear or plate");
      continue;
    }
    const bool shear = test.text == "shear";
    SoilTestCondition c;
    c.kind = shear ? SoilTestKind::shear : SoilTestKind::plate;
    c.speed = in.number(row, "speed");
    if (shear) {
      for (const char* base : {"normal_stress", "rest"})
        if (!in.has(base)) {
          in.errors().add(
              1, 1,
              std::string("no column '") + (base[0] == 'n' ? "normal_stress_Pa" : "rest_s") + "'; shear tests need it");
          in.errors().check();
        }
      c.normal_stress = in.number(row, "normal_stress"), c.rest = in.number(row, "rest");
    }
    if (!(c.speed > 0) || (shear && !(c.normal_stress > 0 && c.rest > 0))) {
      in.errors().add(row.line, 1, "speed, and for shear tests normal stress and rest, must be positive");
      continue;
    }
    // The stored runs with the rate law rest for 0.66 mm of shearing: it creeps, so time under load is part of the
    // test.
    if (shear && (c.rest * c.speed < 0.22e-3 || c.rest * c.speed > 2e-3))
      in.errors().add(row.line, in.cell(row, "rest").column,
                      "a rest of " + number(c.rest) + " s at " + number(c.speed * 1e3) +
                          " mm/s; the stored runs rest for 0.66 mm of shearing, here " + number(0.66e-3 / c.speed) +
                          " s (a third to three times that is taken)");
    const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-3 * std::abs(b); };
    SoilTestCondition* condition = nullptr;
    for (SoilTestCondition& known : d.conditions)
      if (known.kind == c.kind && near(known.speed, c.speed) &&
          (!shear || (near(known.normal_stress, c.normal_stress) && near(known.rest, c.rest))))
        condition = &known;
    if (!condition) d.conditions.push_back(c), condition = &d.conditions.back();
    const std::string repeat = in.has("repeat") ? in.cell(row, "repeat").text : "1";
    SoilTestCurve* curve = nullptr;
    for (SoilTestCurve& known : condition->curves)
      if (known.repeat == repeat) curve = &known;
    if (!curve) {
      condition->curves.emplace_back();
      curve = &condition->curves.back();
      curve->line = row.line, curve->repeat = repeat;
    }
    const double at = in.number(row, "displacement");
    if (!curve->displacement.empty() && !(at > curve->displacement.back()))
      in.errors().add(row.line, in.cell(row, "displacement").column,
                      "displacement does not grow within test '" + test.text + "', repeat '" + repeat +
                          "'; give repeats of one condition names of their own in a column 'repeat'");
    curve->displacement.push_back(at);
    curve->stress.push_back(in.number(row, "stress"));
    if (!shear || !rise) continue;
    curve->rise.push_back(in.number(row, "rise", true));
  }
  in.errors().check();
  if (d.conditions.empty()) in.errors().fail(1, 1, "no test; every row is a point of a curve");
  bool any_repeat = false;
  for (const SoilTestCondition& c : d.conditions) {
    any_repeat = any_repeat || c.curves.size() > 1;
    for (const SoilTestCurve& curve : c.curves)
      if (c.kind == SoilTestKind::shear)
        every_rise = every_rise && !curve.rise.empty() && std::isfinite(curve.rise.back());
  }
  d.rise = every_rise;
  if (rise && !every_rise) d.notes.emplace_back("rise_mm is not used: it is missing at the end of a shear test");
  if (!any_repeat) d.notes.emplace_back("no test has a repeat: the scatter is that of the stored runs");
  for (const SoilTestCondition& c : d.conditions)
    for (const SoilTestCurve& curve : c.curves) try {
        soil_test_outputs(c.kind, curve, d.rise);
      } catch (const std::invalid_argument& why) {
        in.errors().add(curve.line, 1, c.name() + ", repeat " + curve.repeat + ": " + why.what());
      }
  in.errors().check();
  return d;
}

}  // namespace grouser::diagnosis
