#pragma once
// A vehicle in a Bullet world (float64) on a terrain, with its energy account.
//
// Maximal coordinates: one btRigidBody per body, btHingeConstraint and btGeneric6DofSpring2Constraint for the joints,
// the direct solver (btMLCPSolver; all rows are equations, so it is one Cholesky factorisation).
// vehicle/README.md has the measured drift and cost of this and of the alternatives. Nothing collides: soil contact is
// the terrain's.
#include <algorithm>
#include <memory>
#include <vector>

#include "grouser/terrain/terrain.h"
#include "grouser/vehicle/trim.h"
#include "grouser/vehicle/vehicle_spec.h"

namespace grouser::vehicle {

struct WorldOptions {
  double gravity = 9.81;  ///< [m/s^2] >= 0, along -z
  /// direct: joint_solver.h. sequential: Bullet's default projected Gauss-Seidel with `iterations`. For measuring one against
  /// the other.
  enum class Solver { direct, sequential } solver = Solver::direct;
  int iterations = 50;
  double erp = 0.5;  ///< [-] (0, 1] share of a joint's position error that is removed per step
};

/// What the driver asks of one wheel's motor.
struct WheelCommand {
  enum class Mode { speed, torque } mode = Mode::speed;
  double value = 0;  ///< [rad/s] or [N m]
};
struct Command {
  std::vector<WheelCommand> wheels;  ///< one per VehicleSpec::wheels
  std::vector<double> steer;         ///< [rad] one per VehicleSpec::steering
};

/// [J] since the last reset_energy(), each from its own formula; all works with the mean of the velocities before and
/// after the step, for which change of kinetic energy = sum of impulse . mean velocity holds exactly at constant
/// orientation:
///   motor         sum torque * mean relative speed * dt (drive and steering)
///   damper        sum damping force * mean rate * dt, lost
///   soil_work     the terrain's own account: sum impulse . end velocity
///   implicit      (applied - terrain's impulse) . end velocity: the adapter's implicit correction
///   joints        constraint impulses (btJointFeedback) . mean velocity
///   integration   error of the time step: gravity and springs (work of the step's impulse against change of
///   potential), soil
///                 impulse (mean against end velocity), gyroscopic update and turning of the inertia tensor
struct VehicleEnergy {
  double kinetic = 0, potential = 0, spring = 0;  ///< state, potential relative to reset_energy()
  double motor = 0, damper = 0, soil_work = 0, implicit = 0, joints = 0, integration = 0;
  double battery = 0;         ///< taken from the battery
  double motor_positive = 0;  ///< sum over the steps of max(0, motor): what the motors put in while they drove
  double motor_gross = 0;     ///< sum of |motor|
  double kinetic_0 = 0, spring_0 = 0;
  /// What does not close.
  double residual() const {
    return motor - damper + soil_work + implicit + joints + integration - (kinetic - kinetic_0) - potential -
           (spring - spring_0);
  }
  /// What the residual is compared with: the positive motor work, or the height energy given up where that is more (coasting downhill).
  /// At least 1e-6 J: a parked vehicle has nothing to compare with.
  double yardstick() const { return std::max({motor_positive, -potential, 1e-6}); }
  const char* yardstick_name() const {
    return motor_positive >= -potential ? "positive motor work" : "height energy given up";
  }
};

class VehicleWorld {
 public:
  /// Adds the wheels to the terrain. @throws TerrainError for a running gear that the terrain cannot carry.
  VehicleWorld(const VehicleSpec& spec, std::shared_ptr<Terrain> terrain, const WorldOptions& options = {});
  ~VehicleWorld();
  VehicleWorld(const VehicleWorld&) = delete;

  /// Design pose, at rest, vehicle frame at X_WV.
  void place(const Pose& X_WV);
  /// Place at rest on the terrain, suspension locked in the design pose, near X_WV (x, y and yaw are kept). Where no
  /// equilibrium is found (`ok` false) the vehicle stands level, its lowest wheel just touching, and must settle from
  /// there.
  TrimResult trim(const Pose& X_WV);

  /// One step of dt [s]: joint forces and motors, Bullet's step, terrain. Cost with the adapter: robot 30 us, rover 120
  /// us (README.md), + terrain.
  void step(double dt, const Command& command);

  double time() const;
  const VehicleSpec& spec() const;
  Terrain& terrain();
  Pose pose(int link) const;               ///< X_WB
  Twist twist(int link) const;             ///< after the solve of the last step
  double joint_position(int joint) const;  ///< [rad] in (-pi, pi] or [m]
  double joint_speed(int joint) const;     ///< [rad/s] or [m/s]
  double motor_torque(int wheel) const;    ///< [N m] mean over the last step
  double motor_power() const;              ///< [W] mechanical, mean over the last step
  const ContactReport& contact(int wheel) const;
  Vec3 soil_force(int wheel) const;  ///< [N] applied in the last step, W
  /// [rad/s] frequency of the wheel's contact across the surface (TerrainAction::contact_rate)
  double contact_rate(int wheel) const;
  /// [m] largest distance of joined points, along the axis of a prismatic joint not counted.
  double joint_drift() const;
  Vec3 chassis_acceleration() const;  ///< [m/s^2] mean over the last step, W
  const VehicleEnergy& energy() const;
  /// Count from here: cumulated works to zero, potential energy relative to now.
  void reset_energy();
  double terrain_seconds() const;

  /// Everything a step depends on. Load into a world that was just built from the same spec: Bullet's hidden state is
  /// then the same too.
  void traverse(State& s);
  /// Index of the first body with a value that is not finite, or -1.
  int first_not_finite() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grouser::vehicle
