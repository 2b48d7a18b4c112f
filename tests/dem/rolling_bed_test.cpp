// The bed that rolls with a wheel.
#include "grouser/dem/rolling_bed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace {

using namespace grouser;
using namespace grouser::dem;

constexpr double kBrick = 0.04, kRadius = 0.04, kSpeed = 0.4;
constexpr int kBricks = 7, kAhead = 3;

const SoilSettings& soil() {
  static const SoilSettings s = [] {
    SoilSettings t;
    t.smallest = 0.005;
    t.largest = 0.008;
    t.dt = 1.5e-5;
    t.law.rolling = RollingCoefficient::constant;
    t.materials.pair(0, 0).rolling = 0.3;
    return t;
  }();
  return s;
}

const Packing& brick() {
  // Bricks are laid without the springs of their contacts: it must be at rest without them, too.
  static const Packing p = [] {
    Packing q = pour_periodic(soil(), kBrick, 0.03, 0.025);
    for (int k = 0; k < 3; ++k) relax(q, soil(), 0.3);
    return q;
  }();
  return p;
}

/// A cylinder that rolls through the bed, 2 mm below its surface; it comes down while it moves.
struct Ride {
  explicit Ride(int threads = 1) : bed(brick(), settings()), solver(solver_settings(threads), bed.grains()) {
    solver.add_floor();
    BodySettings w;
    w.X_WB.p = Vec3(0.05, 0.015, brick().height + 0.01 + kRadius);
    w.V_W.v = Vec3(kSpeed, 0, -0.12);
    w.V_W.w = Vec3(0, kSpeed / kRadius, 0);
    wheel = solver.add_body(w);
    solver.add_cylinder(wheel, kRadius, 0.01);
  }
  static RollingBedSettings settings() {
    RollingBedSettings s;
    s.bricks = kBricks;
    s.ahead = kAhead;
    return s;
  }
  SolverSettings solver_settings(int threads) const {
    SolverSettings s;
    s.materials = soil().materials;
    s.law = soil().law;
    s.dt = soil().dt;
    s.threads = threads;
    return bed.fit(s);
  }
  /// 5 ms; true when soil was laid.
  bool advance() {
    solver.step_for(5e-3);
    if (solver.time() > 0.099 && !level) {
      Twist V = solver.twist(wheel);
      V.v[2] = 0;
      solver.set_motion(wheel, V);
      level = true;
    }
    before = solver.grains();
    stored_before.assign(before.size(), false);
    for (std::size_t k = 0; k < before.size(); ++k) stored_before[k] = bed.in_store(k);
    momentum_before = solver.momentum();
    removed_before = bed.removed_momentum();
    return bed.follow(solver, solver.pose(wheel).p[0]) > 0;
  }
  RollingBed bed;
  Solver solver;
  int wheel = 0;
  bool level = false;
  std::vector<GrainState> before;
  std::vector<bool> stored_before;
  Vec3 momentum_before, removed_before;
};

/// Soil grains of a slot, as far as x counts.
std::vector<std::size_t> slot_of(const Ride& r, const std::vector<GrainState>& g, long slot) {
  std::vector<std::size_t> out;
  const double from = static_cast<double>(slot % kBricks) * kBrick;
  for (std::size_t k = 0; k < g.size(); ++k)
    if (!r.bed.in_store(k) && g[k].x[0] >= from && g[k].x[0] < from + kBrick) out.push_back(k);
  return out;
}

TEST(RollingBed, LaysFreshSoilAheadAndKeepsTheNumberOfGrains) {
  Ride r;
  const std::size_t all = r.solver.grains().size(), one = brick().grains.size();
  EXPECT_EQ(all, kBricks * one + r.bed.stored());
  double seam = 0;
  for (const GrainState& b : brick().grains) seam = std::max(seam, 2 * b.radius);
  int laid = 0, since = 0;
  std::vector<double> fastest_ahead;  // of each brick laid
  std::vector<double> load[2];        // mean over a brick's length, on the first half of the way and on the second
  constexpr int kSamples = 20;        // of 5 ms: 40 mm
  int samples = 0;
  while (r.solver.time() < 1.5) {
    const bool now = r.advance();
    const std::vector<GrainState> g = r.solver.grains();
    ASSERT_EQ(g.size(), all);
    const double x = r.solver.pose(r.wheel).p[0];
    const long under = static_cast<long>(x / kBrick);
    EXPECT_GE(r.bed.fresh_until(), x + kAhead * kBrick);
    if (r.solver.time() > 0.2) {
      auto& half = load[r.solver.time() > 0.85 ? 1 : 0];
      if (half.empty() || samples == kSamples) half.push_back(0), samples = 0;
      half.back() += r.solver.body(r.wheel).force[2] / kSamples;
      ++samples;
    }
    if (now) {
      ++laid;
      const long slot = under + kAhead;
      // The slot holds the brick, at rest: every grain of it lies where one of the brick lies.
      const std::vector<std::size_t> fresh = slot_of(r, g, slot);
      EXPECT_EQ(fresh.size(), one);
      double solid = 0, solid_then = 0;
      for (std::size_t k : fresh) solid += std::pow(g[k].radius, 3) * g[k].density;
      for (const GrainState& b : brick().grains) solid_then += std::pow(b.radius, 3) * b.density;
      EXPECT_NEAR(solid, solid_then, 1e-12 * solid_then);
      for (std::size_t k : fresh) EXPECT_EQ(g[k].v.norm(), 0);
      // What the solver's momentum lost is what the bed says.
      const Vec3 lost = r.momentum_before - r.solver.momentum();
      EXPECT_NEAR((lost - (r.bed.removed_momentum() - r.removed_before)).norm(), 0, 1e-7);
      // All other grains are as they were, bit by bit: those outside the slot, off its two seams and not of the store.
      std::size_t others = 0;
      for (std::size_t k = 0; k < g.size(); ++k) {
        const GrainState &was = r.before[k], &is = g[k];
        const double whole = kBricks * kBrick, from = static_cast<double>(slot % kBricks) * kBrick;
        double beyond = was.x[0] - from;
        beyond -= whole * std::floor(beyond / whole);
        const bool slot_or_seam = beyond < kBrick + seam || beyond >= whole - seam;
        if (slot_or_seam || r.stored_before[k]) continue;
        ++others;
        EXPECT_FALSE(r.bed.in_store(k)) << k;
        EXPECT_TRUE(was.x == is.x && was.v == is.v && was.w == is.w && was.radius == is.radius &&
                    was.density == is.density && was.material == is.material && was.frozen == is.frozen)
            << k;
      }
      // Five and a half bricks of seven; heaps and ruts make up for a tenth.
      EXPECT_GT(others, 5 * one);
      since = 0;
      fastest_ahead.push_back(0);
    } else if (laid > 0 && ++since <= 8) {
      // 40 ms after: the wheel and the heap in front of it are more than two bricks away.
      double square = 0;
      const std::vector<std::size_t> fresh = slot_of(r, g, under + kAhead);
      for (std::size_t k : fresh) square += g[k].v.squaredNorm() / static_cast<double>(fresh.size());
      fastest_ahead.back() = std::max(fastest_ahead.back(), std::sqrt(square));
    }
  }
  // 0.6 m at 0.4 m/s: fifteen bricks entered, of which the first ones ahead were there at the start.
  EXPECT_GE(laid, 10);
  EXPECT_EQ(r.bed.laid(), laid);
  // Contacts find their springs again: the rms speed of most bricks stays below a twenty-fifth of the wheel's. Not of each: a grain
  // that the wheel throws ahead may fall on one, and which one changes with the last bit.
  std::sort(fastest_ahead.begin(), fastest_ahead.end());
  EXPECT_LT(fastest_ahead[fastest_ahead.size() / 2], kSpeed / 25);
  // Second half of the way on laid soil alone: the wheel is carried as on the soil of the start, within three standard errors of what
  // single lengths of a brick scatter by. The last length of each half may not be whole.
  double mean[2], error = 0;
  for (int h : {0, 1}) {
    load[h].pop_back();
    const auto n = static_cast<double>(load[h].size());
    ASSERT_GE(n, 5);
    mean[h] = std::accumulate(load[h].begin(), load[h].end(), 0.0) / n;
    for (double x : load[h]) error += (x - mean[h]) * (x - mean[h]) / (n * (n - 1));
  }
  EXPECT_GT(mean[0], 0);
  EXPECT_NEAR(mean[1], mean[0], 3 * std::sqrt(error));
}

TEST(RollingBed, ContinuesWithTheSameBitsAndForAnyNumberOfThreads) {
  Ride whole, other(2);
  State saved;
  while (whole.solver.time() < 0.7) {
    whole.advance();
    other.advance();
    if (saved.fields().empty() && whole.bed.laid() == 3) {
      whole.solver.traverse(saved);
      whole.bed.traverse(saved);
    }
  }
  EXPECT_GE(whole.bed.laid(), 4);
  EXPECT_EQ(whole.solver.hash(), other.solver.hash());
  Ride part;
  saved.rewind(State::Mode::load);
  part.solver.traverse(saved);
  part.bed.traverse(saved);
  saved.finish();
  part.level = true;
  while (part.solver.time() < 0.7) part.advance();
  EXPECT_EQ(part.bed.laid(), whole.bed.laid());
  EXPECT_EQ(part.solver.hash(), whole.solver.hash());
}

TEST(RollingBed, SaysWhatItCannotDo) {
  const auto message = [](auto&& f) {
    try {
      f();
    } catch (const DemError& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  RollingBedSettings s;
  s.bricks = 3;
  EXPECT_EQ(message([&] { RollingBed(brick(), s); }), "rolling bed: 3 bricks; at least 4");
  s.bricks = 4;
  EXPECT_EQ(message([&] { RollingBed(brick(), s); }), "rolling bed: 2 bricks ahead; 1 to 1 are allowed");
  Packing walled = brick();
  walled.walls = true;
  s.bricks = 6;
  EXPECT_EQ(message([&] { RollingBed(walled, s); }),
            "rolling bed: the brick was poured into a box; a periodic one is needed");
  Ride r;
  r.bed.follow(r.solver, 0.25);
  EXPECT_EQ(message([&] { r.bed.follow(r.solver, 0.01); }),
            "rolling bed: the wheel at x = 0.01 m is behind the soil that is left; it begins at 0.16 m");
  SolverSettings fixed = r.solver_settings(1);
  fixed.exchange = false;
  Solver plain(fixed, r.bed.grains());
  EXPECT_EQ(message([&] { plain.replace({0}, {brick().grains[0]}); }),
            "grains may be replaced with settings.exchange only");
}

}  // namespace
