#pragma once
// Grains as coarse and soft as a quick test may have them, and a wheel among them.
#include <memory>

#include "grouser/dem/sphere.h"
#include "grouser/terrain/loaders.h"

namespace grouser::test {

inline constexpr const char* kCoarseSoil = R"(soil: coarse soft grains
source: none
dem:
  diameter: [14 mm, 18 mm]
  density: 3.1 g/cm^3
  bulk_density: 1.6 g/cm^3
  young_modulus: 2 MPa
  poisson_ratio: 0.35
  friction: 0.6
  rolling: {law: constant, coefficient: 0.2}
  restitution: 0.4
  wall: {friction: 0.6, restitution: 0.4}
)";
inline constexpr const char* kCoarseOptions = "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm}";
inline constexpr double kRadius = 0.1, kWidth = 0.08;  // [m]

inline RunningGear coarse_wheel() { return {"wheel", SmoothCylinder{kRadius, kWidth}}; }

/// dem.sphere with these options on this ground.
inline std::unique_ptr<Terrain> coarse_terrain(GroundPtr ground = flat_ground(), int wheels = 1,
                                               const std::string& options = kCoarseOptions,
                                               const RunningGear& gear = coarse_wheel(),
                                               const std::string& soil_text = kCoarseSoil) {
  const ConfigDocument file = ConfigDocument::from_text(soil_text, "soil.yaml");
  const Soil soil = load_soil(file.root());
  const ConfigDocument given = ConfigDocument::from_text("options: " + options, "options.yaml");
  auto t = dem::sphere_model().make({soil, std::move(ground), given.root().map("options"), 9.81});
  file.check();
  given.check();
  for (int i = 0; i < wheels; ++i) t->add_body({"wheel" + std::to_string(i), gear, {}});
  return t;
}

/// A wheel that rolls along x at constant speed, spin and height; time 0 at x = 0.
struct Ride {
  double hub = kRadius, speed = 0.2, slip = 0.2, y = 0,
         sink = 0;  ///< hub height [m], [m/s], [-], [m], rate of sinking [m/s]
  Pose pose(double t) const {
    const double spin = speed / (1 - slip) / kRadius;
    return {Vec3(speed * t, y, hub - sink * t), Quat(Eigen::AngleAxisd(spin * t, Eigen::Vector3d::UnitY()))};
  }
  BodyMotion motion(double from, double to) const {
    const double spin = speed / (1 - slip) / kRadius;
    return {pose(from), pose(to), {Vec3(speed, 0, -sink), Vec3(0, spin, 0)}, {}};
  }
};

inline BodyResult step_one(Terrain& t, double time, double dt, const BodyMotion& m) {
  BodyResult r;
  t.step(time, dt, {&m, 1}, {&r, 1});
  return r;
}
inline State state_of(Terrain& t) {
  State s;
  t.traverse(s);
  return s;
}

}  // namespace grouser::test
