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

double across(const BrickSettings& s) { return s.across > 0 ? s.across : s.side; }

Packing relaxed_packing(const SoilSettings& soil, const BrickSettings& s) {
  PourSettings p;
  p.lx = s.nx * s.side;
  p.ly = s.ny * across(s);
  p.height = s.height;
  p.compaction = s.compaction;
  p.slab = s.walls;
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
  if (p.slab && !s.walls)
    throw DemError(
        "the bed was poured between walls (slab: true): give 'slab' and 'sides: walls', or a bed periodic across");
  if (!p.slab && s.walls)
    throw DemError(
        "the bed is its own neighbour across: 'sides: walls' needs one poured between walls (dem bed, slab: true)");
  SphereBrick b;
  const bool given = !s.bed.empty();
  b.nx = given ? std::max(1, static_cast<int>(std::lround(p.lx / s.side))) : s.nx;
  b.ny = given ? std::max(1, static_cast<int>(std::lround(p.ly / across(s)))) : s.ny;
  b.lx = p.lx / b.nx;
  b.ly = p.ly / b.ny;
  b.height = p.height;
  b.hash = hash_text(p.inputs);
  b.parts.resize(static_cast<std::size_t>(b.nx) * static_cast<std::size_t>(b.ny));
  for (GrainState g : p.grains) {
    if (g.frozen) throw DemError("the bed has frozen grains; dem.sphere needs one without");
    std::size_t at[2];
    // No rounding of the solver may take a grain into the next brick.
    for (int k = 0; k < 2; ++k) {
      const double l = k == 0 ? b.lx : b.ly;
      const int n = k == 0 ? b.nx : b.ny;
      const double x = g.x[k] - n * l * std::floor(g.x[k] / (n * l));
      const int brick = std::clamp(static_cast<int>(x / l), 0, n - 1);
      at[k] = static_cast<std::size_t>(brick);
      g.x[k] = std::clamp(x - brick * l, 1e-8, l - 1e-8);
    }
    g.v = g.w = Vec3::Zero();
    b.parts[at[0] * static_cast<std::size_t>(b.ny) + at[1]].push_back(g);
    b.largest = std::max(b.largest, 2 * g.radius);
    b.top = std::max(b.top, g.x[2] + g.radius);
  }
  char text[240];
  if ((s.walls ? b.lx : std::min(b.lx, b.ly)) < 4 * b.largest) {
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
    double mean = 0;
    for (const std::vector<GrainState>& part : b.parts) {
      std::vector<GrainState> below;
      for (const GrainState& g : part)
        if (g.x[2] <= s.level + lift) below.push_back(g);
      mean += surface_height(below, b.lx, b.ly, b.largest) / static_cast<double>(b.parts.size());
    }
    (mean < s.level ? low : high) = lift;
  }
  b.lift = 0.5 * (low + high);
  return b;
}

}  // namespace

std::shared_ptr<const SphereBrick> sphere_brick(const SoilSettings& soil, const BrickSettings& s) {
  std::string key = inputs_text(soil) + s.bed.string() + '|' + s.cache.string();
  for (const double x : {s.side, s.across, s.height, s.level, static_cast<double>(s.nx), static_cast<double>(s.ny),
                         s.compaction, static_cast<double>(s.walls)})
    put_line(key, "", x);
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
