#include "arc.h"

#include <algorithm>
#include <cmath>

#include "grouser/bekker/wheel_forces.h"
#include "kernel.h"

namespace grouser::bekker {

namespace {

double stretch_of(double theta_f, double theta_m, double theta_r) {
  return theta_m > theta_r ? (theta_f - theta_m) / (theta_m - theta_r) : 0;
}

ArcSines sines_of(double theta_f, double beta) {
  if (theta_f <= pi) return kernel().sines(theta_f, beta);
  return {std::sin(0.5 * theta_f), std::cos(0.5 * theta_f), std::tan(beta)};
}

}  // namespace

Arc::Arc(const WheelSize& wheel, const SoilLaw& soil, const ArcAngles& angles, ShearState state, double unloading,
         double pressure_factor)
    : Arc(wheel, soil, angles, state, unloading, pressure_factor, sines_of(angles.theta_f, 0)) {}

Arc::Arc(const WheelSize& wheel, const SoilLaw& soil, const ArcAngles& angles, ShearState state, double unloading,
         double pressure_factor, const ArcSines& sines)
    : r(wheel.outer_radius()),
      b(wheel.width),
      theta_f(angles.theta_f),
      theta_m(angles.theta_m),
      theta_r(angles.theta_r),
      sin_half(sines.sin_half),
      cos_half(sines.cos_half),
      sin_f(2 * sin_half * cos_half),
      cos_f((cos_half - sin_half) * (cos_half + sin_half)),
      stretch(stretch_of(theta_f, theta_m, theta_r)),
      modulus(soil.modulus * pressure_factor),
      n(soil.n),
      type(soil.shear.type),
      cohesion(modulus > 0 ? soil.shear.cohesion : 0),  // what does not press does not shear
      tan_phi(soil.tan_phi),
      inv_K(1 / soil.shear_displacement()),
      anisotropic(soil.lateral == Lateral::anisotropic),
      e(state),
      tan_beta(sines.tan_beta) {
  if (unloading > 0) {
    zu = unloading;
    slope = pressure_factor * (soil.ko + soil.Au * zu);
    peak = modulus * std::pow(zu, n);
  }
  if (wheel.lug_height > 0) {
    lugs = true;
    mu = wheel.lug_ratio;
    r_ca = wheel.radius;
    // h_f > h_g, eq 2.14 with r_s - h_f = r_s cos theta_f.
    const double square = (r * sin_half * sin_half - 0.5 * wheel.lug_height) / r_ca;  // of sin(theta_ca/2)
    theta_ca = square > 0 ? 2 * std::asin(std::sqrt(std::min(square, 1.0))) : 0;
    concave = theta_ca > 0 && theta_ca > theta_m && mu < 1;
    if (concave) {
      sin_ca = std::sin(theta_ca);
      cos_ca = std::cos(theta_ca);
      stretch_ca = stretch_of(theta_ca, theta_m, theta_r);
    } else if (mu == 0) {
      cohesion = 0;  // the tread is clear of the soil and the lugs have no tips
    }
  }
  if (type == ShearLaw::Type::C) {
    constexpr double euler = 2.718281828459045235;
    Kr = soil.shear.Kr;
    hump = euler * (1 / (Kr * (1 - 1 / euler)) - 1);
  }
}

Arc::Arc(const ForceCase& c)
    : Arc(c.wheel, c.soil, c.arc, {}, c.unloading_sinkage, 1, sines_of(c.arc.theta_f, c.slip_angle)) {
  locked = c.slip <= -1;
  const double kappa = locked ? 1 : kappa_of_slip(c.slip);
  e = {1 - kappa, kappa * tan_beta};
}

ForceStatus status_of(const ForceCase& c) {
  const WheelSize& w = c.wheel;
  const SoilLaw& s = c.soil;
  const ArcAngles& a = c.arc;
  const double K = s.shear_displacement();
  const double all = w.radius + w.width + w.lug_height + w.lug_ratio + s.modulus + s.n + s.shear.cohesion + s.tan_phi +
                     K + s.ko + s.Au + a.theta_f + a.theta_m + a.theta_r + c.slip + c.slip_angle + c.unloading_sinkage;
  if (!std::isfinite(all)) return ForceStatus::bad_argument;
  const bool sizes = w.radius > 0 && w.width > 0 && w.lug_height >= 0 && w.lug_ratio >= 0 && w.lug_ratio <= 1;
  const bool soil = s.modulus > 0 && s.n > 0 && s.shear.cohesion >= 0 && s.tan_phi >= 0 && K > 0 &&
                    (s.shear.type != ShearLaw::Type::C || (s.shear.Kr > 0 && s.shear.Kr <= 1));
  const bool motion = std::abs(c.slip) <= 1 && std::abs(c.slip_angle) < pi / 2;
  const bool reload = c.unloading_sinkage == 0 || (c.unloading_sinkage > 0 && s.ko + s.Au * c.unloading_sinkage > 0);
  const bool angles = a.theta_f >= 0 && a.theta_f - a.theta_r <= pi && a.theta_r <= a.theta_m;
  if (!(sizes && soil && motion && reload && angles)) return ForceStatus::bad_argument;
  if (a.theta_m >= a.theta_f || a.theta_m <= -a.theta_f) return ForceStatus::no_pressure;  // z = 0 at theta_m, or less
  return ForceStatus::ok;
}

}  // namespace grouser::bekker
