#include "extent_watch.h"

#include <cstdio>

#include "grouser/terrain/ground_extent.h"

namespace grouser::vehicle {

bool ExtentWatch::look(double t, const VehicleWorld& world, const Ground& ground) {
  const VehicleSpec& v = world.spec();
  wheels_.resize(v.wheels.size());
  ++frames_;
  bool fresh = false;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const WheelSpec& w = v.wheels[i];
    const Pose X = world.pose(w.link);
    const Vec3 axle_B = v.links[w.link].X_VB.q.conjugate() * v.joints[w.joint].axis_V;
    const Vec3 half = 0.5 * w.gear.width() * (X.q * axle_B);
    for (const Vec3& p : {Vec3(X.p - half), Vec3(X.p + half)}) {
      std::string where = beyond_data(ground, p.x(), p.y());
      if (where.empty()) continue;
      if (wheels_[i].frames == 0) {
        wheels_[i].since = t;
        wheels_[i].where = std::move(where);
        fresh = true;
      }
      ++wheels_[i].frames;
      break;
    }
  }
  return fresh;
}

void ExtentWatch::traverse(State& s) {
  auto g = s.group("extent");
  s.field("frames", frames_);
  auto n = static_cast<std::int64_t>(wheels_.size());
  s.field("wheels", n);
  wheels_.resize(static_cast<std::size_t>(n));
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    auto w = s.group(std::to_string(i));
    s.field("frames", wheels_[i].frames);
    s.field("since", wheels_[i].since);
    s.field("where", wheels_[i].where);
  }
}

std::vector<std::string> ExtentWatch::warnings(const VehicleSpec& vehicle) const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const Wheel& w = wheels_[i];
    if (w.frames == 0) continue;
    char text[96];
    std::snprintf(text, sizeof text,
                  " left the ground's data at t = %.2f s and was outside for %.0f %% of the frames: ", w.since,
                  100.0 * static_cast<double>(w.frames) / static_cast<double>(frames_));
    out.push_back("wheel " + vehicle.wheels[i].name + text + w.where);
  }
  return out;
}

}  // namespace grouser::vehicle
