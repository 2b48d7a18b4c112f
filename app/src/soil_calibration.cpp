// The file of a calibration.
#include "soil_calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "grouser/terrain/csv.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;

void read_parameters(const ConfigNode& n, const dem::SoilSettings& soil, Calibration& c) {
  const bool constant = soil.law.rolling == dem::RollingCoefficient::constant;
  const std::vector<CalibrationParameter> known{
      {"young_modulus", "Pa", 0, 0,
       [](dem::SoilSettings& s, double v) {
         for (dem::Material& m : s.materials.materials) m.young = v;
       }},
      {"friction", "1", 0, 0, [](dem::SoilSettings& s, double v) { s.materials.pair(0, 0).friction = v; }},
      {"rolling_coefficient", constant ? "1" : "s^2/m^2", 0, 0,
       [](dem::SoilSettings& s, double v) { s.materials.pair(0, 0).rolling = v; }}};
  for (CalibrationParameter p : known) {
    if (!n.has(p.name)) continue;
    const std::vector<double> b = n.quantities(p.name, p.unit, 2, Range::positive());
    if (b.size() != 2) continue;
    p.lower = b[0];
    p.upper = b[1];
    if (!(p.lower < p.upper)) n.error_at(p.name, "the lower bound comes first and must be less than the upper one");
    c.parameters.push_back(std::move(p));
  }
  if (n.keys().empty()) n.error("at least one of young_modulus, friction, rolling_coefficient");
  n.finish();
}

/// Columns x and y of a CSV file; x must rise.
void read_points(const ConfigNode& n, const std::string& x, const std::string& y, CalibrationTarget& t) {
  const std::size_t before = n.errors();
  const fs::path file = n.existing_file("file");
  if (n.errors() > before) return;
  t.source = file.filename().string();
  FileErrors errors(file);
  const CsvRecords csv = CsvRecords::read(file, errors);
  if (errors.any()) return errors.report_to(n);
  const auto a = csv.column(x), b = csv.column(y);
  for (const auto& [found, name] : {std::pair{a, x}, std::pair{b, y}})
    if (!found) n.error_at("file", csv.unknown_column(name));
  if (!a || !b) return;
  for (const CsvRecords::Row& r : csv.rows) {
    const CsvCell &p = r.cells[*a], &q = r.cells[*b];
    const auto u = parse_number(p.text), v = parse_number(q.text);
    if (!u) errors.add(r.line, p.column, "'" + p.text + "' is not a number");
    if (!v) errors.add(r.line, q.column, "'" + q.text + "' is not a number");
    if (!u || !v) continue;
    if (!t.x.empty() && *u <= t.x.back())
      errors.add(r.line, p.column, fmt::format("{} must be greater than in the line before", x));
    t.x.push_back(*u);
    t.y.push_back(*v);
  }
  if (t.x.size() < 2 && !errors.any()) errors.add(1, 1, "a target needs at least two points");
  errors.report_to(n);
}

/// Pressures that a shear file asks for.
std::vector<double> pressures_of(const SoilFile& f) {
  std::vector<double> out;
  for (const SoilCase& c : f.cases) {
    const double p = std::get<dem::ShearSettings>(c.test).pressure;
    if (std::find(out.begin(), out.end(), p) == out.end()) out.push_back(p);
  }
  return out;
}

void read_shear_targets(const ConfigNode& n, CalibrationTest& t) {
  const std::vector<double> pressures = pressures_of(t.plan);
  for (const ConfigNode& k : n.optional_list("target")) {
    CalibrationTarget target;
    const std::size_t before = k.errors();
    target.pressure = k.quantity("pressure", "Pa", Range::positive());
    if (k.errors() == before && std::find(pressures.begin(), pressures.end(), target.pressure) == pressures.end()) {
      std::string all;
      for (double p : pressures) all += (all.empty() ? "" : ", ") + fmt::format("{:g} Pa", p);
      k.error_at("pressure", "the test does not have this pressure; it has " + all);
    }
    for (const CalibrationTarget& other : t.targets)
      if (other.pressure == target.pressure) k.error_at("pressure", "there is a target for this pressure already");
    read_points(k, "displacement_m", t.column, target);
    k.finish();
    t.targets.push_back(std::move(target));
  }
  if (!t.targets.empty()) {
    for (double p : pressures)
      if (std::none_of(t.targets.begin(), t.targets.end(), [&](const auto& a) { return a.pressure == p; }))
        n.error_at("target", fmt::format("a target for {:g} Pa is missing", p));
    return;
  }
  for (double p : pressures) t.targets.push_back({p, t.plan.reference.source, {}, {}});
}

void read_test(const ConfigNode& n, const std::string& kind, CalibrationTest& t) {
  const bool shear = kind == "direct-shear";
  t.kind = kind;
  t.weight = n.quantity_or("weight", 1, "1", Range::non_negative());
  t.column = shear ? n.choice_or("column", "shear_total_Pa", {"shear_total_Pa", "shear_box_Pa"}) : "pressure_Pa";
  const std::size_t before = n.errors();
  t.file = n.existing_file("file");
  if (n.errors() == before) {
    try {
      t.plan = read_soil_file(t.file, kind);
    } catch (const ConfigError& e) {
      for (const Diagnostic& d : e.diagnostics()) n.report(d);
    }
  }
  if (!t.plan.cases.empty()) {
    if (!t.plan.cases[0].variant.empty()) n.error_at("file", "a test to calibrate has no variants");
    if (shear) {
      read_shear_targets(n, t);
    } else {
      const ConfigNode target = n.optional_map("target");
      t.targets.push_back({0, t.plan.reference.source, {}, {}});
      if (target.present()) {
        read_points(target, "sinkage_m", "pressure_Pa", t.targets[0]);
        target.finish();
      }
    }
    const bool reference = shear ? t.plan.reference.shear : t.plan.reference.sinkage;
    if (!n.has("target") && !reference)
      n.error("there is nothing to compare with: name a target here or a reference in the file of the test");
  } else {
    n.node("target");  // not looked at without its test
  }
  n.finish();
}

}  // namespace

std::string value_text(const CalibrationParameter& p, double value) {
  return p.unit == "1" ? fmt::format("{:.5g}", value) : fmt::format("{:.5g} {}", value, p.unit);
}

Calibration read_calibration(const fs::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  Calibration c;
  c.file = file;
  c.title = root.text("calibration");
  root.text_or("source", "");
  read_test(root.map("direct_shear"), "direct-shear", c.tests[0]);
  read_test(root.map("pressure_sinkage"), "pressure-sinkage", c.tests[1]);
  const ConfigNode parameters = root.map("parameters");
  if (!c.tests[0].plan.cases.empty() && !c.tests[1].plan.cases.empty()) {
    const dem::SoilSettings &a = c.tests[0].plan.cases[0].soil, &b = c.tests[1].plan.cases[0].soil;
    if (a.law.model != dem::ContactModel::hertz_ch4 || b.law.model != dem::ContactModel::hertz_ch4)
      root.error_at("parameters", "are those of hertz-ch4; the tests use another model");
    if (a.law.rolling != b.law.rolling)
      root.error_at("pressure_sinkage", "its test has another law of rolling than the shear test");
    read_parameters(parameters, a, c);
  }
  if (c.tests[0].weight + c.tests[1].weight == 0) root.error("both weights are zero");
  const ConfigNode s = root.optional_map("search");
  if (s.present()) {
    c.search.first = static_cast<std::size_t>(s.integer_or("sets", 8, 1, 100000));
    c.search.most = static_cast<std::size_t>(s.integer_or("evaluations", 24, 1, 100000));
    c.search.method = s.choice_or("method", c.search.method, search_methods());
    c.search.seed = static_cast<unsigned>(s.integer_or("seed", 1, 0, 4294967295));
    c.search.tolerance = s.quantity_or("tolerance", c.search.tolerance, "1", Range::between(1e-6, 0.5));
    if (c.search.most < c.search.first)
      s.error_at("evaluations", "counts all sets, so it cannot be less than 'sets', the first ones of them");
    s.finish();
  }
  root.finish();
  doc.check();
  return c;
}

}  // namespace grouser::app
