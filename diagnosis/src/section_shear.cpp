#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "grouser/bekker/wheel_forces.h"
#include "grouser/diagnosis/soil_tests.h"
#include "grouser/terrain/types.h"
#include "sections.h"

namespace grouser::diagnosis {
namespace {

std::vector<ShearCurve> read_curves(const ConfigNode& node, const DataTable& t) {
  const std::vector<double> j = t.quantity(node, "displacement", "m"), tau = t.quantity(node, "shear_stress", "Pa"),
                            sigma = t.quantity(node, "normal_stress", "Pa");
  std::vector<std::string> test = t.label(node, "test");
  std::vector<ShearCurve> curves;
  if (j.size() != t.size() || tau.size() != t.size() || sigma.size() != t.size()) return curves;
  if (!node.has("test"))
    for (std::size_t i = 0; i < test.size(); ++i) test[i] = shown(1e-3 * sigma[i], 5) + " kPa";
  for (const auto& [name, rows] : grouped(test)) {
    ShearCurve c{name, sigma[rows[0]], {}, {}};
    for (const std::size_t r : rows) {
      if (sigma[r] != c.normal_stress)
        node.report(
            {t.file().string(), t.line(r), 1, "test '" + name + "': the normal stress changes within the test"});
      c.displacement.push_back(j[r]);
      c.stress.push_back(tau[r]);
    }
    if (rows.size() < 3)
      node.report({t.file().string(), t.line(rows[0]), 1,
                   "test '" + name + "' has " + std::to_string(rows.size()) + " rows; three are wanted"});
    curves.push_back(std::move(c));
  }
  return curves;
}

FitCurve curve_of(const ShearCurve& c, const ShearLaw& law) {
  FitCurve f{"Shear stress over displacement",
             "shear displacement [mm]",
             "shear stress [kPa]",
             c.test,
             {},
             {},
             {},
             {},
             {},
             {}};
  const auto tau = [&](double j) {
    return 1e-3 * (law.cohesion + c.normal_stress * std::tan(law.friction_angle)) *
           bekker::mobilised(law, std::max(0.0, j));
  };
  for (std::size_t i = 0; i < c.stress.size(); ++i) {
    f.x.push_back(1e3 * c.displacement[i]);
    f.measured.push_back(1e-3 * c.stress[i]);
    f.fitted.push_back(tau(c.displacement[i]));
  }
  const double end = *std::max_element(c.displacement.begin(), c.displacement.end());
  for (int i = 0; i <= 200; ++i) {
    f.line_x.push_back(1e3 * end * i / 200);
    f.line_y.push_back(tau(end * i / 200));
  }
  return f;
}

void add_method_table(const std::vector<ShearCurve>& curves, ErrorModel errors, FitSection& s) {
  FitTable t{"The two methods for K side by side", {"method", "c [Pa]", "phi [deg]", "K [mm]", "rms [Pa]"}, {}};
  for (const auto& [name, method] :
       {std::pair{"least squares (eq 3.21)", KMethod::least_squares}, {"Wong", KMethod::wong}}) {
    const DirectShearFit f = fit_direct_shear(curves, ShearLaw::Type::A, method, errors);
    double squares = 0, points = 0;
    for (std::size_t g = 0; g < curves.size(); ++g) {
      const auto n = static_cast<double>(curves[g].stress.size());
      squares += n * f.tests[g].rms * f.tests[g].rms;
      points += n;
    }
    t.rows.push_back({name, shown(f.law.cohesion), shown(f.law.friction_angle * 180 / pi), shown(1e3 * f.law.K),
                      shown(std::sqrt(squares / points))});
  }
  s.tables.push_back(std::move(t));
}

}  // namespace

FitSection direct_shear_section(const ConfigNode& node, SoilDraft& draft) {
  FitSection s;
  s.kind = "direct_shear";
  const std::size_t before = node.errors();
  const DataTable table = DataTable::load(node);
  const std::string type_name = node.choice_or("type", "A", {"A", "B", "C"});
  const std::string method_name = node.choice_or("K_method", "least_squares", {"least_squares", "wong"});
  const ErrorModel errors = error_model(node, "scaled");
  const std::vector<ShearCurve> curves = read_curves(node, table);
  const auto type = type_name == "A" ? ShearLaw::Type::A : type_name == "B" ? ShearLaw::Type::B : ShearLaw::Type::C;
  if (method_name == "wong" && type_name != "A")
    node.error_at("K_method", "Wong's method belongs to shear type A; with type " + type_name + " use least_squares");
  node.finish();
  if (node.errors() != before) return s;
  DirectShearFit f;
  try {
    f = fit_direct_shear(curves, type, method_name == "wong" ? KMethod::wong : KMethod::least_squares, errors);
  } catch (const std::invalid_argument& e) {
    node.error(e.what());
    return s;
  }
  s.data = table.file().filename().string() + ", " + std::to_string(curves.size()) + " tests, " +
           std::to_string(table.size()) + " rows";
  s.parameters = {shown_parameter(f.fit.at("c"), "cohesion", "Pa", 1),
                  shown_parameter(f.fit.at("phi"), "friction_angle", "deg", 180 / pi),
                  shown_parameter(f.fit.estimates[2], type_name == "A" ? "K" : "Kw", "mm", 1e3)};
  if (type_name == "C") s.parameters.push_back(shown_parameter(f.fit.at("Kr"), "Kr", "1", 1));
  s.correlation = f.fit.correlation;
  s.remarks = general_remarks(f.fit);
  FitTable tests{
      "Tests",
      {"test", "normal stress [kPa]", "largest stress [kPa]", "rms of the fit [kPa]", "lag-1 autocorrelation"},
      {}};
  const bool exponential = type_name == "A";  // both readings of K are of its curve
  if (exponential)
    tests.columns.insert(tests.columns.end(), {"K by Wong, this test [mm]", "a third of the way to 95 % [mm]"});
  double lag = 0;
  for (const ShearTestResult& t : f.tests) {
    tests.rows.push_back(
        {t.test, shown(1e-3 * t.normal_stress), shown(1e-3 * t.tau_max), shown(1e-3 * t.rms), shown(t.lag1, 2)});
    if (exponential) tests.rows.back().insert(tests.rows.back().end(), {shown(1e3 * t.K_wong), shown(1e3 * t.K_third)});
    lag = std::max(lag, t.lag1);
  }
  s.tables.push_back(std::move(tests));
  if (lag > 0.5 && errors == ErrorModel::scaled)
    s.remarks.push_back(
        "Neighbouring residuals are alike (lag-1 autocorrelation up to " + shown(lag, 2) +
        "): the standard errors take every row for independent and are too small, by a factor of about " +
        shown(std::sqrt((1 + lag) / (1 - std::min(lag, 0.999))), 2) + ".");
  if (type_name == "A" && curves.size() > 1) add_method_table(curves, errors, s);
  for (const ShearCurve& c : curves) s.curves.push_back(curve_of(c, f.law));
  const std::string text =
      "direct shear, " + s.data + ", " + (method_name == "wong" ? "Wong's method" : "least squares, eq 3.21");
  draft.soil.shear = f.law;
  for (const char* key : {"shear.cohesion", "shear.friction_angle", "shear.K", "shear.Kw", "shear.Kr"})
    draft.put(key, text);
  return s;
}

}  // namespace grouser::diagnosis
