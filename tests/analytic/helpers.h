#pragma once
#include <cmath>
#include <functional>
#include <random>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/registry.h"
#include "grouser/terrain/terrain.h"

namespace grouser::test {

/// Ground from a function and a resolution.
class FunctionGround final : public Ground {
 public:
  FunctionGround(std::function<double(double, double)> f, double resolution)
      : f_(std::move(f)), resolution_(resolution) {}
  double height(double x, double y) const override { return f_(x, y); }
  double resolution() const override { return resolution_; }
  std::string describe() const override { return "test ground"; }

 private:
  std::function<double(double, double)> f_;
  double resolution_;
};

inline GroundPtr ground_of(std::function<double(double, double)> f, double resolution = INFINITY) {
  return std::make_shared<FunctionGround>(std::move(f), resolution);
}

/// MIT wheel and Mojave Martian Simulant: dissertation Tables 4.1, 4.5, 4.6.
inline BekkerSoil mojave(double reference_width = 0.05) {
  BekkerSoil s;
  s.pressure = {PressureSinkage::Law::k_b, 0, 0, 2.541e5, 1.387, reference_width};
  s.shear = {ShearLaw::Type::A, 139.28, 0.606, 5.151e-4, 0, 1};
  return s;
}
inline RunningGear mit_wheel() { return {"mit", SmoothCylinder{0.13, 0.16}}; }

/// One wheel whose body is the gear itself, moved by hand.
struct Bench {
  std::unique_ptr<Terrain> terrain;
  double t = 0;
  BodyMotion motion;
  BodyResult result;

  Bench(const ModelInfo& model, const Soil& soil, GroundPtr ground, RunningGear gear = mit_wheel(),
        const std::string& options = "") {
    const ConfigDocument doc = ConfigDocument::from_text(options.empty() ? "{}" : options, "options.yaml");
    terrain = model.make({soil, std::move(ground), options.empty() ? ConfigNode{} : doc.root(), 9.81});
    doc.check();
    terrain->add_body({"wheel", std::move(gear), {}});
  }
  /// Move the hub with a constant twist for dt and step.
  const BodyResult& move(const Twist& V, double dt) {
    motion.X_WB_begin = motion.X_WB_end;
    motion.X_WB_end.p += dt * V.v;
    const double angle = V.w.norm() * dt;
    if (angle > 0)
      motion.X_WB_end.q = (Quat(Eigen::AngleAxisd(angle, V.w.normalized())) * motion.X_WB_end.q).normalized();
    motion.V_WB_end = V;
    terrain->step(t, dt, {&motion, 1}, {&result, 1});
    t += dt;
    return result;
  }
  Vec3 force(double dt) const { return result.impulse / dt; }
  Vec3 moment(double dt) const { return result.angular_impulse / dt; }
};

}  // namespace grouser::test
