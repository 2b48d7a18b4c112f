// The energy ledger: works are booked apart from the motion that they cause, so that it closes only if all are right.
#include <gtest/gtest.h>

#include <random>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

SolverSettings box(double dt, Precision precision) {
  SolverSettings s;
  s.domain.lo = Vec3(-0.06, -0.06, -0.05);
  s.domain.hi = Vec3(0.06, 0.06, 0.25);
  s.domain.periodic = {false, false, false};
  s.dt = dt;
  s.ledger = true;
  s.precision = precision;
  return s;
}
std::vector<GrainState> loose(int layers) {
  std::mt19937 g(3);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<GrainState> grains;
  for (int k = 0; k < layers; ++k)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        GrainState s;
        s.radius = 0.003 + 0.0015 * u(g);
        s.x = Vec3(0.01 * i - 0.015 + 5e-4 * u(g), 0.01 * j - 0.015 + 5e-4 * u(g), 0.01 * k + 0.006);
        grains.push_back(s);
      }
  return grains;
}
/// Lower and upper half of a box; returns the upper one.
int split_box(Solver& solver) {
  BodySettings low, high;
  low.X_WB.p = Vec3(0, 0, 0.01);
  high.X_WB.p = Vec3(0, 0, 0.07);
  solver.add_mesh(solver.add_body(low), box_mesh(Vec3(0.04, 0.04, 0.02), true, false));
  const int upper = solver.add_body(high);
  solver.add_mesh(upper, box_mesh(Vec3(0.04, 0.04, 0.1), true, true));
  return upper;
}

TEST(EnergyLedger, ClosesWhilePouringAndPushing) {
  // Falling, collisions, friction, rolling, work of a body, at the default step: 0.1 % of the energy given.
  for (const Cap cap : {Cap::sum, Cap::springs}) {
    SolverSettings s = box(8e-6, Precision::full);
    s.law.cap = cap;
    Solver solver(s, loose(5));
    const int upper = split_box(solver);
    solver.step(12500);
    Twist V;
    V.v = Vec3(0.02, 0, 0);
    solver.set_motion(upper, V);
    solver.step(12500);
    const Ledger l = solver.ledger();
    EXPECT_LT(std::fabs(l.residual()), 1e-3 * (l.gravity + l.bodies));
    EXPECT_GT(l.sliding, 0);
    EXPECT_GT(l.rolling_damping, 0);
    EXPECT_GT(l.bodies, 0);
  }
}

/// Bed at rest under a rough plate of 0.8 kg; the upper half of the box and the plate are pushed aside by 2 mm.
void expect_shear_to_close(SolverSettings s, double share) {
  Solver solver(s, loose(5));
  const int upper = split_box(solver);
  BodySettings p;
  p.free = true;
  p.mass = 0.8;
  p.locked = {true, true, false, true, true, true};
  p.X_WB.p = Vec3(0, 0, 0.06);
  const int plate = solver.add_body(p);
  std::vector<Vec3> centres;
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b) centres.push_back(Vec3((a + 0.5) * 0.005 - 0.02, (b + 0.5) * 0.005 - 0.02, 0.0025));
  solver.add_spheres(plate, centres, std::vector<double>(centres.size(), 0.0025));
  solver.step_for(0.25);
  const Ledger before = solver.ledger();
  Twist V, W = solver.twist(plate);
  V.v[0] = W.v[0] = 0.02;
  solver.set_motion(upper, V);
  solver.set_motion(plate, W);
  solver.step_for(0.1);
  const Ledger after = solver.ledger();
  const double work = after.bodies - before.bodies;
  EXPECT_GT(work, 1e-4);
  EXPECT_LT(std::fabs(after.residual() - before.residual()), share * work);
  // Most of the work is lost, so that it is not the springs alone that are compared.
  EXPECT_GT(after.lost() - before.lost(), 0.3 * work);
}

TEST(EnergyLedger, OfAShearTestClosesWithinAThousandthOfTheWork) {
  expect_shear_to_close(box(8e-6, Precision::full), 1e-3);
  expect_shear_to_close(box(8e-6, Precision::single), 1e-3);
}

TEST(EnergyLedger, OfAShearTestClosesWithTheRollingCoefficientThatDependsOnTheRate) {
  SolverSettings s = box(8e-6, Precision::full);
  s.law.rolling = RollingCoefficient::rate;
  s.materials.pairs[0].rolling = 6.75e8;
  expect_shear_to_close(s, 1e-3);
}

TEST(EnergyLedger, CountsWhatCohesionHolds) {
  // Two grains pulled together by cohesion from a small gap of overlap zero: what they lose in damping came from it.
  SolverSettings s = box(1e-6, Precision::full);
  s.gravity = Vec3::Zero();
  s.materials.pairs[0].cohesion = 4e5;
  GrainState a, b;
  a.radius = b.radius = 0.004;
  a.x = Vec3(0, 0, 0.1);
  b.x = Vec3(0.0079995, 0, 0.1);
  Solver solver(s, {a, b});
  solver.step(20000);
  const Ledger l = solver.ledger();
  EXPECT_LT(l.cohesion, 0);
  EXPECT_GT(l.normal_damping, 0);
  EXPECT_LT(std::fabs(l.residual()), 1e-3 * l.normal_damping);
}

}  // namespace
