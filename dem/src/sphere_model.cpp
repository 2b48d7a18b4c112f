#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "grouser/dem/soil_config.h"
#include "grouser/dem/sphere.h"
#include "grouser/terrain/soil_points.h"
#include "grouser/terrain/wheel_motion.h"
#include "packing.h"
#include "sphere_averages.h"
#include "sphere_wheel.h"

namespace grouser::dem {

namespace {

constexpr const char* kDefaults =
    R"(# model dem.sphere: grains under wheels, soil file with a section dem. Every key is optional.
depth: 120 mm            # [m] > 0 soil below the surface; below it grains are frozen; with 60 mm a wheel of 0.11 m pulls a seventh less
relief: 20 mm            # [m] >= 0 how far the ground may lie above or below its datum; poured once, not simulated
datum: auto              # [m] height of the ground that soil is poured for; auto: middle of the ground under the wheels at the start
brick: auto              # [m] side of the square bricks in which soil comes and goes; auto: six of the largest grains
period: auto             # [m] length along x and width along y of the packing that is poured, then it repeats, whole bricks; auto: [12 bricks, 4 bricks]
compaction: 0 Pa         # [Pa] >= 0 pressed on the packing by a lid and let go again
seed: 1                  # [1] 0..1000000 of the pouring
bed: none                # file of a periodic bed (grouser dem bed) instead of pouring
beds: auto               # folder that keeps poured bricks; auto: grouser-beds in the system's folder for temporary files
reach: auto              # [m] soil nearer than this to a wheel's contact moves; auto: five of the largest grains
reach_along: auto        # [m] the same along the wheel's way only, the length of its patch; auto: reach
reach_across: auto       # [m] and along its axle only, the patch's width; auto: reach
slab: none               # [m] width of a slab that is its own neighbour across (quasi-2D), six of the largest grains at least; one smooth wheel
sides: periodic          # periodic | walls: the slab stands between two walls, those of the soil (smooth unless it says otherwise), about y = 0; more than two of the largest grains apart
torus: auto              # [1] 4..1000 bricks along x and y in the solver; auto: wheelbase and track with their surroundings
capacity: auto           # [1] 1..100000 bricks' worth of grains in the solver; auto: what the wheels' surroundings need, and some
wheel: auto              # auto (smooth: cylinder, lugs: mesh) | mesh | clump: overlapping spheres
wheel_grain: 10 mm       # [m] > 0 diameter of the spheres of a clump
lug_grain: 2 mm          # [m] > 0 and of those in its lugs and sidewalls
step_share: 0.17         # [1] 0..0.5 inner step as a share of the Rayleigh time of the smallest grain
averages: none           # HDF5 file to make: grains and wheel averaged over a short way, for a surrogate; one wheel
averaged_over: 0.25 mm   # [m] > 0 of the hub's way
averaged_every: 2.5 mm   # [m] > averaged_over
host_stiffness: 1        # [1] 0..10 scale of the contact stiffness told to the host, which damps its bounces; 0: none
)";

constexpr int kSlabGrains = 6;  ///< least width of a slab, in largest grains
constexpr int kWallGrains = 2;  ///< more than that between walls

struct SphereOptions {
  double depth = 0.12, relief = 0.02, step_share = kStepShare, host_stiffness = 1;
  std::optional<double> datum, brick, reach, reach_along, reach_across;
  double slab = 0;             ///< 0: none
  bool walls = false;          ///< of the slab
  std::vector<double> period;  ///< empty: auto
  double compaction = 0;
  WheelForm form;
  AveragesSettings averages;
  std::optional<long> torus, capacity;
  unsigned seed = 1;
  std::filesystem::path bed, beds;
};

bool is_word(const ConfigNode& o, const char* key, const char* word) {
  const ConfigNode n = o.node(key);
  return !n.present() || (n.is_scalar() && n.as_text() == word);
}

std::filesystem::path temporary_beds() {
  std::error_code none;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
  return none ? std::filesystem::path() : folder / "grouser-beds";
}

SphereOptions read(const ConfigNode& o) {
  SphereOptions s;
  s.beds = temporary_beds();
  if (!o.present()) return s;
  s.depth = o.quantity_or("depth", s.depth, "m", {0, 10, true, false});
  s.relief = o.quantity_or("relief", s.relief, "m", Range::between(0, 10));
  if (!is_word(o, "datum", "auto")) s.datum = o.quantity("datum", "m");
  if (!is_word(o, "brick", "auto")) s.brick = o.quantity("brick", "m", {0, 10, true, false});
  if (!is_word(o, "reach", "auto")) s.reach = o.quantity("reach", "m", {0, 10, true, false});
  if (!is_word(o, "reach_along", "auto")) s.reach_along = o.quantity("reach_along", "m", {0, 10, true, false});
  if (!is_word(o, "reach_across", "auto")) s.reach_across = o.quantity("reach_across", "m", {0, 10, true, false});
  if (!is_word(o, "period", "auto")) {
    s.period = o.quantities("period", "m", 2, {0, 100, true, false});
    if (s.period.size() != 2) s.period.clear();
  }
  s.compaction = o.quantity_or("compaction", 0, "Pa", Range::non_negative());
  s.seed = static_cast<unsigned>(o.integer_or("seed", 1, 0, 1000000));
  if (!is_word(o, "bed", "none")) s.bed = o.existing_file("bed");
  if (!is_word(o, "beds", "auto")) s.beds = o.text("beds");
  if (!is_word(o, "slab", "none")) {
    s.slab = o.quantity("slab", "m", {0, 10, true, false});
    if (s.period.size() == 2 && std::abs(s.period[1] - s.slab) > 1e-9)
      o.error_at("period", "its second number is the width of the slab where there is one: write that of 'slab'");
    if (!is_word(o, "reach_across", "auto"))
      o.error_at("reach_across", "a slab moves as a whole across: leave it out, or leave out 'slab'");
  }
  s.walls = o.choice_or("sides", "periodic", {"periodic", "walls"}) == "walls";
  if (s.walls && is_word(o, "slab", "none"))
    o.error_at("sides", "walls stand at the sides of a slab: give its width too, slab: 30 mm, or leave out 'sides'");
  if (!is_word(o, "torus", "auto")) s.torus = o.integer("torus", 4, 1000);
  if (!is_word(o, "capacity", "auto")) s.capacity = o.integer("capacity", 1, 100000);
  const std::string wheel = o.choice_or("wheel", "auto", {"auto", "mesh", "clump"});
  s.form.mesh = wheel == "mesh";
  s.form.clump = wheel == "clump";
  s.form.diameter = o.quantity_or("wheel_grain", s.form.diameter, "m", {0, 1, true, false});
  s.form.lug_diameter = o.quantity_or("lug_grain", s.form.lug_diameter, "m", {0, 1, true, false});
  if (!is_word(o, "averages", "none")) s.averages.file = o.text("averages");
  s.averages.over = o.quantity_or("averaged_over", s.averages.over, "m", {0, 1, true, false});
  s.averages.every = o.quantity_or("averaged_every", s.averages.every, "m", {0, 100, true, false});
  if (s.averages.every <= s.averages.over) o.error_at("averaged_every", "must be longer than 'averaged_over'");
  s.step_share = o.quantity_or("step_share", s.step_share, "1", {0, 0.5, true, false});
  s.host_stiffness = o.quantity_or("host_stiffness", s.host_stiffness, "1", Range::between(0, 10));
  o.finish();
  return s;
}

class Sphere final : public Terrain, public SoilPoints, public SlabWalls {
 public:
  Sphere(const SoilSettings& soil, const SphereOptions& options, GroundPtr ground, double gravity)
      : Terrain(std::move(ground)), soil_(soil), options_(options), gravity_(gravity) {
    soil_.seed = options.seed;
    soil_.dt_share = options.step_share;
    set_step(soil_);
  }
  std::string id() const override { return "dem.sphere"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.memory = true;
    c.linearises = false;  // an estimate for the host's stability only
    c.continuous = false;
    c.lugs = true;
    return c;
  }

 private:
  void do_add_body(const BodySpec& b) override {
    if (!options_.averages.file.empty() && !wheels_.empty())
      throw TerrainError("dem.sphere: 'averages' are of one wheel; this is the second");
    if (slab() && !wheels_.empty())
      throw TerrainError("dem.sphere: a slab carries one wheel, as wide as itself; '" + b.name + "' is the second");
    wheels_.emplace_back(b, options_.form, options_.slab);
  }

  /// What a solver is built from; part of the state.
  struct Plan {
    double datum = 0;  ///< [m] of the ground
    std::int64_t nx = 0, ny = 0, grains = 0;
  };

  PatchReach reach() const {
    const double both = options_.reach.value_or(5 * soil_.largest);
    return {options_.reach_along.value_or(both), options_.reach_across.value_or(both)};
  }
  PatchReach keep() const {
    const PatchReach r = reach();
    return {r.along + 0.5 * brick_->lx, r.across + 0.5 * brick_->lx};
  }
  bool slab() const { return options_.slab > 0; }
  /// y of the solver less y of the world [m]: between walls the slab lies about y = 0.
  double aside() const { return options_.walls ? 0.5 * options_.slab : 0; }
  /// Share of the slab's forces that the wheel's own width bears; 1 without a slab.
  double share() const { return slab() ? 2 * wheels_[0].half_width() / options_.slab : 1; }
  Pose gear_pose(std::size_t k, const Pose& X_WB) const { return X_WB * bodies()[k].X_BG; }
  Pose in_solver(Pose X) const {
    X.p.y() += aside();
    X.p.z() -= tiles_->base();
    return X;
  }

  void make_brick() {
    if (brick_) return;
    BrickSettings b;
    b.side = options_.brick.value_or(6 * soil_.largest);
    const auto bricks = [&](std::size_t k, int usual) {
      return options_.period.empty() ? usual
                                     : std::max(1, static_cast<int>(std::ceil(options_.period[k] / b.side - 1e-6)));
    };
    b.nx = bricks(0, kPeriodX);
    b.ny = slab() ? 1 : bricks(1, kPeriodY);
    b.across = options_.slab;
    b.walls = options_.walls;
    b.compaction = options_.compaction;
    // One diameter below the lowest soil that moves: a floor of frozen grains, not the smooth one of the pouring.
    b.level = options_.depth + options_.relief + soil_.largest;
    b.height = options_.depth + 2 * options_.relief + 2 * soil_.largest;
    b.bed = options_.bed;
    b.cache = options_.beds;
    const auto made = sphere_brick(soil_, b);
    if (slab() && (made->ny != 1 || std::abs(made->ly - options_.slab) > 1e-9)) {
      char text[160];
      std::snprintf(text, sizeof text, "the bed is %.4g m wide, the slab %.4g m: they must be the same",
                    made->ny * made->ly, options_.slab);
      throw DemError(text);
    }
    brick_ = made;
  }

  /// Tiles that wheel k at X wants. A slab has one row of them: the wheel stands in its middle.
  void tiles_near(std::size_t k, Pose X, const PatchReach& reach, const PatchReach& keep, double clear,
                  const std::vector<Tile>& now, std::vector<Tile>& into) const {
    if (!slab()) return wheels_[k].tiles_near(X, ground(), brick_->lx, brick_->ly, reach, keep, clear, now, into);
    X.p.y() = 0.5 * brick_->ly;
    std::vector<Tile> all;
    wheels_[k].tiles_near(X, ground(), brick_->lx, brick_->ly, reach, keep, clear, now, all);
    std::copy_if(all.begin(), all.end(), std::back_inserter(into), [](const Tile& t) { return t.j == 0; });
  }

  /// A slab's wheel goes straight along x with its axle along y. @throws TerrainError.
  void check_straight(const BodyMotion& m) const {
    char text[240];
    const Pose from = gear_pose(0, m.X_WB_begin), to = gear_pose(0, m.X_WB_end);
    const Vec3 axle = to.q * Vec3::UnitY(), way = to.p - from.p;
    if (options_.walls && std::abs(from.p.y()) > aside()) {
      std::snprintf(text, sizeof text,
                    "dem.sphere: the slab between walls lies about y = 0, %.4g mm wide; the hub is at y = %.4g mm, "
                    "beyond a wall",
                    1e3 * options_.slab, 1e3 * from.p.y());
      throw TerrainError(text);
    }
    const double off = std::hypot(axle.x(), axle.z());
    if (off > kTurned) {
      std::snprintf(text, sizeof text,
                    "dem.sphere: a slab carries a wheel with its axle along y; this one is turned by %.3g degrees (at "
                    "most %.2g)",
                    std::asin(std::min(1.0, off)) * 180 / pi, std::asin(kTurned) * 180 / pi);
      throw TerrainError(text);
    }
    if (std::abs(way.y()) > kTurned * way.norm() + kAside) {
      std::snprintf(text, sizeof text,
                    "dem.sphere: a slab carries a wheel that goes along x; this one went %.3g mm along its axle on %.3g "
                    "mm (no side slip: leave out 'slab')",
                    1e3 * way.y(), 1e3 * way.norm());
      throw TerrainError(text);
    }
  }

  Plan make_plan(std::span<const BodyMotion> motions) const {
    Plan p;
    double wide = 0, low = 1e300, high = -1e300, need = 0;
    std::vector<Tile> first;
    for (std::size_t k = 0; k < wheels_.size(); ++k) {
      const Pose X = gear_pose(k, motions[k].X_WB_begin);
      for (std::size_t o = 0; o < k; ++o)
        wide = std::max(wide, (X.p - gear_pose(o, motions[o].X_WB_begin).p).head<2>().norm());
      tiles_near(k, X, keep(), keep(), 1e300, {}, first);
      // Tiles that an oblique rectangle of the largest contact may touch.
      const double l = brick_->lx, a = 1.4 * wheels_[k].radius() + 2 * keep().along,
                   b = 2 * wheels_[k].half_width() + 2 * keep().across;
      need += slab() ? a / l + 2 : (a * b + 1.42 * (a + b) * l + l * l) / (l * l);
    }
    for (const Tile& t : first)
      for (int a = 0; a <= 2; ++a)
        for (int b = 0; b <= 2; ++b) {
          const double z = ground().height((static_cast<double>(t.i) + 0.5 * a) * brick_->lx,
                                           (static_cast<double>(t.j) + 0.5 * b) * brick_->ly);
          low = std::min(low, z);
          high = std::max(high, z);
        }
    p.datum = options_.datum.value_or(0.5 * (low + high));
    double around = 0;
    for (const SphereWheel& w : wheels_)
      around = std::max(around, 1.4 * w.radius() + 2 * w.half_width() + 2 * keep().most());
    const auto tiles = [&](double l) {
      return options_.torus.value_or(std::max(4L, static_cast<long>(std::ceil((wide + around) / l)) + 1));
    };
    p.nx = tiles(brick_->lx);
    p.ny = slab() ? 1 : tiles(brick_->ly);
    std::size_t most = 0;
    const double level = options_.depth + options_.relief + brick_->largest;
    for (const std::vector<GrainState>& part : brick_->parts) {
      std::size_t here = 0;
      for (const GrainState& g : part)
        here += g.x[2] <= level + brick_->lift && g.x[2] >= level - options_.depth - brick_->largest;
      most = std::max(most, here);
    }
    const double bricks =
        options_.capacity ? static_cast<double>(*options_.capacity) : std::min(need, static_cast<double>(p.nx * p.ny));
    p.grains = static_cast<std::int64_t>(std::ceil(1.1 * bricks * static_cast<double>(most)));
    return p;
  }

  void build(const Plan& p, std::span<const BodyMotion> motions) {
    plan_ = p;
    TilesSettings t;
    t.datum = p.datum;
    t.depth = options_.depth;
    t.relief = options_.relief;
    t.nx = static_cast<int>(p.nx);
    t.ny = static_cast<int>(p.ny);
    t.grains = static_cast<std::size_t>(p.grains);
    t.slab = slab();
    t.walls = options_.walls;
    tiles_.emplace(brick_, ground_ptr(), t);
    SolverSettings s = tiles_->fit(solver_settings(soil_));
    const int material = soil_.wheel ? s.materials.add(s.materials.materials[0], *soil_.wheel) : 0;
    s.gravity = Vec3(0, 0, -gravity_);
    s.threads = threads();
    solver_.emplace(s, tiles_->parked());
    for (std::size_t k = 0; k < wheels_.size(); ++k)
      wheels_[k].add_to(*solver_, motions.empty() ? Pose() : in_solver(gear_pose(k, motions[k].X_WB_begin)), material);
    solver_->add_floor(0, 1);
    if (options_.walls) wall_ = tiles_->add_walls(*solver_, 1);
  }

  void begin(std::span<const BodyMotion> motions) {
    make_brick();
    build(make_plan(motions), motions);
  }

  /// Steers every wheel from where it is to the end of its motion.
  void steer(std::span<const BodyMotion> motions, double dt) {
    for (std::size_t k = 0; k < wheels_.size(); ++k) {
      const int body = static_cast<int>(k);
      const Pose from = in_solver(gear_pose(k, motions[k].X_WB_begin)),
                 to = in_solver(gear_pose(k, motions[k].X_WB_end));
      const double jump = 1e-3 * wheels_[k].radius();
      if (const Pose at = solver_->pose(body); (at.p - from.p).norm() > jump || at.q.angularDistance(from.q) > 1e-3) {
        solver_->place(body, from);
        tiles_->clear(*solver_,
                      [&](const GrainState& g) { return wheels_[k].overlap(from, g.x, g.radius) > kDeep * g.radius; });
      }
      const Pose at = solver_->pose(body);
      Twist V;
      V.v = (to.p - at.p) / dt;
      const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.q * at.q.conjugate()));
      Vec3 angle = turn.angle() * turn.axis();
      if (turn.angle() > pi) angle *= (turn.angle() - 2 * pi) / turn.angle();
      // Whole turns within the step, as the end's spin says.
      if (const double size = angle.norm(); size > 1e-12) {
        const Vec3 axis = angle / size;
        const double turns = std::round((axis.dot(motions[k].V_WB_end.w) * dt - size) / (2 * pi));
        angle += 2 * pi * turns * axis;
      }
      V.w = angle / dt;
      solver_->set_motion(body, V);
    }
  }

  void lay_soil(std::span<const BodyMotion> motions) {
    std::vector<Tile> wanted;
    std::vector<Pose> begin;
    for (std::size_t k = 0; k < wheels_.size(); ++k) {
      begin.push_back(in_solver(gear_pose(k, motions[k].X_WB_begin)));
      for (const Pose& X : {motions[k].X_WB_begin, motions[k].X_WB_end})
        tiles_near(k, gear_pose(k, X), reach(), keep(), 2 * brick_->largest, tiles_->active(), wanted);
    }
    tiles_->activate(*solver_, std::move(wanted), [&](const GrainState& g) {
      for (std::size_t k = 0; k < wheels_.size(); ++k)
        if (wheels_[k].overlap(begin[k], g.x, g.radius) > kDeep * g.radius) return true;
      return false;
    });
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    if (slab() && !motions.empty()) check_straight(motions[0]);
    try {
      if (!solver_) begin(motions);
      const auto n = static_cast<long>(std::max(1.0, std::ceil(c.dt / soil_.dt - 1e-6)));
      solver_->set_dt(c.dt / static_cast<double>(n));
      lay_soil(motions);
      steer(motions, c.dt);
      std::vector<SurfaceReport> before;
      for (std::size_t k = 0; k < wheels_.size(); ++k) before.push_back(solver_->body(static_cast<int>(k)));
      if (!tiles_->active().empty()) {
        advance(n, c.commit, motions);
      } else {
        for (std::size_t k = 0; k < wheels_.size(); ++k)
          solver_->place(static_cast<int>(k), in_solver(gear_pose(k, motions[k].X_WB_end)));
      }
      now_ = solver_->grains();
      tiles_->catch_strays(*solver_, now_);
      tiles_->forget_cache();
      for (std::size_t k = 0; k < wheels_.size(); ++k) answer(k, c.dt, motions[k], before[k], results[k]);
    } catch (const DemError& e) {
      char text[60];
      std::snprintf(text, sizeof text, "dem.sphere at t = %.6f s: ", c.t);
      throw TerrainError(text + std::string(e.what()));
    }
  }

  /// n inner steps; in pieces where averages are wanted. A preview averages nothing.
  void advance(long n, bool commit, std::span<const BodyMotion> motions) {
    if (options_.averages.file.empty() || !commit) return solver_->step(n);
    if (!averages_)
      averages_ =
          std::make_unique<Averages>(options_.averages, inputs(), wheels_[0].radius(), 2 * wheels_[0].half_width(),
                                     options_.slab);
    const double way = solver_->twist(0).v.norm() * solver_->time_step();
    // The torus wraps; the world's hub is where the host has it.
    Pose hub = gear_pose(0, motions[0].X_WB_begin);
    for (long left = n; left > 0;) {
      const long m = averages_->next(way, left);
      solver_->step(m);
      left -= m;
      hub.p += solver_->twist(0).v * (static_cast<double>(m) * solver_->time_step());
      averages_->after(m, way, *solver_, hub, tiles_->lx(), tiles_->ly(), solver_->time_step(),
                       [&](std::size_t g) { return tiles_->is_parked(g); });
    }
  }
  std::string inputs() const {
    std::string t = inputs_text(soil_);
    put_line(t, "brick", brick_->hash);
    put_line(t, "depth_m", options_.depth);
    put_line(t, "reach_m", reach().along);
    if (reach().across != reach().along) put_line(t, "reach_across_m", reach().across);
    put_line(t, "step_share", options_.step_share);
    if (slab()) put_line(t, "slab_m", options_.slab);
    if (options_.walls) put_line(t, "sides", "walls");
    put_line(t, "ground", ground().describe());
    put_line(t, "wheel", bodies()[0].gear.name);
    put_line(t, "wheel_radius_m", wheels_[0].radius());
    put_line(t, "wheel_width_m", 2 * wheels_[0].half_width());
    return t;
  }

  void answer(std::size_t k, double dt, const BodyMotion& motion, const SurfaceReport& before, BodyResult& result) {
    const SphereWheel& wheel = wheels_[k];
    const RunningGear& gear = bodies()[k].gear;
    const SurfaceReport after = solver_->body(static_cast<int>(k));
    Vec3 J = share() * (after.impulse - before.impulse), L = share() * (after.angular_impulse - before.angular_impulse);
    const WheelMotion m = wheel_motion(bodies()[k], motion, wheel.radius(), 2 * wheel.half_width());
    // Where along the axle a grain of a slab pushes is known up to whole widths only: no moment but about the axle.
    if (slab()) L = m.carrier.col(1) * m.carrier.col(1).dot(L);
    // Work of the wheel on the grains, step by step; and what the end's velocity makes of the impulse in place of the mean one.
    const Twist V = solver_->twist(static_cast<int>(k));
    ledger().dissipated += share() * (after.work - before.work);
    ledger().integration += J.dot(V.v - m.V.v) + L.dot(V.w - m.V.w);
    if (J.isZero(0) && L.isZero(0)) return clear_result(result);
    const ContactPatch patch = finder_.find(m.pose, ground());
    const Wrench about_hub{J / dt, L / dt};
    Mat6 K = Mat6::Zero();
    const double normal = about_hub.f.dot(patch.contact ? patch.normal_W : Vec3(Vec3::UnitZ()));
    const Vec3 n = patch.contact ? patch.normal_W : Vec3(Vec3::UnitZ());
    const double length = std::max(patch.contact ? patch.chord : 0.0, soil_.largest);
    const double stiffness = options_.host_stiffness *
                             patch_stiffness(soil_.materials.materials[0], normal, length * 2 * wheel.half_width());
    K.topLeftCorner<3, 3>() = -stiffness * n * n.transpose();
    fill_result(m, patch, about_hub, K, Mat6::Zero(), dt, result);
    result.impulse = J;
    result.angular_impulse = L + m.lever_W.cross(J);
    if (!(stiffness > 0)) result.linearisation.reset();
    ContactReport& r = result.report;
    const Slip slip = slip_of(gear.radius() * m.spin, m.V.v.dot(m.carrier.col(0)), m.V.v.dot(m.carrier.col(1)));
    r.slip = slip.slip;
    r.slip_angle = slip.angle;
    const Pose X = in_solver(gear_pose(k, motion.X_WB_end));
    const SphereWheel::Arc arc =
        wheel.arc(X, now_, tiles_->lx(), tiles_->ly(), [&](std::size_t g) { return tiles_->is_parked(g); });
    r.entry_angle = arc.entry;
    r.exit_angle = arc.exit;
    if (!patch.contact) {
      r.sinkage = 0;
      r.point_W = m.pose.hub_W + (arc.touching ? arc.centre_W : Vec3(-wheel.radius() * m.carrier.col(2)));
    }
  }

  /// The grains as they are; after a load they have to be asked for again.
  const std::vector<GrainState>& grains_now() const {
    if (now_.empty()) now_ = solver_->grains();
    return now_;
  }

  SurfaceSample do_surface(double x, double y) const override {
    SurfaceSample s = Terrain::do_surface(x, y);
    if (!solver_ || (options_.walls && std::abs(y) > aside())) return s;
    const double rise = tiles_->rise(x, y + aside(), grains_now());
    s.height += rise;
    s.sinkage = -rise;
    return s;
  }

  /// y of the world of a grain or square at this y of its tile. A slab without walls lies about the hub.
  double beside_hub(double y) const {
    if (!slab() || options_.walls) return y - aside();
    const double hub = solver_->pose(0).p.y();
    return hub + std::remainder(y - hub, options_.slab);
  }

  std::vector<std::array<double, 4>> soil_points(std::size_t most) const override {
    std::vector<std::array<double, 4>> out;
    if (!solver_) return out;
    std::vector<std::pair<double, std::size_t>> near;
    const std::vector<GrainState>& now = grains_now();
    for (std::size_t k = 0; k < now.size(); ++k) {
      const std::optional<Vec3> x = tiles_->in_world(k, now[k]);
      // Two layers: what lies deeper is not seen.
      if (!x || x->z() + tiles_->base() < ground().height(x->x(), x->y()) - 2 * brick_->largest) continue;
      double far = 1e300;
      for (std::size_t w = 0; w < wheels_.size(); ++w) {
        Vec3 d = solver_->pose(static_cast<int>(w)).p - now[k].x;
        d[0] -= tiles_->lx() * std::round(d[0] / tiles_->lx());
        d[1] -= tiles_->ly() * std::round(d[1] / tiles_->ly());
        far = std::min(far, d.squaredNorm());
      }
      near.push_back({far, out.size()});
      out.push_back({x->x(), beside_hub(x->y()), x->z() + tiles_->base(), now[k].radius});
    }
    if (out.size() <= most) return out;
    std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(most), near.end());
    near.resize(most);
    // In the order of the solver: neighbours follow each other.
    std::vector<std::size_t> kept;
    for (const auto& n : near) kept.push_back(n.second);
    std::sort(kept.begin(), kept.end());
    std::vector<std::array<double, 4>> few;
    for (const std::size_t k : kept) few.push_back(out[k]);
    return few;
  }

  std::array<Vec3, 2> wall_impulses() const override {
    if (!options_.walls || !solver_) return {Vec3::Zero(), Vec3::Zero()};
    return {share() * solver_->surface(wall_).impulse, share() * solver_->surface(wall_ + 1).impulse};
  }

  std::vector<Cell> do_take_changed_cells() override {
    std::vector<Cell> out;
    if (!solver_) return out;
    double size = 0;
    for (const Tiles::Square& q : tiles_->changed(grains_now(), size))
      out.push_back({q.x, beside_hub(q.y), size, ground().height(q.x, q.y) + q.rise, -q.rise});
    return out;
  }

  void do_traverse(State& s) override {
    const auto group = s.group("sphere");
    bool begun = solver_.has_value();
    s.field("begun", begun);
    if (s.loading()) now_.clear();
    if (!begun) {
      solver_.reset();
      tiles_.reset();
      return;
    }
    make_brick();
    Plan p = plan_;
    std::string brick = brick_->hash;
    s.field("brick", brick);
    s.field("datum", p.datum);
    s.field("nx", p.nx);
    s.field("ny", p.ny);
    s.field("grains", p.grains);
    if (brick != brick_->hash)
      throw StateError("state belongs to soil of another brick (" + brick + ", not " + brick_->hash + ")");
    const bool same =
        solver_ && p.datum == plan_.datum && p.nx == plan_.nx && p.ny == plan_.ny && p.grains == plan_.grains;
    if (s.loading() && !same) build(p, {});
    tiles_->traverse(s);
    solver_->traverse(s);
  }

  static constexpr int kPeriodX = 12, kPeriodY = 4;  ///< bricks
  static constexpr double kTurned = 0.009;  ///< sine of the angle that an axle in a slab may be off y: half a degree
  static constexpr double kAside = 1e-8;    ///< [m] that it may go aside in a step of the host
  static constexpr double kDeep = 0.02;  ///< of its radius that a grain may lie in a wheel that is put into the soil

  SoilSettings soil_;
  SphereOptions options_;
  double gravity_;
  std::shared_ptr<const SphereBrick> brick_;
  std::vector<SphereWheel> wheels_;
  Plan plan_;
  std::optional<Tiles> tiles_;
  std::optional<Solver> solver_;
  int wall_ = 0;  ///< surface of the wall to the right (y < 0), the other is the next
  PatchFinder finder_;
  std::unique_ptr<Averages> averages_;  ///< no part of the state: a run that goes on from a state begins another file
  mutable std::vector<GrainState> now_;
};

}  // namespace

ModelInfo sphere_model() {
  return {
      "dem.sphere",
      "grains: spheres in contact, tiled over the ground, moving near the wheels only",
      "smooth and lugged wheels and meshes on any ground within its relief; ruts, bulldozing, several passes, digging; "
      "no fitted "
      "wheel law",
      "no static equilibrium to start from, no energy ledger, soil no deeper than its bed; the slowest model by far; "
      "two packings "
      "differ",
      kDefaults,
      [](const TerrainArgs& a) -> std::unique_ptr<Terrain> {
        const SphereOptions options = read(a.options);
        if (!a.soil.dem.present())
          throw std::invalid_argument("soil '" + a.soil.name + "' has no 'dem:' section, which model dem.sphere needs");
        const SoilSettings soil = read_soil(a.soil.dem);
        char text[120];
        if (options.slab > 0 && !options.walls && options.slab < kSlabGrains * soil.largest) {
          std::snprintf(text, sizeof text, "must be %.4g mm or more: %d of the soil's largest grains",
                        1e3 * kSlabGrains * soil.largest, kSlabGrains);
          a.options.error_at("slab", text);
        }
        if (options.slab > 0 && options.walls && options.slab <= kWallGrains * soil.largest) {
          std::snprintf(text, sizeof text, "must be more than %.4g mm: %d of the soil's largest grains between walls",
                        1e3 * kWallGrains * soil.largest, kWallGrains);
          a.options.error_at("slab", text);
        }
        return std::make_unique<Sphere>(soil, options, a.ground, a.gravity);
      }};
}

}  // namespace grouser::dem
