#pragma once
// Force of the soil on a steadily rolling wheel, and the sinkage at which the soil carries a load: for controllers, design studies and
// batches. Nothing here allocates or throws; every call is thread-safe and gives the same bits for any thread count.
#include <span>
#include <string_view>

#include "grouser/bekker/wheel_forces.h"

namespace grouser::bekker {

/// How the stresses on the arc are integrated.
enum class Method {
  nonlinear,  ///< quadrature of the stresses themselves, to a requested tolerance
  quadratic,  ///< each stress a parabola ahead of and behind theta_m (eqs 2.17 to 2.19): closed form
  linear,     ///< each stress a straight line there (eq 2.20): closed form
};

/// Arc of contact from theta_r (rear) to theta_f (entry) [rad], measured from the bottom, positive forward; with lugs theta_f is the angle
/// of the lug tips (radius r_s = r + h_g).
struct ArcAngles {
  double theta_f = 0, theta_m = 0, theta_r = 0;
};

/// Force [N] and moment about the hub [N m] of the soil on the wheel: x forward in the ground plane, y left, z up (eq 2.11).
struct WheelWrench {
  double Fx = 0;                  ///< drawbar pull
  double Fy = 0;                  ///< side force
  double Fz = 0;                  ///< normal force
  double Mx = 0, My = 0, Mz = 0;  ///< driving torque = -My
};

enum class ForceStatus {
  ok,
  bad_argument,        ///< a value is not finite or outside its range
  tolerance_not_met,   ///< the finest rule still changes by, or rounding leaves, more than it; the finest result
  no_pressure,         ///< |theta_m| >= theta_f: the pressure law carries nothing
  too_soft,            ///< the load is not reached with the wheel sunk to its hub (theta_f = pi/2)
  torque_not_reached,  ///< free slip: no slip in -1..1 asks for this torque
};
std::string_view name_of(ForceStatus status);

/// One wheel on one soil with the arc given.
struct ForceCase {
  WheelSize wheel;
  SoilLaw soil;
  ArcAngles arc;
  double slip = 0;               ///< s = (r_s w - v)/max(|r_s w|, |v|) in [-1, 1]; -1 locked: full mobilisation
  double slip_angle = 0;         ///< beta [rad] in (-pi/2, pi/2)
  double unloading_sinkage = 0;  ///< zu [m] >= 0 left by an earlier pass (eq 2.12); 0 = virgin soil
};

struct ForceResult {
  WheelWrench wrench;
  ForceStatus status = ForceStatus::ok;
};

/// Six components at a given arc. tolerance: error relative to |F| (of the moments: to |M|), 1e-13..1e-2; used by `nonlinear` only.
ForceResult forces(const ForceCase& c, Method method, double tolerance = 1e-6) noexcept;
/// The same for many rows at once. results.size() == cases.size(). For `nonlinear` at a tolerance of 1e-6 or looser, driven smooth wheels
/// on virgin soil are integrated eight at a time, in a third to half of the time: those rows differ from the call above within the
/// tolerance. The bits of a row do not depend on the rows beside it, their order or number.
void forces(std::span<const ForceCase> cases, Method method, double tolerance, std::span<ForceResult> results) noexcept;

/// One wheel that has to carry a load; theta_m and theta_r follow from theta_f by the soil's laws.
struct LoadCase {
  WheelSize wheel;
  SoilLaw soil;
  double load = 0;               ///< [N] > 0
  double slip = 0;               ///< as in ForceCase; ignored by solve_free_slip
  double slip_angle = 0;         ///< [rad]
  double unloading_sinkage = 0;  ///< zu [m] of an earlier pass
};

struct Solution {
  ForceStatus status = ForceStatus::ok;
  ArcAngles arc;
  double slip = 0;               ///< as given, or found by solve_free_slip
  double sinkage = 0;            ///< [m] of the lowest point (lug tips) below the undisturbed ground
  double unloading_sinkage = 0;  ///< zu [m] that this pass leaves: the larger of the earlier one and `sinkage`
  WheelWrench wrench;
};

/// Fz = load by a bracketed solver: ok means |Fz - load| <= 1e-9 load or a root at the last bit of theta_f.
Solution solve(const LoadCase& c, Method method, double tolerance = 1e-6) noexcept;
/// Fz = load and -My = torque [N m]: the slip that a free wheel takes under this torque, to 1e-9 of |torque| + load r
/// (where the torque steps by less than the tolerance, as rules of the integral change from slip to slip, to that).
/// Several slips may meet it: type A, isotropic, takes the first on the side towards the wanted torque, the others
/// the one of least size. torque_not_reached: none was found, with steps of slip from a fifth of what slides K
/// further over the arc, halved wherever three samples say that the torque could turn in between. Cost: 50 to 200
/// solves.
Solution solve_free_slip(const LoadCase& c, double torque, Method method, double tolerance = 1e-6) noexcept;

}  // namespace grouser::bekker
