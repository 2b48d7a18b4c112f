// Effects of bekker.steady away from steady rolling: energy, standstill, steps of the host.
#include <gtest/gtest.h>

#include "effects/roll.h"

namespace grouser::test {
namespace {

using bekker::EffectInfo, bekker::effect_table;

Setting with(const EffectInfo& e) {
  Setting s;
  s.options = "pass: 2\norder: 0.5\nbounce_damping: 0\n";
  s.effects = {{std::string(e.name), e.typical}};
  return s;
}

/// Lowered, driven, reversed, shaken, lifted: a closed cycle of the hub.
EnergyLedger cycle(const Setting& s, double dt) {
  Bench b = bench_of(s);
  b.motion.X_WB_end.p.z() = 0.1305;
  const int n = static_cast<int>(std::lround(2 / dt));
  for (int i = 0; i < n; ++i) {
    const double x = (i + 0.5) * dt / 2;
    const double down = -0.012 * pi / 2 * std::sin(2 * pi * x) + 0.002 * std::sin(40 * pi * x);
    b.move(
        {{0.05 * std::sin(4 * pi * x), 0.004 * std::sin(6 * pi * x), down}, {0, 0.6 * std::sin(4 * pi * x + 0.4), 0}},
        dt);
  }
  return b.terrain->energy();
}

// The ledger is summed from formulas that do not know of the work on the body; its error is that of the step.
TEST(SteadyEffectEnergy, LedgerClosesAndNoEnergyIsMadeThroughReversalsAndBounces) {
  for (const EffectInfo& e : effect_table()) {
    const EnergyLedger l = cycle(with(e), 1e-3), fine = cycle(with(e), 2.5e-4);
    EXPECT_LT(std::abs(l.residual()), 1e-2 * l.gross) << e.name;
    EXPECT_LT(std::abs(fine.residual()), 2e-3 * fine.gross) << e.name;
    EXPECT_LT(fine.work_on_bodies, 0) << e.name;
    EXPECT_EQ(fine.stored, 0) << e.name;
  }
}

TEST(SteadyEffectEnergy, PressAndReleaseWithoutTravelReturnsNoMoreThanItTook) {
  for (const EffectInfo& e : effect_table()) {
    Bench b = bench_of(with(e));
    b.motion.X_WB_end.p.z() = 0.1301;
    for (int i = 0; i < 2000; ++i) b.move({{0, 0, -0.1 * std::cos(pi * i / 2000)}, {0, 0, 0}}, 1e-4);
    for (int i = 0; i < 100; ++i) b.move({{0, 0, 0.05}, {0, 0, 0}}, 1e-4);
    const EnergyLedger& l = b.terrain->energy();
    EXPECT_LT(l.work_on_bodies, 2e-3 * l.gross) << e.name;
    EXPECT_NEAR(l.residual(), 0, 2e-4 * l.gross) << e.name;
  }
}

TEST(SteadyEffectEnergy, AWheelThatStandsStillIsNotPushed) {
  for (const EffectInfo& e : effect_table()) {
    Bench b = bench_of(with(e));
    b.motion.X_WB_end.p.z() = 0.1301;
    for (int i = 0; i < 100; ++i) b.move({{0, 0, -0.1}, {0, 0, 0}}, 1e-3);
    for (int i = 0; i < 100; ++i) b.move({{0, 0, 0}, {0, 0, 0}}, 1e-3);
    EXPECT_GT(b.force(1e-3).z(), 1) << e.name;
    EXPECT_NEAR(b.force(1e-3).x(), 0, 1e-12) << e.name;
    EXPECT_NEAR(b.force(1e-3).y(), 0, 1e-12) << e.name;
    EXPECT_NEAR(b.moment(1e-3).norm(), 0, 1e-12) << e.name;
  }
}

// A wheel of 11.7 kg under its load, integrated as the adapter does it, by the model's own linearisation: it settles and stays.
TEST(SteadyEffectEnergy, TheLinearisationHoldsALoadedWheelAtAMillisecond) {
  for (const EffectInfo& e : effect_table()) {
    Setting s = with(e);
    s.options = "pass: 2\norder: 0.5\n";
    Bench b = bench_of(s);
    b.motion.X_WB_end.p.z() = 0.125;
    double v = 0;
    const double m = 11.7, dt = 1e-3;
    double last = 0, worst = 0;
    for (int i = 0; i < 4000; ++i) {
      const double travel = std::min(1.0, i / 1000.0) * 0.035;
      const auto& L = b.result.linearisation;
      const double k = L ? -L->dF_dx(2, 2) : 0, d = L ? -L->dF_dv(2, 2) : 0;
      const double F = i ? b.force(dt).z() : 0;
      v += dt * (F / m - 9.81 - dt * k * v / m) / (1 + dt * d / m + dt * dt * k / m);
      b.move({{travel, 0, v}, {0, travel / 0.7 / 0.13, 0}}, dt);
      if (i > 3500) worst = std::max(worst, std::abs(v - last));
      last = v;
    }
    EXPECT_NEAR(b.force(dt).z(), m * 9.81, 0.02 * m * 9.81) << e.name;
    EXPECT_LT(worst, 1e-3) << e.name;
  }
}

}  // namespace
}  // namespace grouser::test
