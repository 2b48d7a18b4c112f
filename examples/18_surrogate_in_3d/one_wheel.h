#pragma once
// One wheel, free in height under a load, at a slip and a slip angle on any terrain model.
// The greater of the rim's and the hub's velocity along the wheel is 60 mm/s; the hub goes aside (y, left) at |vx| tan(angle).
// Means and standard deviations over the last 65 % of the way.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "grouser/models.h"
#include "grouser/terrain/loaders.h"

namespace one_wheel {

using grouser::Pose;
using grouser::Quat;
using grouser::Vec3;

inline constexpr double kRadius = 0.065, kSpeed = 0.06, kGravity = 9.81;  // [m, m/s, m/s^2]
inline constexpr double kStep = 5e-4, kRamp = 0.2, kRest = 0.1, kDown = 0.02, kClear = 0.002;
inline constexpr double kSkipped = 0.35;  // share of the way before the means

struct Mean {
  double sum = 0, squares = 0;
  int n = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++n;
  }
  double mean() const { return sum / n; }
  double sd() const { return std::sqrt(std::max(0.0, squares / n - mean() * mean())); }
};

class Wheel {
 public:
  Wheel(std::unique_ptr<grouser::Terrain> terrain, double width, double load)
      : terrain_(std::move(terrain)), load_(load) {
    terrain_->add_body({"wheel", {"wheel", grouser::SmoothCylinder{kRadius, width}}, {}});
  }
  /// angle [rad]; the way [m] is that along the wheel.
  void run(double slip, double angle, double way) {
    const double vx = slip > 0 ? kSpeed * (1 - slip) : kSpeed, rim = slip > 0 ? kSpeed : kSpeed / (1 - slip);
    const double vy = vx * std::tan(angle);
    while (force_.z() < load_) step(Vec3(0, 0, -kDown), 0);
    for (int k = 0; k * kStep < kRest; ++k) free(0, 0, 0);
    const std::clock_t begin = std::clock();
    const double t0 = t_;
    for (double ramp = 0; at_.x() < way;) {
      ramp = std::min(1.0, ramp + kStep / kRamp);
      free(ramp * vx, ramp * vy, ramp * rim / kRadius);
      if (at_.x() < kSkipped * way) continue;
      sinkage_.add(kRadius - at_.z());
      drawbar_.add(force_.x());
      side_.add(force_.y());
      torque_.add(torque_now_);
    }
    const double busy = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    processor_ = busy / (t_ - t0);
  }
  const Mean& sinkage() const { return sinkage_; }  ///< [m]
  const Mean& drawbar() const { return drawbar_; }  ///< [N]
  const Mean& side() const { return side_; }        ///< [N] to the left
  const Mean& torque() const { return torque_; }    ///< [N m] that drives
  double processor() const { return processor_; }   ///< seconds per simulated second

 private:
  Pose pose() const { return {at_, Quat(Eigen::AngleAxisd(turn_, Vec3::UnitY()))}; }
  void step(const Vec3& v, double spin) {
    grouser::BodyMotion m{pose(), {}, {}, {}};
    at_ += kStep * v;
    turn_ += kStep * spin;
    m.X_WB_end = pose();
    m.V_WB_end.v = v;
    m.V_WB_end.w = Vec3(0, spin, 0);
    grouser::BodyResult r;
    terrain_->step(t_, kStep, {&m, 1}, {&r, 1});
    t_ = terrain_->time();
    force_ = r.impulse / kStep;
    torque_now_ = -r.angular_impulse.y() / kStep;
    stiffness_ = r.linearisation ? std::max(0.0, -r.linearisation->dF_dx(2, 2)) : 0;
    damping_ = r.linearisation ? std::max(0.0, -r.linearisation->dF_dv(2, 2)) : 0;
    vz_ = v.z();
  }
  /// Height free, with the stiffness that the terrain tells.
  void free(double vx, double vy, double spin) {
    const double m = load_ / kGravity, k = kStep * kStep * stiffness_ + kStep * damping_;
    step(Vec3(vx, vy, ((m + kStep * damping_) * vz_ + kStep * (force_.z() - load_)) / (m + k)), spin);
  }

  std::unique_ptr<grouser::Terrain> terrain_;
  Vec3 at_{0, 0, kRadius + kClear}, force_ = Vec3::Zero();
  double load_, t_ = 0, turn_ = 0, vz_ = 0, stiffness_ = 0, damping_ = 0, torque_now_ = 0,
         processor_ = 0;
  Mean sinkage_, drawbar_, side_, torque_;
};


/// A terrain on flat ground. options: those of the model as YAML, '{law: law.h5, rows: 4}'.
inline std::unique_ptr<grouser::Terrain> flat_terrain(const std::string& model, const std::string& soil_file,
                                                      const std::string& options) {
  const grouser::Soil soil = grouser::load_soil_file(soil_file);
  const auto given = grouser::ConfigDocument::from_text("options: " + options + "\n", "OPTIONS");
  auto terrain = grouser::all_models().get(model).make(
      {soil, grouser::flat_ground(), given.root().map("options"), kGravity});
  given.check();
  return terrain;
}

}  // namespace one_wheel
