// Pouring a packing, in pieces that can be saved.
#include <algorithm>
#include <chrono>

#include "grouser/terrain/checkpoint.h"
#include "packing.h"

namespace grouser::dem {

namespace {

constexpr double kSlow = 2e-3;  ///< [m/s]

/// A column gets as much as the densest packing by falling takes, and is cut at the height; a box its share by mass.
double solid_volume(const SoilSettings& soil, const PourSettings& p) {
  return p.walls ? soil.bulk_density / soil.density * p.lx * p.ly * p.height
                 : 0.62 * p.lx * p.ly * (p.height + soil.largest);
}

double highest_point(const std::vector<GrainState>& grains) {
  double top = 0;
  for (const GrainState& g : grains) top = std::max(top, g.x[2] + g.radius);
  return top;
}

}  // namespace

struct Pouring::Impl {
  /// The grains fall, are pressed, are let go.
  enum class Stage { falling, pressed, released };

  Impl(const SoilSettings& s, const PourSettings& q)
      : soil(s), p(q), settings(solver_settings(s)), grains(scatter(s, q, solid_volume(s, q))) {
    set_domain(settings, p, highest_point(grains));
    begin();
  }
  void begin() {
    solver = std::make_unique<Solver>(settings, grains);
    add_container(*solver, p);
    settling = Settling(kSlow, stage == Stage::falling ? 1.5 : 1.0);
    if (stage != Stage::pressed) return;
    BodySettings lid;
    lid.free = true;
    lid.mass = p.compaction * p.lx * p.ly / settings.gravity.norm();
    lid.locked = {true, true, false, true, true, true};
    lid.X_WB.p[2] = highest_point(grains) + 1e-5;
    solver->add_plane(solver->add_body(lid), Vec3::Zero(), -Vec3::UnitZ(), 1);
  }
  bool advance() {
    if (ready) return false;
    if (settling.step(*solver)) return true;
    settle_time += settling.spent();
    grains = solver->grains();
    ready = stage == Stage::released || !(p.compaction > 0);
    if (ready) return false;
    stage = stage == Stage::falling ? Stage::pressed : Stage::released;
    begin();
    return true;
  }
  void traverse(State& s) {
    s.field("stage", stage);
    s.field("settle_time", settle_time);
    // Grains at the beginning of the stage: the solver is made from them before its own state is read.
    std::vector<double> x;
    for (const GrainState& g : grains)
      for (const Vec3& v : {g.x, g.v, g.w}) x.insert(x.end(), v.data(), v.data() + 3);
    s.field("grains", x);
    if (s.loading()) {
      if (x.size() != 9 * grains.size()) throw DemError("state of another pouring");
      for (std::size_t k = 0; k < grains.size(); ++k)
        for (int a = 0; a < 3; ++a) {
          const std::size_t at = 9 * k + static_cast<std::size_t>(a);
          grains[k].x[a] = x[at];
          grains[k].v[a] = x[at + 3];
          grains[k].w[a] = x[at + 6];
        }
      if (stage != Stage::falling) begin();
    }
    settling.traverse(s);
    const auto g = s.group("solver");
    solver->traverse(s);
  }

  SoilSettings soil;
  PourSettings p;
  SolverSettings settings;
  std::vector<GrainState> grains;
  std::unique_ptr<Solver> solver;
  Settling settling{kSlow, 0};
  Stage stage = Stage::falling;
  double settle_time = 0;
  bool ready = false;
};

Pouring::Pouring(const SoilSettings& soil, const PourSettings& p) {
  if (!(p.height > 0)) throw DemError("height of a packing must be positive");
  if (p.walls && p.slab) throw DemError("a packing is poured into a box or between two walls, not both");
  impl_ = std::make_unique<Impl>(soil, p);
}
Pouring::~Pouring() = default;
bool Pouring::advance() { return impl_->advance(); }
double Pouring::done() const { return impl_->settling.spent() / (impl_->settling.spent() + impl_->settling.left()); }
double Pouring::time() const { return impl_->solver->time(); }
void Pouring::traverse(State& s) { impl_->traverse(s); }

Packing Pouring::packing() const {
  const PourSettings& p = impl_->p;
  const SoilSettings& soil = impl_->soil;
  Packing out;
  out.lx = p.lx;
  out.ly = p.ly;
  out.walls = p.walls;
  out.slab = p.slab;
  out.settle_time = impl_->settle_time;
  out.residual_speed = impl_->settling.speed();
  for (const GrainState& g : impl_->grains)
    if (p.walls || g.x[2] < p.height) out.grains.push_back(g);
  for (GrainState& g : out.grains) g.v = g.w = Vec3::Zero();
  out.height = surface_height(out.grains, p.lx, p.ly, soil.largest);
  out.bulk_density = total_mass(out.grains) / (p.lx * p.ly * out.height);
  if (soil.bulk_density > 0) {
    for (GrainState& g : out.grains) g.density *= soil.bulk_density / out.bulk_density;
    out.bulk_density = soil.bulk_density;
  }
  out.inputs = inputs_text(soil) + inputs_text(p);
  return out;
}

Packing pour(const SoilSettings& soil, const PourSettings& p, const Progress& progress) {
  Pouring pouring(soil, p);
  while (pouring.advance())
    if (progress) progress(pouring.done(), pouring.time());
  return pouring.packing();
}

Packing pour(const SoilSettings& soil, const PourSettings& p, const std::filesystem::path& checkpoint, double every,
             const Progress& progress) {
  using Clock = std::chrono::steady_clock;
  Pouring pouring(soil, p);
  const std::string inputs = inputs_text(soil) + inputs_text(p);
  if (std::filesystem::exists(checkpoint)) {
    Checkpoint saved = read_checkpoint(checkpoint);
    if (saved.scenario == inputs && saved.version == GROUSER_VERSION) {
      pouring.traverse(saved.state);
      saved.state.finish();
    }
  }
  for (auto last = Clock::now(); pouring.advance();) {
    if (progress) progress(pouring.done(), pouring.time());
    if (std::chrono::duration<double>(Clock::now() - last).count() <= every) continue;
    Checkpoint now;
    now.scenario = inputs;
    now.version = GROUSER_VERSION;
    now.time = pouring.time();
    pouring.traverse(now.state);
    write_checkpoint(checkpoint, now);
    last = Clock::now();
  }
  return pouring.packing();
}

}  // namespace grouser::dem
