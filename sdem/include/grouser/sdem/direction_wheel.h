#pragma once
// One wheel of `sdem.v2` in its plane: direction.h integrated over a motion, with its rut.
#include <cmath>
#include <functional>
#include <memory>

#include "grouser/sdem/direction.h"
#include "grouser/sdem/rut.h"
#include "grouser/terrain/state.h"

namespace grouser::sdem {

struct DirectionSettings {
  double grain_noise = 1;  ///< scale of the fluctuation that single grains make; 0: none
  std::uint64_t seed = 1;
  double side_friction =
      0;               ///< [1] no part of the law: fitted by wheels that slide aside (examples/18_surrogate_in_3d)
  bool memory = true;  ///< D5; false: N = F_L or F_P by the direction of motion (ablation)
  bool pile = true;    ///< soil goes ahead and behind; false: all of it is compacted (ablation)
  /// Side force/N goes over l_t toward -side_friction dy/D, dy the way aside of the wheel's lowest point, dS of D5: D = dS where this is 0;
  ///   else  D^2 = dy^2 + (r w - v_t)^2 dt^2 + (side_turn dS)^2:  traction that turns with the sliding                          (D7)
  /// and then, for a wheel that slides aside, with c = sqrt(1 - (dy/D)^2): tau becomes c tau and mu becomes mu - (1 - c) tau: what drives the
  ///   rim turns, what resists the wheel (tau - mu) stays                                                                             (D8)
  double side_turn = 0;
  double around = 0.07;  ///< soil ahead of and behind the rim that is laid [m]

  /// What the spread of packings is multiplied by for an error bar: with the fluctuation the law is a draw of its own, as wide as the packings'.
  double wider() const { return std::hypot(1.0, grain_noise); }
};

/// Motion of the hub over a step at constant velocity; side: way along the axle.
struct PlaneMotion {
  double s0 = 0, z0 = 0, s1 = 0, z1 = 0;  ///< [m]
  double rim = 0, side = 0;               ///< r w dt and way along the axle [m]
  double dt = 0;                          ///< [s] counts for the loss of a wheel that all but rests, no more
};

/// On the wheel at the end of the motion, of the training's width.
struct PlaneForce {
  double fs = 0, fz = 0, side = 0;  ///< [N]
  double torque = 0;                ///< that the soil asks of the motor [N m]
  double normal = 0;                ///< N [N]
  double depth = 0;                 ///< d [m]
  double entry = 0, exit = 0;       ///< [rad]
  double tilt = 0, b = 0;
  bool contact = false, outside = false;
  // What a host's implicit step asks: changes at the end of the motion with the way.
  double normal_slope = 0;                              ///< dN/dd [N/m]
  double normal_s = 0, normal_z = 0;                    ///< -dd/ds, -dd/dz: N times this is the normal force
  double along_slope = 0;                               ///< dF_t by way along [N/m]
  double spin_slope = 0;                                ///< d(torque) by angle [N m/rad]
  double side_slope = 0;                                ///< d(side force) by way along the axle [N/m]
  double along_rate = 0, spin_rate = 0, side_rate = 0;  ///< the same by velocity [N s/m], [N m s/rad]
  bool rests = false;                                   ///< no way at all
  double work = 0;                                      ///< on the wheel over the way [J]
  double spent = 0, stored = 0;                         ///< dissipated over the way, stored now [J]
};

class DirectionWheel {
 public:
  DirectionWheel(std::shared_ptr<const Direction> law, const DirectionSettings& settings);
  using Height = std::function<double(double s)>;
  /// Goes along; `ground` is asked for soil that was not met yet.
  PlaneForce step(const PlaneMotion& m, const Height& ground);
  const Rut& rut() const { return rut_; }
  Rut& rut() { return rut_; }
  /// Height of the soil less its fresh offset; NaN where nothing is known.
  double surface(double s) const { return rut_.height(s) - law_->at(Coefficient::surface); }
  std::int64_t steps() const { return steps_; }
  std::int64_t outside() const { return outside_; }
  const Direction& law() const { return *law_; }
  void traverse(State& s);

 private:
  double noise(int channel, double at) const;

  std::shared_ptr<const Direction> law_;
  DirectionSettings settings_;
  Rut rut_;
  double elastic_ = 0;            ///< N/k, negative: how far the rim is clear of what it pressed [m]
  double last_along_ = 0;         ///< N u then [N]
  std::array<double, 4> last_{};  ///< forces and torque/r at the end of the last piece [N]
  double u_ = 0, m_ = 0, y_ = 0;  ///< of D6
  double worn_ = 0;               ///< travel plus sliding so far [m]
  double slow_b_ = 0;             ///< b over the way of the waves
  double nearer_ = 0;             ///< what grains lay nearer by at the last piece [m]
  double rise_ = 0;               ///< of the soil ahead, as the wheel has met it [m]
  std::int64_t steps_ = 0, outside_ = 0;
};

}  // namespace grouser::sdem
