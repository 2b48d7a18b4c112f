// The energy ledger: every term has its own formula, so that it closes only if all of them are right.
#include <gtest/gtest.h>

#include <random>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

/// Grains poured into a box whose upper half is then pushed aside: falling, damping, friction, rolling, work of a body.
Ledger poured_and_pushed(double dt, LawSettings law, double rolling) {
  std::mt19937 g(3);
  std::uniform_real_distribution<double> u(0, 1);
  std::vector<GrainState> grains;
  for (int k = 0; k < 5; ++k)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        GrainState s;
        s.radius = 0.003 + 0.0015 * u(g);
        s.x = Vec3(0.01 * i - 0.015 + 5e-4 * u(g), 0.01 * j - 0.015 + 5e-4 * u(g), 0.01 * k + 0.006);
        grains.push_back(s);
      }
  SolverSettings s;
  s.domain.lo = Vec3(-0.06, -0.06, -0.05);
  s.domain.hi = Vec3(0.06, 0.06, 0.15);
  s.domain.periodic = {false, false, false};
  s.dt = dt;
  s.law = law;
  s.ledger = true;
  s.precision = Precision::full;
  s.materials.pairs[0].rolling = rolling;
  Solver solver(s, grains);
  BodySettings low, high;
  low.X_WB.p = Vec3(0, 0, 0.01);
  high.X_WB.p = Vec3(0, 0, 0.06);
  solver.add_mesh(solver.add_body(low), box_mesh(Vec3(0.04, 0.04, 0.02), true, false));
  const int upper = solver.add_body(high);
  solver.add_mesh(upper, box_mesh(Vec3(0.04, 0.04, 0.08), true, true));
  solver.step(std::lround(0.1 / dt));
  Twist V;
  V.v = Vec3(0.02, 0, 0);
  solver.set_motion(upper, V);
  solver.step(std::lround(0.2 / dt));
  return solver.ledger();
}

TEST(EnergyLedger, ClosesInFirstOrderOfTheStep) {
  for (const Cap cap : {Cap::sum, Cap::springs}) {
    LawSettings law;
    law.cap = cap;
    double share[2];
    for (int k = 0; k < 2; ++k) {
      const Ledger l = poured_and_pushed(k == 0 ? 8e-6 : 1e-6, law, 0.3);
      share[k] = l.residual() / (l.gravity + l.bodies);
      EXPECT_GT(l.sliding, 0);
      EXPECT_GT(l.rolling_damping, 0);
      EXPECT_GT(l.bodies, 0);
    }
    EXPECT_LT(std::fabs(share[1]), 4e-3);
    EXPECT_LT(std::fabs(share[1]), 0.5 * std::fabs(share[0]));
  }
}

}  // namespace
