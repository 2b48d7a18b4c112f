#include "sphere_brick.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "packing.h"

namespace grouser::dem {

namespace {

constexpr int kRelaxed =
    3;  ///< times: bricks are laid without the springs of their contacts and must be at rest without them

Packing relaxed_packing(const SoilSettings& soil, const BrickSettings& s) {
  PourSettings p;
  p.lx = p.ly = s.side;
  p.height = s.height;
  std::string inputs = inputs_text(soil) + inputs_text(p);
  put_line(inputs, "relaxed", kRelaxed);
  const std::filesystem::path file = s.cache / (hash_text(inputs) + ".h5");
  if (!s.cache.empty() && std::filesystem::exists(file)) {
    Packing stored = read_bed(file);
    if (stored.inputs == inputs) return stored;
  }
  Packing made = pour(soil, p);
  for (int k = 0; k < kRelaxed; ++k) relax(made, soil, 0.3);
  made.inputs = inputs;
  if (!s.cache.empty()) {
    std::filesystem::create_directories(s.cache);
    write_bed(made, file, "brick of dem.sphere");
  }
  return made;
}

SphereBrick from_packing(const Packing& p, const BrickSettings& s) {
  if (p.walls) throw DemError("the bed was poured into a box; dem.sphere needs a periodic one");
  SphereBrick b;
  b.grains = p.grains;
  b.lx = p.lx;
  b.ly = p.ly;
  b.height = p.height;
  b.hash = hash_text(p.inputs);
  for (GrainState& g : b.grains) {
    if (g.frozen) throw DemError("the bed has frozen grains; dem.sphere needs one without");
    // No rounding of the solver may take a grain into the next tile.
    for (int k = 0; k < 2; ++k) {
      const double l = k == 0 ? b.lx : b.ly;
      g.x[k] = std::clamp(g.x[k] - l * std::floor(g.x[k] / l), 1e-8, l - 1e-8);
    }
    g.v = g.w = Vec3::Zero();
    b.largest = std::max(b.largest, 2 * g.radius);
    b.top = std::max(b.top, g.x[2] + g.radius);
  }
  char text[240];
  if (std::min(b.lx, b.ly) < 4 * b.largest) {
    std::snprintf(text, sizeof text, "a brick of %.4g x %.4g m is narrower than four of its largest grains, %.4g m",
                  b.lx, b.ly, 4 * b.largest);
    throw DemError(text);
  }
  if (b.height < s.height - b.largest) {
    std::snprintf(text, sizeof text, "the bed is %.4g m high; depth and twice the relief want %.4g m", b.height,
                  s.height - b.largest);
    throw DemError(text);
  }
  // Where to cut so that the surface lies at the level.
  double low = -b.largest, high = b.largest;
  for (int k = 0; k < 40; ++k) {
    const double lift = 0.5 * (low + high);
    std::vector<GrainState> below;
    for (const GrainState& g : b.grains)
      if (g.x[2] <= s.level + lift) below.push_back(g);
    (surface_height(below, b.lx, b.ly, b.largest) < s.level ? low : high) = lift;
  }
  b.lift = 0.5 * (low + high);
  return b;
}

}  // namespace

std::shared_ptr<const SphereBrick> sphere_brick(const SoilSettings& soil, const BrickSettings& s) {
  std::string key = inputs_text(soil) + s.bed.string() + '|' + s.cache.string();
  for (const double x : {s.side, s.height, s.level}) put_line(key, "", x);
  // Terrains of one process that want the same brick wait for the first of them.
  static std::mutex lock;
  static std::map<std::string, std::shared_ptr<const SphereBrick>> known;
  const std::lock_guard guard(lock);
  std::shared_ptr<const SphereBrick>& brick = known[key];
  if (!brick)
    brick = std::make_shared<SphereBrick>(from_packing(s.bed.empty() ? relaxed_packing(soil, s) : read_bed(s.bed), s));
  return brick;
}

}  // namespace grouser::dem
