#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "grouser/diagnosis/soil_tests.h"
#include "grouser/terrain/types.h"
#include "sections.h"

namespace grouser::diagnosis {
namespace {

struct Plate {
  std::vector<double> b, area;
};

Plate read_plate(const ConfigNode& node, const DataTable& t) {
  Plate p;
  const std::string shape = node.choice("shape", {"round", "rectangular"});
  if (shape == "round") {
    const std::vector<double> d = t.quantity(node, "diameter", "m");
    const bool radius = node.choice_or("b", "radius", {"radius", "diameter"}) == "radius";
    for (const double x : d) {
      p.b.push_back(radius ? x / 2 : x);
      p.area.push_back(pi * x * x / 4);
    }
  } else {
    const std::vector<double> w = t.quantity(node, "width", "m"), l = t.quantity(node, "length", "m");
    for (std::size_t i = 0; i < w.size() && i < l.size(); ++i) {
      p.b.push_back(std::min(w[i], l[i]));
      p.area.push_back(w[i] * l[i]);
    }
  }
  node.finish();
  return p;
}

std::vector<SinkageCurve> read_curves(const ConfigNode& node, const DataTable& t) {
  const std::vector<double> z = t.quantity(node, "sinkage", "m");
  const Plate plate = read_plate(node.map("plate"), t);
  const bool force = node.has("force");
  if (force && node.has("pressure"))
    node.error_at("pressure", "both force and pressure are given; one of them is the data");
  std::vector<double> p = force ? t.quantity(node, "force", "N") : t.quantity(node, "pressure", "Pa");
  const std::vector<std::string> test = t.label(node, "test");
  const std::vector<double> range =
      node.has("sinkage_range") ? node.quantities("sinkage_range", "mm", 2) : std::vector<double>{};
  std::vector<SinkageCurve> out;
  if (t.size() == 0 || z.size() != t.size() || p.size() != t.size() || plate.b.size() != t.size()) return out;
  for (const auto& [name, rows] : grouped(test)) {
    SinkageCurve c{name, plate.b[rows[0]], {}, {}};
    for (const std::size_t r : rows) {
      if (plate.b[r] != c.width)
        node.report({t.file().string(), t.line(r), 1,
                     "test '" + name + "': the plate changes within the test; name more columns in 'test'"});
      if (range.size() == 2 && (z[r] < range[0] || z[r] > range[1])) continue;
      c.sinkage.push_back(z[r]);
      c.pressure.push_back(force ? p[r] / plate.area[r] : p[r]);
    }
    if (c.sinkage.size() < 4) {
      node.report(
          {t.file().string(), t.line(rows[0]), 1,
           "test '" + name + "' has " + std::to_string(c.sinkage.size()) + " rows in the range; four are wanted"});
      continue;
    }
    out.push_back(std::move(c));
  }
  return out;
}

PlateLaw law_of(const std::string& name) {
  return name == "kc_kphi"     ? PlateLaw::kc_kphi
         : name == "k_b"       ? PlateLaw::k_b
         : name == "reference" ? PlateLaw::reference
                               : PlateLaw::power;
}

std::vector<ShownParameter> parameters_of(const PlateFit& f) {
  std::vector<ShownParameter> out;
  for (const Estimate& e : f.fit.estimates) {
    if (e.name == "k") out.push_back(shown_parameter(e, "k", "kPa", 1e-3));
    if (e.name == "kc") out.push_back(shown_parameter(e, "kc", "kN/m^(n+1)", 1e-3));
    if (e.name == "kphi") out.push_back(shown_parameter(e, "kphi", "kN/m^(n+2)", 1e-3));
    if (e.name == "n") out.push_back(shown_parameter(e, "n", "1", 1));
    if (e.name == "m") out.push_back(shown_parameter(e, "size_exponent", "1", 1));
  }
  return out;
}

/// Every plate law on the same data, so that the choice is seen.
void add_law_table(const std::vector<SinkageCurve>& curves, PlateOptions o, bool several, FitSection& s) {
  FitTable t{"Plate-size laws on the same tests", {"law", "values", "n", "rms [kPa]", "sd between repeats [kPa]"}, {}};
  for (const PlateLaw law : {PlateLaw::kc_kphi, PlateLaw::k_b, PlateLaw::reference, PlateLaw::power}) {
    if (!several && (law == PlateLaw::kc_kphi || law == PlateLaw::power)) continue;
    o.law = law;
    const PlateFit f = fit_plates(curves, o);
    std::string values;
    for (const ShownParameter& p : parameters_of(f))
      if (p.name != "n")
        values += (values.empty() ? "" : ", ") + p.name + " " + shown(p.value) + " (" + shown(p.lower) + " to " +
                  shown(p.upper) + ")" + (p.unit == "1" ? "" : " " + p.unit);
    const char* name = law == PlateLaw::kc_kphi     ? "kc/b + kphi"
                       : law == PlateLaw::k_b       ? "k (z/b)^n, own width"
                       : law == PlateLaw::reference ? "k (z/b_ref)^n, size ignored"
                                                    : "k (z/b_ref)^n (b/b_ref)^m";
    t.rows.push_back({name, values, shown(f.pressure.n), shown(1e-3 * f.rms), shown(1e-3 * f.scatter)});
  }
  s.tables.push_back(std::move(t));
}

void add_tables(const PlateFit& f, FitSection& s) {
  FitTable sizes{"By plate",
                 {"b [mm]", "tests", "measured pressure [kPa]", "sd over repeats [kPa]", "fitted [kPa]",
                  "n of single tests", "sd of n"},
                 {}};
  for (const PlateSizeResult& p : f.sizes)
    sizes.rows.push_back({shown(1e3 * p.width), std::to_string(p.tests), shown(1e-3 * p.pressure_at_depth),
                          shown(1e-3 * p.sd), shown(1e-3 * p.fitted), shown(p.n_mean), shown(p.n_sd)});
  sizes.title += " (pressure at " + shown(1e3 * f.common_depth) + " mm)";
  s.tables.push_back(std::move(sizes));
  FitTable tests{"Tests one by one",
                 {"test", "b [mm]", "n", "modulus [kPa/m^n]", "z0 [mm]", "z0 pooled [mm]", "rms of its own fit [kPa]",
                  "rms of the pooled fit [kPa]"},
                 {}};
  for (std::size_t g = 0; g < f.tests.size(); ++g) {
    const PlateTestResult& t = f.tests[g];
    tests.rows.push_back({t.test, shown(1e3 * t.width), shown(t.n), shown(1e-3 * t.modulus), shown(1e3 * t.z0),
                          shown(1e3 * f.offsets[g]), shown(1e-3 * t.rms_own), shown(1e-3 * t.rms_pooled)});
  }
  s.tables.push_back(std::move(tests));
}

FitCurve curve_of(const SinkageCurve& c, const PlateFit& f, double z0) {
  FitCurve out{"Pressure over sinkage", "sinkage [mm]", "pressure [kPa]", c.test, {}, {}, {}, {}, {}, {}};
  for (std::size_t i = 0; i < c.sinkage.size(); ++i) {
    out.x.push_back(1e3 * c.sinkage[i]);
    out.measured.push_back(1e-3 * c.pressure[i]);
    out.fitted.push_back(1e-3 * plate_pressure(f, c.width, c.sinkage[i] - z0));
  }
  const double end = *std::max_element(c.sinkage.begin(), c.sinkage.end());
  for (int i = 0; i <= 100; ++i) {
    out.line_x.push_back(1e3 * end * i / 100);
    out.line_y.push_back(1e-3 * plate_pressure(f, c.width, end * i / 100 - z0));
  }
  return out;
}

void add_remarks(const PlateFit& f, const PlateOptions& o, FitSection& s) {
  if (f.law == PlateLaw::kc_kphi) {
    const Estimate& kc = f.fit.at("kc");
    if (kc.upper < 0)
      s.remarks.push_back(
          "kc is negative (95 % interval " + shown(1e-3 * kc.lower) + " to " + shown(1e-3 * kc.upper) +
          " kN/m^(n+1)): the pressure at a depth rises with the plate's size, where kc/b with kc > 0 lets it fall.");
    if (kc.lower < 0 && kc.upper > 0)
      s.remarks.push_back("kc cannot be told from 0 with these plates: correlation of kc and kphi " +
                          shown(f.fit.correlation(0, 1), 3) +
                          ". Use one width (k_b) unless plates of clearly different size are tested.");
  }
  if (std::isfinite(f.scatter))
    s.remarks.push_back("rms of the fit " + shown(1e-3 * f.rms) + " kPa; sd between repeats with one plate " +
                        shown(1e-3 * f.scatter) + " kPa.");
  if (o.errors == ErrorModel::clustered && f.fit.clusters < 6)
    s.remarks.push_back("Only " + std::to_string(f.fit.clusters) +
                        " tests: errors between tests are poorly known, hence the wide intervals.");
  if (o.errors == ErrorModel::scaled)
    s.remarks.push_back(
        "The standard errors take every row for independent; rows of one test are not. `errors: clustered` takes the "
        "tests as the unit.");
}

}  // namespace

FitSection plates_section(const ConfigNode& node, SoilDraft& draft) {
  FitSection s;
  s.kind = "pressure_sinkage";
  const std::size_t before = node.errors();
  const DataTable table = DataTable::load(node);
  const std::vector<SinkageCurve> curves = read_curves(node, table);
  PlateOptions o;
  const std::string law = node.choice_or("law", "k_b", {"k_b", "kc_kphi", "reference", "power"});
  o.law = law_of(law);
  const ConfigNode width = node.node("reference_width");
  double soil_width = law == "kc_kphi" ? 0 : o.reference_width;
  if (width.present() && width.is_scalar() && width.as_text() == "wheel")
    soil_width = law == "k_b" || law == "kc_kphi"
                     ? 0
                     : (width.error("law '" + law + "' refers to a length; give one, for example 50 mm"), 0);
  else if (width.present())
    soil_width = o.reference_width = width.as_quantity("mm", {0, 10, true, false});
  o.relative_weights = node.choice_or("weights", "uniform", {"uniform", "relative"}) == "relative";
  o.offset_per_test = node.choice_or("zero_offset", "none", {"none", "per_test"}) == "per_test";
  o.errors = error_model(node, "clustered");
  node.finish();
  if (node.errors() != before) return s;
  PlateFit f;
  const bool several = std::any_of(curves.begin(), curves.end(), [&](auto& c) { return c.width != curves[0].width; });
  try {
    f = fit_plates(curves, o);
    add_law_table(curves, o, several, s);
  } catch (const std::invalid_argument& e) {
    node.error(e.what());
    return s;
  }
  s.data = table.file().filename().string() + ", " + std::to_string(curves.size()) + " tests, " +
           std::to_string(table.size()) + " rows";
  s.parameters = parameters_of(f);
  s.correlation = f.fit.correlation;
  s.remarks = general_remarks(f.fit);
  add_remarks(f, o, s);
  add_tables(f, s);
  for (std::size_t g = 0; g < curves.size(); ++g) s.curves.push_back(curve_of(curves[g], f, f.offsets[g]));
  const std::string text = "plate tests, " + s.data + ", least squares, law " + law;
  draft.soil.pressure = f.pressure;
  draft.soil.pressure.reference_width = soil_width;
  for (const char* key : {"pressure.k", "pressure.kc", "pressure.kphi", "pressure.n"}) draft.put(key, text);
  if (width.present())
    draft.put("pressure.reference_width", "stated in the fit file");
  else
    draft.origin["pressure.reference_width"] = {"the fit file leaves open which width the wheel takes", true};
  return s;
}

}  // namespace grouser::diagnosis
