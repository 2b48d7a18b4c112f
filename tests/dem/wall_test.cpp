// Grains on planes: against rigid-body theory, which the contact law does not contain.
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

constexpr double kRadius = 0.005;

SolverSettings flat(double dt = 1e-6, Precision p = Precision::single) {
  SolverSettings s;
  s.domain.hi = Vec3(0.5, 0.05, 0.1);
  s.dt = dt;
  s.precision = p;
  return s;
}
GrainState ball(const Vec3& x) {
  GrainState g;
  g.x = x;
  g.radius = kRadius;
  return g;
}
double mass() { return 4.0 / 3 * pi * std::pow(kRadius, 3) * 3100; }

TEST(GrainOnAPlane, RestsWithItsWeightAndTheHertzianOverlap) {
  for (const Precision p : {Precision::single, Precision::full}) {
    SolverSettings s = flat(2e-6, p);
    Solver solver(s, {ball({0.1, 0.02, kRadius})});
    solver.add_floor();
    solver.set_drag(200);
    solver.step(100000);
    const double weight = mass() * 9.81;
    EXPECT_NEAR(-solver.body(0).force[2], weight, 1e-4 * weight);
    // F = 4/3 E* sqrt(R) delta^(3/2); wall and grain of the same material.
    const double E = 7e7 / (2 * (1 - 0.35 * 0.35));
    const double delta = std::pow(weight * 0.75 / E / std::sqrt(kRadius), 2.0 / 3);
    // Single precision: the unit of position is 0.047 nm here (0.1 m over 2^31), the overlap 0.7 um.
    EXPECT_NEAR(kRadius - solver.grains()[0].x[2], delta, 3e-3 * delta);
  }
}

TEST(GrainOnAPlane, BouncesBackWithTheRestitutionOfTheLaw) {
  // Damping of this form gives e only for a contact that ends at zero force; the one used here ends at zero overlap.
  // Head-on e of the law is independent of speed (dimensional analysis): three speeds, one value.
  double e[3];
  const double speeds[3] = {0.01, 0.1, 0.5};
  for (int k = 0; k < 3; ++k) {
    SolverSettings s = flat(1e-7, Precision::full);
    s.gravity = Vec3::Zero();
    GrainState g = ball({0.1, 0.02, kRadius + 1e-8});
    g.v = Vec3(0, 0, -speeds[k]);
    Solver solver(s, {g});
    solver.add_floor();
    solver.step(20000);
    e[k] = solver.grains()[0].v[2] / speeds[k];
  }
  EXPECT_NEAR(e[0], e[2], 2e-3);
  EXPECT_NEAR(e[1], e[2], 2e-3);
  EXPECT_NEAR(e[1], 0.4, 0.03);  // nominal value, for which the coefficient was derived approximately
}

TEST(GrainOnAPlane, SlidingThroughoutAnImpactGetsTheImpulseOfFriction) {
  // Steep tangential approach: the contact slides all the time, so dv_t = mu (1 + e) v_n and r dw = 5/2 dv_t, for
  // whatever the normal law does.
  for (const Cap cap : {Cap::sum, Cap::springs}) {
    SolverSettings s = flat(2e-7, Precision::full);
    s.gravity = Vec3::Zero();
    s.law.cap = cap;
    s.materials.pairs[0].friction = 0.3;
    s.materials.pairs[0].rolling = 0;
    s.materials.pairs[0].restitution = 0.9;
    GrainState g = ball({0.1, 0.02, kRadius + 1e-8});
    g.v = Vec3(1.0, 0, -0.1);
    Solver solver(s, {g});
    solver.add_floor();
    solver.step(10000);
    const GrainState after = solver.grains()[0];
    const double dvn = after.v[2] + 0.1, dvt = 1.0 - after.v[0];
    EXPECT_GT(after.v[2], 0.05);
    // At the end of contact damping turns the normal force tensile; friction follows its size, |F_n|: the impulse is
    // larger than mu dvn by twice the tensile part, under one per cent at e = 0.9.
    EXPECT_NEAR(dvt / dvn, 0.3, 0.003);
    // Arm of friction: r less half the overlap, 0.4 % here.
    EXPECT_NEAR(kRadius * after.w[1] / dvt, 2.5, 0.02);
  }
}

TEST(GrainOnAPlane, RollsToRestUnderTheRollingTorque) {
  // Constant torque mu_r r F: m dv/dt = -Ff, I dw/dt = Ff r - mu_r r m g, v = w r: dv/dt = -5/7 mu_r g.
  SolverSettings s = flat(4e-6);
  s.materials.pairs[0].rolling = 0.05;
  GrainState g = ball({0.1, 0.02, kRadius - 7e-7});
  g.v = Vec3(0.1, 0, 0);
  g.w = Vec3(0, 0.1 / kRadius, 0);
  Solver solver(s, {g});
  solver.add_floor();
  solver.step(25000);
  const double t = solver.time(), expected = 0.1 - 5.0 / 7 * 0.05 * 9.81 * t;
  ASSERT_GT(expected, 0.05);
  // 0.5 % of the change: the spring has to be wound up first.
  EXPECT_NEAR(solver.grains()[0].v[0], expected, 0.005 * (0.1 - expected));
  solver.step(100000);
  EXPECT_NEAR(solver.grains()[0].v[0], 0, 1e-4);
}

TEST(GrainOnAPlane, SlidingBlockOfFrozenSpinSlowsByCoulombsLaw) {
  // A grain thrown flat without spin slides at first: dv/dt = -mu g until it rolls at 5/7 of its speed.
  SolverSettings s = flat(2e-6);
  s.materials.pairs[0].friction = 0.2;
  s.materials.pairs[0].rolling = 0;
  GrainState g = ball({0.1, 0.02, kRadius - 7e-7});
  g.v = Vec3(0.2, 0, 0);
  Solver solver(s, {g});
  solver.add_floor();
  solver.step(5000);
  EXPECT_NEAR(solver.grains()[0].v[0], 0.2 - 0.2 * 9.81 * solver.time(), 2e-4);
  solver.step(45000);
  EXPECT_NEAR(solver.grains()[0].v[0], 0.2 * 5 / 7, 0.2 * 2e-3);
}

TEST(Planes, GetTheImpulseThatTheGrainsLose) {
  SolverSettings s = flat(2e-6, Precision::full);
  std::vector<GrainState> g;
  for (int k = 0; k < 40; ++k) g.push_back(ball({0.02 + 0.011 * k, 0.01 + 0.005 * (k % 3), 0.01 + 0.012 * (k % 5)}));
  Solver solver(s, g);
  solver.add_floor();
  solver.step(50000);
  const double weight = 40 * mass() * 9.81 * solver.time();
  const Vec3 p = solver.momentum() - solver.body(0).impulse * -1.0;
  // m v = gravity's impulse + the plane's, to the rounding of sums.
  EXPECT_NEAR(p[2], -weight, 1e-10 * weight);
  EXPECT_NEAR(p[0], 0, 1e-10 * weight);
}

}  // namespace
