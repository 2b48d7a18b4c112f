#include "grouser/terrain/rigid.h"

#include <gtest/gtest.h>

#include "helpers.h"

namespace grouser {
namespace {

using test::Bench;

Soil hard(double k = 1e5, double mu = 0.6) {
  Soil s;
  s.name = "hard";
  s.rigid = RigidSoil{k, 1e3, mu, 0, 0};
  return s;
}

TEST(Rigid, ThousandKilogramsRestAtExactlyTheirWeightOverTheStiffness) {
  Bench b(rigid_model(), hard(), flat_ground());
  b.motion.X_WB_end.p.z() = 0.13 - 1000 * 9.81 / 1e5;
  b.move({}, 1e-3);
  EXPECT_NEAR(b.force(1e-3).z(), 9810, 1e-6);
  EXPECT_NEAR(b.result.report.sinkage, 0.0981, 1e-10);
  EXPECT_NEAR(b.force(1e-3).head<2>().norm(), 0, 1e-6);
  EXPECT_NEAR(b.moment(1e-3).norm(), 0, 1e-6);
}

TEST(Rigid, ForceGrowsFromZeroAtTouchDownAndNeverPulls) {
  Bench b(rigid_model(), hard(), flat_ground());
  b.motion.X_WB_end.p.z() = 0.13;
  b.move({{0, 0, -1}, {0, 0, 0}}, 1e-9);  // 1 nm in, at 1 m/s: a plain damper would answer 1000 N
  EXPECT_LT(b.force(1e-9).z(), 1e-3);
  EXPECT_GE(b.force(1e-9).z(), 0);
  b.motion.X_WB_end.p.z() = 0.129;
  b.move({{0, 0, 5}, {0, 0, 0}}, 1e-5);
  EXPECT_GE(b.force(1e-5).z(), 0);
}

TEST(Rigid, DamperActsLikeAPlainOneNearRest) {
  Bench b(rigid_model(), hard(), flat_ground());
  b.motion.X_WB_end.p.z() = 0.12;
  b.move({{0, 0, -0.05}, {0, 0, 0}}, 1e-9);
  EXPECT_NEAR(b.force(1e-9).z(), 1e5 * 0.01 + 1e3 * 0.05, 1e-3);
}

TEST(Rigid, DraggedLockedWheelIsACoulombBlock) {
  const double dt = 1e-3;
  Bench b(rigid_model(), hard(), flat_ground());
  b.motion.X_WB_end.p.z() = 0.129;  // 100 N, mu N = 60 N, k_t = 1e5 N/m: slips after 0.6 mm less the damper's share
  b.move({}, dt);
  b.move({{1e-3, 0, 0}, {0, 0, 0}}, dt);
  EXPECT_NEAR(b.force(dt).x(), -(1e5 * 1e-6 + 1e3 * 1e-3), 1e-9);  // spring and damper
  for (int i = 0; i < 2000; ++i) b.move({{1e-3, 0, 0}, {0, 0, 0}}, dt);
  EXPECT_NEAR(b.force(dt).x(), -60, 1e-9);
  b.move({}, dt);  // stopped: the bristle keeps its force
  EXPECT_NEAR(b.force(dt).x(), -60, 1e-9);
  for (int i = 0; i < 1000; ++i) b.move({{1e-3, 1e-3, 0}, {0, 0, 0}}, dt);
  const Vec3 f = b.force(dt);
  EXPECT_NEAR(std::hypot(f.x(), f.y()), 60, 1e-9);
  EXPECT_NEAR(f.x(), f.y(), 0.5);  // turns to the direction of sliding
}

TEST(Rigid, FreelyRollingWheelFeelsNoDragAndRollingResistanceIsItsShareOfTheLoad) {
  Soil s = hard();
  for (double c : {0.0, 0.02}) {
    s.rigid->rolling_resistance = c;
    Bench b(rigid_model(), s, flat_ground());
    b.motion.X_WB_end.p.z() = 0.129;
    const double dt = 1e-3;
    for (int i = 0; i < 2000; ++i) b.move({{0.129 * 4, 0, 0}, {0, 4, 0}}, dt);
    EXPECT_NEAR(b.force(dt).x(), 0, 1e-6);
    EXPECT_NEAR(b.moment(dt).y(), -c * 100 * 0.13, 1e-6);
    EXPECT_NEAR(b.result.report.driving_torque, c * 100 * 0.13, 1e-6);
  }
}

TEST(Rigid, LedgerClosesOverABumpyDriveWithSlip) {
  const GroundPtr ground =
      test::ground_of([](double x, double) { return 0.01 * std::sin(20 * x) + 0.003 * std::sin(77 * x); }, 1e-3);
  Soil s = hard();
  s.rigid->rolling_resistance = 0.02;
  Bench b(rigid_model(), s, ground);
  const double dt = 1e-4;
  b.motion.X_WB_end.p.z() = 0.13;
  for (int i = 0; i < 20000; ++i) b.move({{0.5, 0.1 * std::sin(1e-3 * i), 0.05 * std::cos(2e-3 * i)}, {0, 5, 0.1}}, dt);
  const EnergyLedger& e = b.terrain->energy();
  EXPECT_GT(e.gross, 1);
  EXPECT_GE(e.dissipated, 0);
  EXPECT_LT(std::abs(e.residual()), 1e-3 * e.gross);
  EXPECT_LT(std::abs(e.integration), 0.02 * e.gross);  // O(dt)
}

TEST(Rigid, LinearisationMatchesDifferencesWhileSticking) {
  const double dt = 1e-3, d = 1e-7;
  Bench b(rigid_model(), hard(), flat_ground());
  b.motion.X_WB_end.p.z() = 0.129;
  b.move({}, dt);
  const Linearisation L = *b.result.linearisation;
  for (int axis = 0; axis < 3; ++axis) {
    BodyMotion m = b.motion;
    m.X_WB_begin = m.X_WB_end;
    m.X_WB_end.p[axis] += d;
    m.V_WB_end.v[axis] = d / dt;
    BodyResult r;
    b.terrain->preview(b.t, dt, {&m, 1}, {&r, 1});
    const double change = (r.impulse[axis] - b.result.impulse[axis]) / dt;
    EXPECT_NEAR(change, L.dF_dx(axis, axis) * d + L.dF_dv(axis, axis) * d / dt, 1e-3 * std::abs(change)) << axis;
  }
}

}  // namespace
}  // namespace grouser
