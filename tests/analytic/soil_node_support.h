#pragma once
#include "grouser/bekker/soil_node.h"
#include "grouser/terrain/config.h"
#include "helpers.h"

namespace grouser::test {

/// bekker.soil_node with options given as YAML text.
inline std::unique_ptr<Terrain> soil_nodes(const Soil& soil, const std::string& options,
                                           GroundPtr ground = flat_ground()) {
  const ConfigDocument document = ConfigDocument::from_text(options.empty() ? "{}" : options, "options.yaml");
  auto terrain = bekker::soil_node_model().make({soil, std::move(ground), document.root(), 9.81});
  document.check();
  return terrain;
}

inline Soil mojave_soil() {
  Soil s;
  s.name = "Mojave";
  s.bekker = mojave();
  s.bulk_density = 1600;
  return s;
}

/// One gear moved by hand.
struct Mover {
  std::unique_ptr<Terrain> terrain;
  double t = 0;
  BodyMotion motion{};
  BodyResult result;

  Mover(std::unique_ptr<Terrain> t_in, RunningGear gear, const Vec3& hub) : terrain(std::move(t_in)) {
    terrain->add_body({"wheel", std::move(gear), {}});
    motion.X_WB_begin.p = motion.X_WB_end.p = hub;
  }
  const ContactReport& move(const Vec3& v, double spin, double dt) {
    motion.X_WB_begin = motion.X_WB_end;
    motion.X_WB_end.p += dt * v;
    motion.X_WB_end.q = (Quat(Eigen::AngleAxisd(spin * dt, Eigen::Vector3d::UnitY())) * motion.X_WB_end.q).normalized();
    motion.V_WB_end = {v, Vec3(0, spin, 0)};
    terrain->step(t, dt, {&motion, 1}, {&result, 1});
    t += dt;
    return result.report;
  }
};

/// Box of length x width x height as a mesh, its underside at z = -height/2 of the gear frame.
inline RunningGear plate(double length, double width) {
  TriangleMesh m;
  const double z = 0.01;
  for (int k = 0; k < 8; ++k)
    m.vertices.emplace_back((k & 1 ? 0.5 : -0.5) * length, (k & 2 ? 0.5 : -0.5) * width, (k & 4 ? 1 : -1) * z);
  m.triangles = {{0, 3, 1}, {0, 2, 3}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 7, 3}, {2, 6, 7}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  m.radius = 0.5 * length;
  m.width = width;
  return {"plate", m};
}

}  // namespace grouser::test
