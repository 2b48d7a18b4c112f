#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "grouser/bekker/table.h"
#include "grouser/diagnosis/wheel_fit.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/types.h"
#include "sections.h"

namespace grouser::diagnosis {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
using Model = std::vector<std::array<double, wheel_channels>>;

bekker::WheelSize wheel_of(const ConfigNode& node) {
  bekker::WheelSize w;
  const std::filesystem::path file = node.existing_file("wheel");
  if (!std::filesystem::is_regular_file(file)) return w;
  const ConfigDocument document = ConfigDocument::from_file(file);
  const RunningGear gear = load_running_gear(document.root());
  for (const Diagnostic& e : document.diagnostics()) node.report(e);
  if (!document.diagnostics().empty()) return w;
  w = {gear.radius(), gear.width(), 0, 0};
  if (const auto* lugged = std::get_if<LuggedCylinder>(&gear.shape)) {
    w.lug_height = lugged->lug_height;
    w.lug_ratio = lugged->lug_ratio;
  }
  if (std::holds_alternative<TriangleMesh>(gear.shape))
    node.error_at("wheel", "a mesh wheel has no closed Bekker-Wong form; take a smooth or lugged wheel");
  return w;
}

struct WheelData {
  DataTable table;
  std::vector<WheelPoint> points;
  std::string slip_text;
  bool rim = true;
  double slip_radius = 0;  ///< [m] of the stated slip
};

void read_channel(const ConfigNode& node, const DataTable& t, std::size_t c, std::vector<WheelPoint>& points) {
  const WheelChannelName& info = wheel_channel_names()[c];
  const ConfigNode channel = node.optional_map(info.name);
  if (!channel.present()) return;
  const std::vector<double> value = t.quantity(channel, "column", info.unit);
  const std::vector<double> error = t.quantity(channel, "error", info.unit);
  std::vector<bool> left_out(t.size(), false);
  if (const ConfigNode skip = channel.optional_map("skip"); skip.present()) left_out = t.picked(skip);
  channel.finish();
  if (value.size() != points.size() || error.size() != points.size()) return;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (left_out[i]) continue;
    points[i].value[c] = value[i];
    points[i].error[c] = error[i];
    if (!(error[i] > 0))
      node.report({t.file().string(), t.line(i), 1, std::string(info.name) + ": the error must be positive"});
  }
}

WheelData read_points(const ConfigNode& node, const bekker::WheelSize& wheel) {
  WheelData d{DataTable::load(node), {}, {}, true, 0};
  const DataTable& t = d.table;
  const std::vector<double> slip = t.quantity(node, "slip", "1"), load = t.quantity(node, "load", "N");
  const bool rim = node.choice("slip_definition", {"rim", "symmetric"}) == "rim";
  const double radius = node.quantity_or("slip_radius", wheel.radius, "m", Range::positive());
  const std::vector<double> angle =
      node.has("slip_angle") ? t.quantity(node, "slip_angle", "rad") : std::vector<double>(t.size(), 0.0);
  const std::vector<std::string> condition = t.label(node, "condition");
  const bool of_tread = node.choice_or("sinkage_of", "tips", {"tips", "tread"}) == "tread";
  d.points.assign(t.size(), {});
  for (WheelPoint& p : d.points) p.value.fill(nan), p.error.fill(nan);
  for (std::size_t c = 0; c < wheel_channels; ++c) read_channel(node, t, c, d.points);
  node.finish();
  if (slip.size() != t.size() || load.size() != t.size() || angle.size() != t.size()) return d;
  for (std::size_t i = 0; i < t.size(); ++i) {
    WheelPoint& p = d.points[i];
    if (slip[i] > 1 || (!rim && slip[i] < -1))
      node.report(
          {t.file().string(), t.line(i), 1,
           "slip " + shown(slip[i]) + " is outside what slip_definition: " + (rim ? "rim" : "symmetric") + " allows"});
    if (!(load[i] > 0)) node.report({t.file().string(), t.line(i), 1, "the load must be positive"});
    p.stated_slip = slip[i];
    if (wheel.radius > 0) p.slip = slip_at_radius(slip[i], rim, radius, wheel.outer_radius());
    p.load = load[i];
    p.slip_angle = angle[i];
    p.sinkage_datum = of_tread ? wheel.lug_height : 0;
    p.condition = condition[i];
  }
  d.rim = rim;
  d.slip_radius = radius;
  d.slip_text = rim ? "slip, (r w - v)/(r w) [-]" : "slip, (r w - v)/max(|r w|, |v|) [-]";
  return d;
}

std::vector<WheelVariable> read_variables(const ConfigNode& node, SoilDraft& draft) {
  std::vector<WheelVariable> out;
  const ConfigNode map = node.optional_map("parameters");
  if (!map.present()) return out;
  const PressureSinkage& law = draft.soil.pressure;
  for (const WheelParameter& k : wheel_parameters()) {
    if (!map.has(k.name)) continue;
    const ConfigNode v = map.map(k.name);
    const std::string name = k.name;
    const bool k_b = law.law == PressureSinkage::Law::k_b;
    if ((name == "k" && !k_b) || ((name == "kc" || name == "kphi") && k_b))
      map.error_at(name,
                   std::string("the soil's pressure law is ") + (k_b ? "k_b" : "kc_kphi") + "; it has no " + name);
    const bool with_n = name == "kc" || name == "kphi";
    const auto read = [&](const char* key, double fallback) {
      if (!v.has(key)) return fallback;
      return with_n ? v.quantity_n(key, k.unit, law.n) : v.quantity(key, k.unit);
    };
    WheelVariable w{name, read("from", k.lower), read("to", k.upper), {}};
    if (v.has("start")) set_parameter(draft.soil, name, read("start", 0));
    if (v.has("prior")) {
      const double mean = read("prior", 0);
      if (k.logarithmic)
        w.prior = Prior{std::log(std::max(mean, 1e-300)), v.quantity("prior_ln_sd", "1", Range::positive())};
      else
        w.prior = Prior{mean, with_n ? v.quantity_n("prior_sd", k.unit, law.n, Range::positive())
                                     : v.quantity("prior_sd", k.unit, Range::positive())};
    }
    const double start = get_parameter(draft.soil, name);
    if (!(w.lower < w.upper))
      v.error("'from' must be below 'to'");
    else if (start < w.lower || start > w.upper)
      v.error("the start " + shown(start * k.shown) + " " + k.shown_unit +
              " (the soil's value) is not between 'from' and 'to'; give 'start'");
    v.finish();
    out.push_back(w);
  }
  map.finish();
  if (out.empty()) map.error("no parameter to fit; give at least one");
  return out;
}

std::string channel_title(std::size_t c) {
  static const char* titles[] = {"Drawbar pull", "Driving torque", "Sinkage", "Side force"};
  return titles[c];
}

std::string scatter_text(const ChannelError& e, double scale) {
  return std::isnan(e.scatter) ? "no repeats" : shown(e.scatter * scale, 3);
}

void add_rows(FitTable& t, const std::string& set, const std::string& name, const std::string& model,
              const std::vector<WheelPoint>& points, const Model& m, double within) {
  std::vector<WheelPoint> kept;
  Model kept_model;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::abs(points[i].stated_slip) <= within) kept.push_back(points[i]), kept_model.push_back(m[i]);
  for (const ChannelError& e : channel_errors(kept, kept_model)) {
    const WheelChannelName& c = wheel_channel_names()[static_cast<std::size_t>(e.channel)];
    t.rows.push_back({set, model, name, c.name, c.shown_unit, std::to_string(e.points), shown(e.rmse * c.shown),
                      shown(e.bias * c.shown), std::isnan(e.scatter) ? "" : shown(e.scatter * c.shown, 3),
                      std::isnan(e.stated_error) ? "" : shown(e.stated_error * c.shown, 3), shown(e.range * c.shown)});
  }
}

struct Sweep {
  std::vector<double> slip;
  Model value;
};

/// sweep.csv of the rig: means over slip by the wheel's own radius, symmetric definition.
Sweep read_sweep(const ConfigNode& node, const bekker::WheelSize& wheel) {
  Sweep s;
  const DataTable t = DataTable::load(node);
  if (t.size() == 0) return s;
  const ConfigDocument columns = ConfigDocument::from_text(
      "slip: slip_symmetric\ndrawbar_pull: drawbar_pull_N\ndriving_torque: driving_torque_Nm\nsinkage: "
      "sinkage_mm\nside_force: side_force_N\n",
      t.file().string());
  const ConfigNode c = columns.root();
  const std::vector<double> slip = t.quantity(c, "slip", "1");
  std::array<std::vector<double>, wheel_channels> v;
  for (std::size_t k = 0; k < wheel_channels; ++k)
    v[k] = t.quantity(c, wheel_channel_names()[k].name, wheel_channel_names()[k].unit);
  for (const Diagnostic& d : columns.diagnostics()) node.report(d);
  if (!columns.diagnostics().empty()) return s;
  std::vector<std::size_t> order(slip.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return slip[a] < slip[b]; });
  for (const std::size_t i : order) {
    s.slip.push_back(slip_at_radius(slip[i], false, wheel.radius, wheel.outer_radius()));
    s.value.push_back({v[0][i], v[1][i], v[2][i], v[3][i]});
  }
  return s;
}

/// Straight line between two slips; NaN outside: nothing is extrapolated (half a thousandth of slip is rounding of the motion).
std::array<double, wheel_channels> interpolated(const Sweep& s, double slip) {
  std::array<double, wheel_channels> out;
  out.fill(nan);
  for (std::size_t i = 0; i < s.slip.size(); ++i) {
    if (std::abs(s.slip[i] - slip) < 5e-4) return s.value[i];
    if (i == 0 || slip < s.slip[i - 1] || slip > s.slip[i]) continue;
    const double t = (slip - s.slip[i - 1]) / (s.slip[i] - s.slip[i - 1]);
    for (std::size_t c = 0; c < wheel_channels; ++c) out[c] = (1 - t) * s.value[i - 1][c] + t * s.value[i][c];
  }
  return out;
}

struct Compared {
  std::string name, model;
  std::string soil;  ///< empty: the fitted one
  BekkerSoil law;
  bekker::Method method = bekker::Method::nonlinear;
  Sweep sweep;
  bool from_sweep = false;
  double table_error = 0;  ///< > 0: by a lookup table of that error bound
  double within = INFINITY;
};

bekker::Method method_of(const ConfigNode& node) {
  const std::string m = node.choice_or("method", "nonlinear", {"nonlinear", "quadratic", "linear"});
  return m == "nonlinear"   ? bekker::Method::nonlinear
         : m == "quadratic" ? bekker::Method::quadratic
                            : bekker::Method::linear;
}

std::vector<Compared> read_compare(const ConfigNode& node, const bekker::WheelSize& wheel) {
  std::vector<Compared> out;
  for (const ConfigNode& item : node.optional_list("compare")) {
    Compared c;
    c.name = item.text("name");
    c.table_error = item.quantity_or("table_error", 0, "1", Range::between(1e-5, 0.1));
    c.model = item.text_or("model", c.table_error > 0 ? "bekker table" : "bekker steady");
    c.method = method_of(item);
    c.within = item.quantity_or("slip_within", INFINITY, "1", Range::positive());
    if (const ConfigNode sweep = item.optional_map("sweep"); sweep.present()) {
      c.from_sweep = true;
      c.sweep = read_sweep(sweep, wheel);
      sweep.finish();
    } else if (item.has("soil")) {
      const SoilDraft d = draft_of_file(item, "soil");
      c.soil = "file";
      c.law = d.soil;
    }
    item.finish();
    out.push_back(std::move(c));
  }
  return out;
}

void add_curves(const bekker::WheelSize& wheel, const WheelData& d, const WheelFit& f, bekker::Method method,
                FitSection& s) {
  for (std::size_t c = 0; c < wheel_channels; ++c) {
    const WheelChannelName& info = wheel_channel_names()[c];
    FitCurve curve{
        channel_title(c), d.slip_text, channel_title(c) + " [" + info.shown_unit + "]", "fit", {}, {}, {}, {}, {}, {}};
    for (std::size_t i = 0; i < d.points.size(); ++i) {
      const WheelPoint& p = d.points[i];
      if (!std::isfinite(p.value[c])) continue;
      curve.x.push_back(p.stated_slip);
      curve.measured.push_back(p.value[c] * info.shown);
      curve.fitted.push_back(f.model[i][c] * info.shown);
      curve.error.push_back(p.error[c] * info.shown);
    }
    if (curve.x.empty()) continue;
    // The law between the points, at each slip with the load and slip angle of the nearest row.
    const auto [low, high] = std::minmax_element(d.points.begin(), d.points.end(),
                                                 [](auto& a, auto& b) { return a.stated_slip < b.stated_slip; });
    for (int k = 0; k <= 120; ++k) {
      const double x = low->stated_slip + (high->stated_slip - low->stated_slip) * k / 120;
      const auto near = std::min_element(d.points.begin(), d.points.end(), [&](auto& a, auto& b) {
        return std::abs(a.stated_slip - x) < std::abs(b.stated_slip - x);
      });
      WheelPoint p = *near;
      p.slip = slip_at_radius(x, d.rim, d.slip_radius, wheel.outer_radius());
      if (p.slip < -1 || p.slip > 0.999) continue;
      const WheelPrediction now = predict(wheel, f.soil, p, method);
      curve.line_x.push_back(x);
      curve.line_y.push_back(now.status == bekker::ForceStatus::ok ? now.value[c] * info.shown : nan);
    }
    s.curves.push_back(std::move(curve));
  }
}

std::string origin_key(const std::string& name) {
  if (name == "k" || name == "kc" || name == "kphi" || name == "n") return "pressure." + name;
  if (name[0] == 'a' || name[0] == 'b') return "contact_angles." + name;
  return "shear." + name;
}

void add_remarks(const WheelFit& f, const std::vector<WheelPoint>& points, ErrorModel errors, FitSection& s) {
  s.remarks = general_remarks(f.fit);
  if (f.fit.scale > 1.5)
    s.remarks.push_back(
        "The model does not fit within the stated errors: the residuals are " + shown(f.fit.scale, 3) +
        " times as large. The values are a compromise of a model that lacks something, not properties of the soil" +
        (errors == ErrorModel::scaled ? "; the standard errors are scaled by that factor." : "."));
  for (const Estimate& e : f.fit.estimates)
    if (std::abs(e.prior_z) > 3)
      s.remarks.push_back("'" + e.name + "' leaves its prior by " + shown(e.prior_z, 3) +
                          " standard deviations: structural misfit rather than a better value.");
  FitTable t{"Errors by channel",
             {"channel", "unit", "points", "rmse", "bias", "sd between repeats", "stated error", "measured range"},
             {}};
  for (const ChannelError& e : channel_errors(points, f.model)) {
    const WheelChannelName& c = wheel_channel_names()[static_cast<std::size_t>(e.channel)];
    t.rows.push_back({c.name, c.shown_unit, std::to_string(e.points), shown(e.rmse * c.shown), shown(e.bias * c.shown),
                      scatter_text(e, c.shown), shown(e.stated_error * c.shown, 3), shown(e.range * c.shown)});
  }
  s.tables.push_back(std::move(t));
}

Model predictions(const bekker::WheelSize& wheel, const BekkerSoil& soil, const std::vector<WheelPoint>& points,
                  bekker::Method method, const std::string& name, FitSection& s) {
  Model m;
  int failed = 0;
  for (const WheelPoint& p : points) {
    const WheelPrediction now = predict(wheel, soil, p, method);
    m.push_back(now.value);
    if (now.status == bekker::ForceStatus::ok) continue;
    m.back().fill(nan);
    if (failed++ == 0)
      s.remarks.push_back("'" + name + "' has no answer at slip " + shown(p.stated_slip) + ": " +
                          std::string(bekker::name_of(now.status)) + "; such points are left out of its errors.");
  }
  return m;
}

/// The same answers from a lookup table over the slips and loads of the points. Points with a slip angle have none.
Model looked_up(const bekker::WheelSize& wheel, const BekkerSoil& soil, const std::vector<WheelPoint>& points,
                const Compared& c, FitSection& s) {
  std::array<double, wheel_channels> none{};
  none.fill(nan);
  Model m(points.size(), none);
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.slip < b.slip; });
  const auto [light, heavy] =
      std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.load < b.load; });
  bekker::TableSpec spec;
  spec.wheel = wheel;
  spec.soil = bekker::SoilLaw::of(soil, wheel.width);
  spec.slip = {low->slip, high->slip};
  spec.load = {0.99 * light->load, 1.01 * heavy->load};
  spec.error_bound = c.table_error;
  spec.method = c.method;
  try {
    const bekker::WheelTable table = bekker::WheelTable::build(spec);
    for (std::size_t i = 0; i < points.size(); ++i) {
      bekker::TablePoint out;
      if (points[i].slip_angle != 0 || table.query(points[i].slip, points[i].load, 0, out) != bekker::TableStatus::ok)
        continue;
      m[i] = {out.drawbar(), out.torque, out.sinkage - points[i].sinkage_datum, nan};
    }
    s.remarks.push_back("'" + c.name + "' by lookup table: " + std::to_string(table.points()) +
                        " points, largest error found " + shown(table.error_found(), 2) + " where " +
                        shown(c.table_error, 2) + " was asked.");
  } catch (const bekker::TableError& e) {
    s.remarks.push_back("'" + c.name + "' has no lookup table: " + e.what());
  }
  return m;
}

}  // namespace

FitSection wheel_section(const ConfigNode& node, SoilDraft& draft, FitTable& compare) {
  FitSection s;
  s.kind = "wheel";
  const std::size_t before = node.errors();
  const bekker::WheelSize wheel = wheel_of(node);
  if (node.has("soil"))
    draft = draft_of_file(node, "soil");
  else if (!draft.has_pressure() || !draft.has_shear())
    node.error("no soil to start from; name a soil file as 'soil' or fit shear and pressure in the same file");
  const bekker::Method method = method_of(node);
  const ErrorModel errors = error_model(node, "scaled");
  const int starts = static_cast<int>(node.integer_or("starts", 12, 1, 1000));
  const std::string set = node.text_or("set", "wheel");
  const WheelData d = read_points(node.map("data"), wheel);
  const std::vector<WheelVariable> variables = read_variables(node, draft);
  const std::vector<Compared> others = read_compare(node, wheel);
  if (errors == ErrorModel::clustered)
    node.error_at("errors", "the rows of a wheel test are the unit here; stated or scaled");
  node.finish();
  if (node.errors() != before) return s;
  WheelFit f;
  try {
    f = fit_wheel(wheel, draft.soil, d.points, variables, method, errors, starts);
  } catch (const std::invalid_argument& e) {
    node.error(e.what());
    return s;
  }
  s.data = d.table.file().filename().string() + ", " + std::to_string(d.points.size()) + " rows";
  for (const Estimate& e : f.fit.estimates)
    for (const WheelParameter& k : wheel_parameters())
      if (e.name == k.name) s.parameters.push_back(shown_parameter(e, e.name, k.shown_unit, k.shown));
  s.correlation = f.fit.correlation;
  add_remarks(f, d.points, errors, s);
  add_curves(wheel, d, f, method, s);
  draft.soil = f.soil;
  for (const WheelVariable& v : variables)
    draft.put(origin_key(v.name), "wheel results, " + s.data + ", weighted least squares");
  compare.title = "Models on the same data";
  compare.columns = {
      "set",          "model",         "soil", "channel", "unit", "points", "rmse", "bias", "sd_between_repeats",
      "stated_error", "measured_range"};
  for (const Compared& c : others) {
    Model m;
    if (c.from_sweep)
      for (const WheelPoint& p : d.points) {
        m.push_back(interpolated(c.sweep, p.slip));
        m.back()[static_cast<std::size_t>(WheelChannel::sinkage)] -= p.sinkage_datum;
      }
    else if (c.table_error > 0)
      m = looked_up(wheel, c.soil.empty() ? f.soil : c.law, d.points, c, s);
    else
      m = predictions(wheel, c.soil.empty() ? f.soil : c.law, d.points, c.method, c.name, s);
    add_rows(compare, set, c.name, c.model, d.points, m, c.within);
  }
  return s;
}

}  // namespace grouser::diagnosis
