#pragma once
// Shear displacement under the wheel: loads along the Janosi-Hanamoto curve, unloads and reloads elastically, renews by rolling.
#include "grouser/terrain/types.h"

namespace grouser::bekker {

/// u' = v - rho u - u/|u| (|u|/K) <rate at which |u| presses outward beyond y>,  y' = -rho y, y >= |u|   (S2)
struct Stick {
  Vec2 u = Vec2::Zero();  ///< (forward, lateral) [m], |u| <= y
  double y = 0;           ///< largest |u| so far [m], renewed by rolling like u
};

struct StickStep {
  Stick end;
  Eigen::Matrix2d du_dv;  ///< d(end u)/d(sliding velocity) / dt [-]
};

/// Over dt at constant sliding velocity v [m/s] and renewal rate rho >= 0 [1/s], K > 0 [m]. Exact within y, and beyond it while u does
/// not turn; where it turns, first order in dt.
StickStep advance(const Stick& begin, const Vec2& v, double rho, double K, double dt);

}  // namespace grouser::bekker
