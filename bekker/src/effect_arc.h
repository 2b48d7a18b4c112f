#pragma once
#include <algorithm>
#include <cmath>

#include "arc.h"

namespace grouser::bekker {

/// An arc with the named effects that change the stresses point by point (`Effect` has the formulas). What an amplitude of zero leaves
/// is the plain arc.
struct EffectArc : Arc {
  using Arc::Arc;
  static constexpr bool kEffects = true;

  double shear_radius = 0;                 ///< R [m]
  double per_pan = 0;                      ///< 1/H [1/m]
  double rate = 0, forward = 0;            ///< m [-]; speed of travel in the direction of this distribution [m/s]
  double zeta = 0, rolling = 0, side = 0;  ///< [-]; R w and lateral speed [m/s]
  double plate_speed = 1, least_speed = 1;
  double residual = 0, per_Kw = 0;  ///< rho [-], 1/Kw [1/m]

  /// 1/(1 - z/H); above 0.95 H its tangent, so that a wheel on the pan meets a stiff ground and not an infinite one.
  double pan(double z) const {
    if (per_pan == 0) return 1;
    const double x = z * per_pan;
    return x < 0.95 ? 1 / (1 - x) : 20 + 400 * (x - 0.95);
  }
  double pressure_rate(double sine) const {
    return rate == 0 ? 1 : std::pow(std::max(forward * sine, least_speed) / plate_speed, rate);
  }
  double shear_rate(double cosine) const {
    if (zeta == 0) return 1;
    const double v = std::hypot(rolling - forward * cosine, side);
    return std::max(0.0, 1 + zeta * std::log(std::max(v, least_speed) / plate_speed));
  }
  /// f and df/dj times 1 + rho exp(-j/Kw).
  void soften(double j, double& f, double& df) const {
    if (residual == 0) return;
    const double more = residual * std::exp(-j * per_Kw);
    df = df * (1 + more) - f * more * per_Kw;
    f *= 1 + more;
  }
};

}  // namespace grouser::bekker
