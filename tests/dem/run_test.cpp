// Runs of a few hundred grains: threads, resume, instruction sets, precision, lists, refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

/// Loose grains above a floor, different sizes, no two overlapping; they fall and pile up.
std::vector<GrainState> loose(int nx, int ny, int nz, unsigned seed, double jitter = 5e-4) {
  std::mt19937 g(seed);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<GrainState> out;
  for (int k = 0; k < nz; ++k)
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j) {
        GrainState s;
        s.radius = 0.002 + 0.002 * u(g);
        s.x = Vec3(0.01 * i + 0.005, 0.01 * j + 0.005, 0.01 * k + 0.006) +
              jitter * Vec3(2 * u(g) - 1, 2 * u(g) - 1, 2 * u(g) - 1);
        out.push_back(s);
      }
  return out;
}
SolverSettings box(int nx, int ny) {
  SolverSettings s;
  s.domain.hi = Vec3(0.01 * nx, 0.01 * ny, 0.5);
  return s;
}
Solver pile(const SolverSettings& s, int nx = 12, int ny = 4, int nz = 12) {
  Solver solver(s, loose(nx, ny, nz, 7));
  solver.add_floor();
  return solver;
}
double distance(const Solver& a, const Solver& b) {
  const auto x = a.grains(), y = b.grains();
  double d = 0;
  for (std::size_t k = 0; k < x.size(); ++k) d = std::max(d, (x[k].x - y[k].x).norm());
  return d;
}

TEST(Threads, DoNotChangeABit) {
  for (const Precision p : {Precision::single, Precision::full}) {
    SolverSettings s = box(60, 4);
    s.precision = p;
    std::uint64_t hash[3];
    for (int k = 0; k < 3; ++k) {
      s.threads = k == 2 ? 4 : k + 1;
      Solver solver(s, loose(60, 4, 20, 7));
      solver.add_floor();
      solver.step(3000);
      hash[k] = solver.hash();
    }
    EXPECT_EQ(hash[0], hash[1]);
    EXPECT_EQ(hash[0], hash[2]);
  }
}

TEST(SavedState, ContinuesBitByBit) {
  const SolverSettings s = box(12, 4);
  Solver a = pile(s);
  a.step(4000);
  State saved;
  a.traverse(saved);
  a.step(4321);
  Solver b = pile(s);
  saved.rewind(State::Mode::load);
  b.traverse(saved);
  saved.finish();
  b.step(4321);
  EXPECT_EQ(a.hash(), b.hash());
}

TEST(SavedState, IsNotChangedBySaving) {
  const SolverSettings s = box(12, 4);
  Solver a = pile(s), b = pile(s);
  for (int k = 0; k < 5; ++k) {
    a.step(1000);
    State saved;
    a.traverse(saved);
  }
  b.step(5000);
  EXPECT_EQ(a.hash(), b.hash());
}

/// A pile at rest under its own weight, given a push: every grain touches and slides on its neighbours.
std::vector<GrainState> pushed_pile() {
  static const std::vector<GrainState> grains = [] {
    SolverSettings s = box(12, 4);
    s.dt = 2e-5;
    Solver solver = pile(s);
    solver.step(30000);
    auto g = solver.grains();
    for (GrainState& x : g) {
      x.v += Vec3(0.1 * x.x[2] / 0.05, 0, 0);
      x.w += Vec3(0, 5, 5);
    }
    return g;
  }();
  return grains;
}
Solver sheared(const SolverSettings& s, long steps) {
  Solver solver(s, pushed_pile());
  solver.add_floor();
  solver.step(steps);
  return solver;
}
double faster(const Solver& a, const Solver& b) {
  const auto x = a.grains(), y = b.grains();
  double d = 0;
  for (std::size_t k = 0; k < x.size(); ++k) d = std::max(d, (x[k].v - y[k].v).norm());
  return d;
}

// 300 steps of 8 us: the pile shears by a quarter of a millimetre at 0.1 m/s with 1.5 to 2 contacts a grain, sliding and rolling; then
// chaos sets in. Bounds: 0.1 % of that way and of the speed. The pile itself differs from compiler flags to compiler flags: 2.4e-8 m in
// the release build, 1.4e-7 m under the sanitizers.
TEST(InstructionSets, AgreeOnAShearedPile) {
  SolverSettings s = box(12, 4);
  std::vector<std::pair<std::string, Solver>> runs;
  for (const char* name : {"base", "avx2", "avx512"}) {
    s.isa = name;
    try {
      runs.emplace_back(name, sheared(s, 300));
      EXPECT_GT(runs.back().second.counters().touching, 1);
    } catch (const DemError&) {
      GTEST_LOG_(INFO) << name << " cannot be run here";
    }
  }
  for (std::size_t a = 0; a < runs.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_LT(distance(runs[a].second, runs[b].second), 2.5e-7) << runs[a].first << ", " << runs[b].first;
      EXPECT_LT(faster(runs[a].second, runs[b].second), 1e-4) << runs[a].first << ", " << runs[b].first;
    }
}

TEST(Precision, SingleFollowsDoubleOnAShearedPile) {
  SolverSettings s = box(12, 4);
  const Solver single = sheared(s, 300);
  s.precision = Precision::full;
  const Solver full = sheared(s, 300);
  EXPECT_LT(distance(single, full), 1e-7);
  EXPECT_LT(faster(single, full), 1e-4);
}

TEST(Lists, OfAnotherReachGiveTheSameMotion) {
  // The order of sums differs, nothing else.
  SolverSettings s = box(12, 4);
  s.precision = Precision::full;
  const Solver a = sheared(s, 300);
  s.skin = 2e-3;
  const Solver b = sheared(s, 300);
  EXPECT_LT(distance(a, b), 1e-12);
}

/// Pairs of spinning grains that fly at each other over a gap of 0.6 mm, in sites that know nothing of each other.
std::vector<GrainState> pairs_in_flight(int nx, int ny, int nz) {
  std::vector<GrainState> out;
  for (int k = 0; k < nz; ++k)
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        for (int side : {-1, 1}) {
          GrainState g;
          g.radius = 0.002;
          g.x = Vec3(0.01 * i + 0.005, 0.01 * j + 0.005, 0.012 * k + 0.01 + side * 0.0023);
          g.v = Vec3(0, 0, -0.25 * side);
          g.w = Vec3(0, 40, 10 * side);
          out.push_back(g);
        }
  return out;
}

TEST(Lists, TakeMoreContactsThanTheyMadeRoomFor) {
  // All contacts of the bed appear between two sorts, when nothing was near: each must be what a pair alone goes through.
  SolverSettings s = box(12, 4);
  s.gravity = Vec3::Zero();
  SolverSettings t = box(2, 2);
  t.gravity = Vec3::Zero();
  Solver many(s, pairs_in_flight(12, 4, 6)), one(t, pairs_in_flight(1, 1, 1)), resumed(s, pairs_in_flight(12, 4, 6));
  many.step(160);  // 1.28 ms: in the middle of the impact
  one.step(160);
  ASSERT_EQ(many.counters().touching, 0.5);
  ASSERT_EQ(many.counters().rebuilds, 1u);
  State saved;
  many.traverse(saved);
  many.step(140);
  one.step(140);
  ASSERT_EQ(many.counters().touching, 0);
  saved.rewind(State::Mode::load);
  resumed.traverse(saved);
  saved.finish();
  resumed.step(140);
  EXPECT_EQ(many.hash(), resumed.hash());
  const auto a = many.grains(), b = one.grains();
  EXPECT_GT(b[1].v[2], 0.05);  // they did bounce, and their spins were braked
  EXPECT_LT(b[1].w[1], 39);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_LT((a[k].v - b[k % 2].v).norm(), 1e-6) << k;
    EXPECT_LT((a[k].w - b[k % 2].w).norm(), 1e-3) << k;
  }
}

TEST(SettledPile, CarriesItsWeightAndComesToRest) {
  // Spin about a single vertical contact has no resistance in this law: rest is judged by the centres.
  for (const double rolling : {0.3, 1.0}) {
    SolverSettings s = box(12, 4);
    s.materials.pairs[0].rolling = rolling;
    s.dt = 2e-5;  // an explicit rolling damper limits the step to 2e-6 s at mu_r = 1
    Solver solver = pile(s);
    solver.step(50000);
    double weight = 0, fastest = 0;
    for (const GrainState& g : solver.grains()) {
      weight += 4.0 / 3 * pi * std::pow(g.radius, 3) * g.density * 9.81;
      fastest = std::max(fastest, g.v.norm());
    }
    EXPECT_NEAR(-solver.body(0).force[2], weight, 0.001 * weight);
    EXPECT_LT(fastest, 5e-3);
  }
}

using Refusal = std::function<void()>;
std::string message(const Refusal& f) {
  try {
    f();
  } catch (const DemError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(WrongInput, IsRefusedByName) {
  const SolverSettings s = box(12, 4);
  auto g = loose(12, 4, 2, 7);
  EXPECT_EQ(message([&] { Solver x(s, {}); }), "no grain");
  auto h = g;
  h[5].x[1] = NAN;
  EXPECT_EQ(message([&] { Solver x(s, h); }), "grain 5: position, velocity or spin is not a number");
  h = g;
  h[3].radius = -1;
  EXPECT_EQ(message([&] { Solver x(s, h); }), "grain 3: radius -1 m must be positive");
  h = g;
  h[2].x[2] = 3;
  EXPECT_THAT(message([&] { Solver x(s, h); }), testing::HasSubstr("grain 2: z = 3 m is outside the domain"));
  h = g;
  h[7].x = h[2].x + Vec3(1e-3, 0, 0);
  EXPECT_THAT(message([&] { Solver x(s, h); }), testing::HasSubstr("grains 2 and 7 overlap by"));
  SolverSettings t = s;
  t.isa = "mmx";
  EXPECT_THAT(message([&] { Solver x(t, g); }), testing::HasSubstr("instruction set 'mmx'"));
  t = s;
  t.domain.hi[1] = 0.012;
  EXPECT_THAT(message([&] { Solver x(t, g); }), testing::HasSubstr("periodic box is 0.012 m along y"));
  t = s;
  t.dt = 0;
  EXPECT_THAT(message([&] { Solver x(t, g); }), testing::HasSubstr("must be positive"));
}

TEST(TooLargeAStep, IsRefusedByName) {
  SolverSettings s = box(12, 4);
  s.dt = 1e-4;
  EXPECT_THAT(message([&] {
                Solver solver = pile(s);
                solver.step(20000);
              }),
              testing::HasSubstr("the step 0.0001 s is too large for the stiffness of the contacts; at most"));
}

TEST(AGrainThatLeaves, StopsTheRun) {
  SolverSettings s = box(12, 4);
  Solver solver(s, loose(12, 4, 2, 7));  // no floor
  EXPECT_THAT(message([&] { solver.step(100000); }), testing::HasSubstr("left the domain"));
}

}  // namespace
