#pragma once
// Static equilibrium by SUNDIALS KINSOL: a wheel under its load, a vehicle on its wheels, any n equations. On any terrain whose
// force is a function of motion and state (Capabilities::continuous), asked through Terrain::preview, so that nothing is advanced.
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/terrain/terrain.h"

namespace grouser::vehicle {

/// No equilibrium was found: what() says what was asked, what was tried and why it failed.
struct TrimError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Residual r(x) of n equations in n unknowns.
using Residual = std::function<void(std::span<const double> x, std::span<double> r)>;

struct EquilibriumOptions {
  std::vector<double>
      x_scale;  ///< [unit of x] a change that matters, > 0; also the step of the difference Jacobian (1e-4 of it)
  std::vector<double> r_scale;  ///< [unit of r] a residual that is large, > 0
  double tolerance = 1e-9;      ///< [-] on max |r_i / r_scale_i|
  int max_iterations = 200;
};

struct EquilibriumResult {
  std::vector<double> x;
  double residual = 0;  ///< [-] max |r_i / r_scale_i| at x
  int iterations = 0;
  bool ok = false;
  std::string why;  ///< why not, in words; empty when ok
};

/// r(x) = 0 from x0 by Newton with line search (KINSOL, Dennis & Schnabel 1983). Needs a start with a non-singular Jacobian: a wheel
/// that hangs free has none, so bracket the height first (trim_wheel and trim_vehicle do). Never throws for a search that fails; an
/// exception of r itself is passed on.
EquilibriumResult solve_equilibrium(const Residual& r, std::vector<double> x0, const EquilibriumOptions& o);

/// Height z [m] of body `body`'s origin at which the terrain carries `load` [N] (> 0), at rest: V = 0, orientation and (x, y) of
/// `start`; the other bodies of the terrain are held clear of the soil.
/// The force is zero above touch-down, so the height is bracketed from first contact downwards (at most ten wheel radii), halved until
/// the change over the bracket is small and then solved by KINSOL.
/// @throws TrimError: the terrain is not continuous, load <= 0, the soil does not carry the load within the bracket, no convergence.
/// Cost: about 60 previews.
double trim_wheel(Terrain& terrain, int body, const Pose& start, double load);

struct TrimResult {
  double z = 0;      ///< [m] chassis origin over world zero
  double pitch = 0;  ///< [rad] about y, positive nose down
  double roll = 0;   ///< [rad] about x, positive left side up
  bool ok = false;
  std::string why;             ///< why not, in words; empty when ok
  std::vector<Wrench> wheels;  ///< [N, N m] what the terrain gives each wheel about its origin, W
};

/// Orientation of the chassis from (yaw, pitch, roll): R = Rz(yaw) Ry(pitch) Rx(roll).
Quat chassis_orientation(double yaw, double pitch, double roll);

/// Height, pitch and roll of a rigid body on wheels at rest (locked suspension). The terrain's bodies 0..n-1 are the wheels, in the
/// order of `wheels`: pose of each wheel body in the chassis frame. Solves
///   sum f_z = m g;   sum of moments about the centre of gravity, x and y components = 0
/// with V = 0, so without braking forces that have yet to build up. x, y and yaw are those of `guess`.
///   mass [kg] > 0, cog [m] in the chassis frame, gravity [m/s^2] > 0.
/// Start: the plane through the ground under the wheels, then the height bracketed for the whole weight, then the body settles along
/// dx/dt = r(x) (CVODE) into the stable equilibrium it rocks to, then KINSOL in all three.
/// ok = false with `why` when the body tips over (more than 1 rad), the soil does not carry it, or the search does not converge; the
/// values are then the last ones tried. Cost: 200 to 1000 previews. @throws TrimError for a terrain that is not continuous or
/// arguments out of range.
TrimResult trim_vehicle(Terrain& terrain, const std::vector<Pose>& wheels, double mass, const Vec3& cog, double gravity,
                        const Pose& guess);

}  // namespace grouser::vehicle
