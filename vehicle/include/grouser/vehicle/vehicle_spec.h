#pragma once
// A vehicle as data: what a YAML or URDF file says, in SI, checked. The Bullet world is built from it by
// vehicle_world.h.
//
// Frames: V = vehicle frame of the design pose (x forward, y left, z up; origin where the file puts it), B = body
// frame: origin at the centre of mass, axes as given by the file.
#include <optional>
#include <string>
#include <vector>

#include "grouser/terrain/running_gear.h"

namespace grouser::vehicle {

/// Shape for the 3-D view only; nothing collides with it.
struct Visual {
  enum class Kind { box, cylinder } kind = Kind::box;
  Vec3 size = Vec3::Zero();  ///< [m] box: full lengths; cylinder: (radius, length, 0), axis y
  Pose X_BS;                 ///< shape in the body frame
};

struct LinkSpec {
  std::string name;
  double mass = 0;              ///< [kg] > 0
  Mat3 inertia = Mat3::Zero();  ///< [kg m^2] about the centre of mass, axes of B
  Pose X_VB;                    ///< design pose
  std::vector<Visual> visuals;
};

/// End stop: a spring-damper that acts beyond `lower` and `upper`.
struct StopSpec {
  double lower = 0, upper = 0;  ///< [m] or [rad], lower < upper
  double stiffness = 0;         ///< [N/m] or [N m/rad]
  double damping = 0;           ///< [N s/m] or [N m s/rad], never pulls
};

/// Joint with one degree of freedom q (0 in the design pose): rotation about or travel along `axis`.
///   force on q = -stiffness (q - rest) - damping dq/dt + stops
struct JointSpec {
  enum class Type { revolute, prismatic } type = Type::revolute;
  std::string name;
  int parent = -1, child = -1;  ///< indices of links
  Vec3 anchor_V = Vec3::Zero(), axis_V = Vec3::UnitY();
  double stiffness = 0, rest = 0, damping = 0;
  std::optional<StopSpec> stops;
};

/// Speed-controlled electric motor. Limit of the driving torque by table |speed| -> torque (linear in between, zero
/// beyond the last); a torque against the motion is limited by the value at standstill.
///   torque = clamp(speed_gain (w_target - w) + angle_gain * integral(w_target - w) dt)
struct MotorSpec {
  std::string name;
  std::vector<double> speed;   ///< [rad/s] ascending from 0
  std::vector<double> torque;  ///< [N m] >= 0
  double efficiency = 1;       ///< [-] (0, 1] mechanical over electrical when driving
  double regeneration = 0;     ///< [-] [0, 1] electrical over mechanical when braking
  double speed_gain = 0;       ///< [N m s/rad]
  double angle_gain = 0;       ///< [N m/rad]
  double limit(double speed_now, double sign) const;
};

struct WheelSpec {
  std::string name;
  int link = -1, joint = -1;  ///< the wheel's body and its axle
  RunningGear gear;
  int motor = -1;    ///< index of VehicleSpec::motors; -1 = not driven
  bool left = true;  ///< side, by the sign of y in the design pose
};

/// Position-controlled steering joint: torque = clamp(gain (angle_target - angle) - damping * rate, +-max_torque).
struct SteerSpec {
  int joint = -1;
  double max_angle = 0;   ///< [rad]
  double gain = 0;        ///< [N m/rad]
  double damping = 0;     ///< [N m s/rad]
  double max_torque = 0;  ///< [N m]
};

/// Differential of a rocker-bogie: keeps q_a + sign q_b = 0 (the chassis pitches by the mean of the rockers) by a stiff
/// torsion spring.
///   torque on q_a: -(stiffness e + damping de/dt), on q_b: sign times that;  e = q_a + sign q_b
struct DifferentialSpec {
  int joint_a = -1, joint_b = -1;
  double sign = 1;
  double stiffness = 0;  ///< [N m/rad]
  double damping = 0;    ///< [N m s/rad]
};

struct VehicleSpec {
  std::string name, file;
  std::vector<LinkSpec> links;  ///< 0 is the chassis: the only one that is nobody's child
  std::vector<JointSpec> joints;
  std::vector<WheelSpec> wheels;
  std::vector<MotorSpec> motors;
  std::vector<SteerSpec> steering;  ///< empty = skid steering
  std::optional<DifferentialSpec> differential;
  double battery_capacity = 0;  ///< [J]; 0 = not limited
  double total_mass() const;
  Vec3 centre_of_mass_V() const;
  double track() const;      ///< [m] distance of the wheels' sides, from the design pose
  double wheelbase() const;  ///< [m] foremost to rearmost axle
};

/// Rigid union of two bodies given in V: mass, centre, inertia (parallel axes). `a` keeps its name and axes.
void merge_fixed(LinkSpec& a, const LinkSpec& b);

/// Solid cuboid and solid cylinder about y: inertia [kg m^2].
Mat3 box_inertia(double mass, const Vec3& size);
Mat3 cylinder_inertia(double mass, double radius, double length);

}  // namespace grouser::vehicle
