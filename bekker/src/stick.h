#pragma once
// Shear displacement under the wheel: loads along the Janosi-Hanamoto curve, unloads and reloads elastically, renews by rolling.
#include "grouser/terrain/types.h"

namespace grouser::bekker {

/// u' = v - rho u - u/|u| (|u|/K) <rate at which |u| presses outward beyond y>,  y' = -rho y, y >= |u|   (S2)
/// The shear stress answers to `felt` = u + tau/(1 + rho tau) (v - rho u), brought back to |felt| <= y (Kelvin-Voigt): damping of what
/// moves within y. It never exceeds what the soil has borne already, and in steady rolling felt = u.
struct Stick {
  Vec2 u = Vec2::Zero();  ///< (forward, lateral) [m], |u| <= y
  double y = 0;           ///< largest |u| so far [m], renewed by rolling like u
};

struct StickStep {
  Stick end;
  Vec2 felt = Vec2::Zero();   ///< at the end of the step [m]
  Eigen::Matrix2d dfelt_dv;   ///< d(felt)/d(sliding velocity) / dt [-]
};

/// Over dt at constant sliding velocity v [m/s], renewal rate rho >= 0 [1/s], K > 0 [m], damping time tau >= 0 [s]. Exact within y, and
/// beyond it while u does not turn; where it turns, first order in dt.
StickStep advance(const Stick& begin, const Vec2& v, double rho, double K, double tau, double dt);

}  // namespace grouser::bekker
