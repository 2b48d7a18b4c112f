#pragma once
// Wheel and soil points in a vertical plane: the published algorithm (dissertation 5.2.4), step by step.
//
// Soil is a row of points (s, z) on its surface, `spacing` apart at the start; they have no size and no mass. In a step of the wheel with
// velocity V = (w, vx, vz):
//   points within the window move by the soil velocity table,  (s, z) += dt S_v(V, s - s_hub, z - z_hub)               (V1)
//     but only while the soil's upward force on the wheel is positive and at least the weight on it (gate)
//   points deeper inside the rim than `penetration` are moved out along the radius until they are that deep            (V2)
//   force: points inside the rim carry S_p at their angle; between neighbours by angle no further apart than `gap` the pressure is linear,
//     F = b sum (p_i + p_i+1)/2 r (theta_i+1 - theta_i),   b width of the wheel; torque alike                          (V3)
//   bottom half: S_p(V, theta, height of the hub over the floor); top half: S_p(V, theta, z - z_hub)
//   vz is taken as zero where |vz| <= dead_band |vx|                                                                   (V4)
// Backward travel is the mirror image. A point alone carries nothing, as a wheel particle alone did not when the tables were made.
// Errors: TerrainError where a velocity or the hub's height lies outside the tables, unless outside = nearest.
// Cost: README, "Cost".
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "grouser/sdem/tables.h"
#include "grouser/terrain/state.h"

namespace grouser::sdem {

/// Numbers of the method that are not tables. Defaults as published, or the choice named in the README where nothing is printed.
struct SliceSettings {
  double spacing = 0.0025;      ///< of soil points [m]
  double penetration = 0.0005;  ///< largest, of points in the wheel [m]
  double dead_band = 0.05;      ///< of vx [-]
  bool gate = true;             ///< soil moves only while F_z >= W
  double gap = 0.01;            ///< widest, between points that carry pressure together [m]; not printed
  bool nearest = false;  ///< outside the tables: take the nearest velocity and height and count, instead of an error
  double floor = 0;      ///< [m] height of the floor that the bottom table counts from
};

/// Wheel in the plane: s along the way [m], z up [m].
struct WheelState {
  double s = 0, z = 0, vx = 0, vz = 0, w = 0;
};

struct SliceForce {
  double fx = 0, fz = 0;  ///< on the wheel, along the way and up [N]
  double torque = 0;      ///< that the soil asks of the motor, positive when driving [N m]
  double power = 0;       ///< of the soil on the wheel, from local pressure and rim velocity [W]
  double
      entry = 0,
      exit =
          0;  ///< largest and smallest angle of a point that carries, from the lowest point, positive in the direction of travel [rad]
  int contacts = 0;  ///< points inside the rim
};

class Slice {
 public:
  /// Undisturbed surface [m] at s.
  using Profile = std::function<double(double s)>;
  Slice(std::shared_ptr<const Tables> tables, const SliceSettings& settings);
  ~Slice();
  Slice(Slice&&) noexcept;
  Slice& operator=(Slice&&) noexcept;

  /// Points where there are none yet, within reach of s.
  void lay(double s, const Profile& profile);
  /// V1 and V2 with the wheel now at `x`. weight: on the wheel [N]; V1 acts while force_z >= weight, always with gate = false.
  void move(const WheelState& x, double dt, double force_z, double weight);
  /// V3. Moves nothing.
  SliceForce force(const WheelState& x, double width);
  /// Another height of the floor from here on [m].
  void set_floor(double z);
  /// vz after V4.
  double rounded(double vz, double vx) const;

  std::size_t size() const;          ///< points
  double s_of(std::size_t i) const;  ///< [m]
  double z_of(std::size_t i) const;  ///< [m]
  double height(double s) const;  ///< of the surface, linear between the points beside s; NaN where there are none [m]
  /// Times that a velocity or height outside the tables was replaced by the nearest one (nearest = true).
  std::int64_t outside() const;
  const SliceSettings& settings() const;
  void traverse(State& s);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grouser::sdem
