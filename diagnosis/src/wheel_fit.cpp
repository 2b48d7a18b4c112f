#include "grouser/diagnosis/wheel_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "grouser/terrain/types.h"

namespace grouser::diagnosis {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double solver_tolerance = 1e-8;  // well below the differences of the fit's Jacobian

double* place(BekkerSoil& s, const std::string& name) {
  if (name == "k") return &s.pressure.k;
  if (name == "kc") return &s.pressure.kc;
  if (name == "kphi") return &s.pressure.kphi;
  if (name == "n") return &s.pressure.n;
  if (name == "cohesion") return &s.shear.cohesion;
  if (name == "friction_angle") return &s.shear.friction_angle;
  if (name == "K") return &s.shear.K;
  if (name == "Kw") return &s.shear.Kw;
  if (name == "Kr") return &s.shear.Kr;
  if (name == "a0") return &s.angles.a0;
  if (name == "a1") return &s.angles.a1;
  if (name == "b0") return &s.angles.b0;
  if (name == "b1") return &s.angles.b1;
  throw std::invalid_argument("no soil parameter '" + name + "'");
}

}  // namespace

const std::array<WheelChannelName, wheel_channels>& wheel_channel_names() {
  static const std::array<WheelChannelName, wheel_channels> names{{{"drawbar_pull", "N", "N", 1},
                                                                   {"driving_torque", "N m", "N m", 1},
                                                                   {"sinkage", "m", "mm", 1000},
                                                                   {"side_force", "N", "N", 1}}};
  return names;
}

const std::vector<WheelParameter>& wheel_parameters() {
  static const std::vector<WheelParameter> list{
      {"k", "Pa", "kPa", 1e-3, 1, 1e12, 1, true},
      {"kc", "N/m^(n+1)", "kN/m^(n+1)", 1e-3, -1e12, 1e12, 1e4, false},
      {"kphi", "N/m^(n+2)", "kN/m^(n+2)", 1e-3, 1, 1e12, 1, true},
      {"n", "1", "1", 1, 0.05, 4, 0.2, false},
      {"cohesion", "Pa", "Pa", 1, 0, 1e6, 200, false},
      {"friction_angle", "rad", "deg", 180 / pi, 0, 1.5, 0.1, false},
      {"K", "m", "mm", 1000, 1e-5, 0.5, 1, true},
      {"Kw", "m", "mm", 1000, 1e-5, 0.5, 1, true},
      {"Kr", "1", "1", 1, 0.01, 1, 0.1, false},
      {"a0", "1", "1", 1, 0, 1, 0.1, false},
      {"a1", "1", "1", 1, 0, 1, 0.1, false},
      {"b0", "1", "1", 1, 0, 1, 0.1, false},
      {"b1", "1", "1", 1, 0, 1, 0.1, false},
  };
  return list;
}

double get_parameter(const BekkerSoil& soil, const std::string& name) {
  return *place(const_cast<BekkerSoil&>(soil), name);
}
void set_parameter(BekkerSoil& soil, const std::string& name, double value) { *place(soil, name) = value; }

double slip_at_radius(double slip, bool rim, double radius, double outer_radius) {
  // kappa = v/(R w) of the data's own radius, then of the outer one.
  double kappa = rim || slip >= 0 ? 1 - slip : slip <= -1 ? INFINITY : 1 / (1 + slip);
  kappa *= radius / outer_radius;
  return kappa <= 1 ? 1 - kappa : 1 / kappa - 1;
}

WheelPrediction predict(const bekker::WheelSize& wheel, const BekkerSoil& soil, const WheelPoint& p,
                        bekker::Method method) {
  bekker::LoadCase c;
  c.wheel = wheel;
  c.soil = bekker::SoilLaw::of(soil, wheel.width);
  c.load = p.load;
  c.slip = p.slip;
  c.slip_angle = p.slip_angle;
  const bekker::Solution s = bekker::solve(c, method, solver_tolerance);
  return {s.status, {s.wrench.Fx, -s.wrench.My, s.sinkage - p.sinkage_datum, s.wrench.Fy}};
}

std::vector<ChannelError> channel_errors(const std::vector<WheelPoint>& points,
                                         const std::vector<std::array<double, wheel_channels>>& model) {
  std::vector<ChannelError> out;
  for (std::size_t c = 0; c < wheel_channels; ++c) {
    ChannelError e{static_cast<WheelChannel>(c), 0, 0, 0, 0, nan, 0, nan};
    double low = INFINITY, high = -INFINITY, stated = 0;
    int with_error = 0;
    std::map<std::string, std::vector<double>> groups;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double y = points[i].value[c];
      if (!std::isfinite(y) || !std::isfinite(model[i][c])) continue;
      const double r = model[i][c] - y;
      e.rmse += r * r;
      e.bias += r;
      ++e.points;
      low = std::min(low, y);
      high = std::max(high, y);
      if (std::isfinite(points[i].error[c])) stated += points[i].error[c] * points[i].error[c], ++with_error;
      if (!points[i].condition.empty()) groups[points[i].condition].push_back(y);
    }
    if (e.points == 0) continue;
    e.rmse = std::sqrt(e.rmse / e.points);
    e.bias /= e.points;
    e.range = high - low;
    if (with_error > 0) e.stated_error = std::sqrt(stated / with_error);
    double squares = 0;
    for (const auto& [name, y] : groups) {
      double mean = 0;
      for (const double v : y) mean += v / static_cast<double>(y.size());
      for (const double v : y) squares += (v - mean) * (v - mean);
      e.scatter_dof += static_cast<int>(y.size()) - 1;
    }
    if (e.scatter_dof > 0) e.scatter = std::sqrt(squares / e.scatter_dof);
    out.push_back(e);
  }
  return out;
}

WheelFit fit_wheel(const bekker::WheelSize& wheel, const BekkerSoil& start, const std::vector<WheelPoint>& points,
                   const std::vector<WheelVariable>& variables, bekker::Method method, ErrorModel errors, int starts) {
  LeastSquaresProblem p;
  for (const WheelVariable& v : variables) {
    const auto known =
        std::find_if(wheel_parameters().begin(), wheel_parameters().end(), [&](auto& k) { return v.name == k.name; });
    if (known == wheel_parameters().end()) throw std::invalid_argument("no soil parameter '" + v.name + "'");
    p.variables.push_back(
        {v.name, get_parameter(start, v.name), v.lower, v.upper, known->scale, known->logarithmic, v.prior, -1});
  }
  for (const WheelPoint& point : points) {
    const WheelPrediction now = predict(wheel, start, point, method);
    if (now.status != bekker::ForceStatus::ok)
      throw std::invalid_argument("with the start values slip " + std::to_string(point.stated_slip) + " at " +
                                  std::to_string(point.load) + " N: " + std::string(bekker::name_of(now.status)));
    for (std::size_t c = 0; c < wheel_channels; ++c) {
      if (!std::isfinite(point.value[c])) continue;
      if (!(point.error[c] > 0))
        throw std::invalid_argument(std::string("channel ") + wheel_channel_names()[c].name +
                                    " has no error to weigh it by");
      ++p.residuals;
    }
  }
  const auto soil_of = [&](std::span<const double> x) {
    BekkerSoil s = start;
    for (std::size_t i = 0; i < variables.size(); ++i) set_parameter(s, variables[i].name, x[i]);
    return s;
  };
  p.errors = errors;
  p.starts = starts;
  p.step = 1e-4;
  p.model = [&](std::span<const double> x, std::span<double> r) {
    const BekkerSoil s = soil_of(x);
    std::size_t k = 0;
    for (const WheelPoint& point : points) {
      const WheelPrediction now = predict(wheel, s, point, method);
      if (now.status != bekker::ForceStatus::ok) return false;
      for (std::size_t c = 0; c < wheel_channels; ++c)
        if (std::isfinite(point.value[c])) r[k++] = (now.value[c] - point.value[c]) / point.error[c];
    }
    return true;
  };
  WheelFit out;
  out.fit = solve_least_squares(p);
  std::vector<double> best;
  for (const Estimate& e : out.fit.estimates) best.push_back(e.value);
  out.soil = soil_of(best);
  for (const WheelPoint& point : points) out.model.push_back(predict(wheel, out.soil, point, method).value);
  return out;
}

}  // namespace grouser::diagnosis
