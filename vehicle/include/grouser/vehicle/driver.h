#pragma once
// Drivers: what the wheels' motors and the steering are asked for. Read from the scenario's `driver:` map.
#include <memory>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/vehicle/vehicle_world.h"

namespace grouser::vehicle {

/// Where the vehicle is and how fast it goes, seen from the chassis.
struct VehicleView {
  Vec2 position = Vec2::Zero();  ///< [m] chassis origin, W
  double yaw = 0;                ///< [rad]
  double speed = 0;              ///< [m/s] along the heading
};

/// Base of the drivers. State: everything that the next command depends on.
class Driver {
 public:
  virtual ~Driver() = default;
  /// Command for the step that begins at time t [s]; t < 0: stand still (the vehicle settles).
  virtual void command(double t, double dt, const VehicleView& view, Command& out) = 0;
  virtual void traverse(State&) {}
  /// Where it is going to drive: corners of a box around start (0, 0, yaw 0) [m]; for the size of the ground in the 3-D
  /// view.
  virtual std::vector<Vec2> reach(double duration) const = 0;
  /// Greatest rim speed that it asks of a wheel without slip [m/s]; 0 where it commands torques.
  virtual double asked_speed() const { return 0; }
  /// True when it has nothing left to do.
  virtual bool done() const { return false; }
};

/// open_loop: table of rows {time, then one of speed (m/s, all wheels), left + right (rad/s), torque (N m, all wheels),
/// wheels: {name:
///   rad/s}; steer}. Values are interpolated linearly in time and held outside the table.
/// speed_hold: {speed, ramp, proportional_gain, integral_gain, steer}: wheel speed w r = v_target + kp e + ki
/// integral(e) dt, e = v_target - v. path: {speed, waypoints: [[x, y], ...], lookahead, tolerance, turn_gain}: pure
/// pursuit (Coulter 1992): curvature = 2 y_L / L^2 of the
///   point at distance L on the path, in the vehicle frame. Skid steering: rim speeds v (1 -+ turn_gain * curvature *
///   track/2); steered: tan(delta) = curvature * wheelbase, each kingpin by its own radius. Waypoints are relative to
///   the start. Stops at the last one.
/// Errors are noted at their place; the result may be null then.
std::unique_ptr<Driver> make_driver(const ConfigNode& map, const VehicleSpec& vehicle, const Pose& start);

}  // namespace grouser::vehicle
