#pragma once
// One wheel of a model on flat ground, rolled steadily by hand.
#include "analytic/helpers.h"
#include "grouser/bekker/effects.h"
#include "grouser/bekker/steady.h"
#include "grouser/models.h"

namespace grouser::test {

struct Rolled {
  double drawbar, torque, normal, side;  ///< [N], [N m]
};

/// Mojave simulant with another soil's numbers where a test wants them.
struct Setting {
  BekkerSoil soil = mojave(0.16);
  double density = 1600;
  double radius = 0.13, width = 0.16;
  double slip = 0.3, rim_speed = 0.05, sinkage = 0.01, side_speed = 0;
  std::string options;
  std::vector<std::pair<std::string, double>> effects;
};

inline Bench bench_of(const Setting& s) {
  Soil soil;
  soil.name = "test soil";
  soil.bekker = s.soil;
  soil.bulk_density = s.density;
  Bench b(bekker::steady_model(), soil, flat_ground(), {"wheel", SmoothCylinder{s.radius, s.width}}, s.options);
  for (const auto& [id, amplitude] : s.effects) b.terrain->set_effect(id, amplitude);
  return b;
}

/// Speed of travel at a slip, v = r w (1 - s) driving, r w/(1 + s) braking.
inline double travel_speed(const Setting& s) {
  return s.slip >= 0 ? s.rim_speed * (1 - s.slip) : s.rim_speed / (1 + s.slip);
}

/// Forces after thirty contact lengths at a fixed height of the hub: all states have settled (exp(-30) = 1e-13).
inline Rolled roll(const Setting& s) {
  Bench b = bench_of(s);
  const double v = travel_speed(s), w = s.rim_speed / s.radius;
  b.motion.X_WB_end.p.z() = s.radius - s.sinkage;
  const double length = s.radius * std::acos(1 - s.sinkage / s.radius), way = 30 * length;
  const double dt = 0.2 * length / std::max(std::abs(v), std::abs(s.rim_speed));
  const int steps = static_cast<int>(way / (std::min(std::abs(v), std::abs(s.rim_speed)) * dt));
  for (int i = 0; i < steps; ++i) b.move({{v, s.side_speed, 0}, {0, w, 0}}, dt);
  const ContactReport& r = b.result.report;
  return {r.drawbar_pull, r.driving_torque, r.normal_force, r.side_force};
}

}  // namespace grouser::test
