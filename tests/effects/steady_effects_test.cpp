// Effects of bekker.steady: what is declared, what nothing of them leaves, and the second writing of the law in effect_wheel.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "effects/roll.h"
#include "grouser/bekker/effect_wheel.h"

namespace grouser::test {
namespace {

using bekker::EffectInfo, bekker::effect_table;

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const TerrainError& e) {
    return e.what();
  }
  return "no error";
}

TEST(SteadyEffects, TheWholeTableIsDeclaredWithItsBoundsAndOffValues) {
  const Bench b = bench_of({});
  const auto& declared = b.terrain->effects();
  ASSERT_EQ(declared.size(), 1 + bekker::effect_count);
  for (std::size_t i = 0; i < bekker::effect_count; ++i) {
    const EffectInfo& e = effect_table()[i];
    EXPECT_EQ(declared[i + 1].id, e.name);
    EXPECT_EQ(declared[i + 1].lower, e.lower);
    EXPECT_EQ(declared[i + 1].upper, e.upper);
    EXPECT_EQ(declared[i + 1].amplitude, e.off);
    EXPECT_EQ(declared[i + 1].unit, e.inverse ? "1/m" : std::string(e.unit));
  }
}

/// A wheel that is set down, driven, turned, stopped, reversed and bounced over bumps; the hash of all that it remembers.
std::uint64_t drive_about(Terrain& t, Bench& b) {
  b.motion.X_WB_end.p.z() = 0.132;
  for (int i = 0; i < 4000; ++i) {
    const double x = i * 2e-3;
    const Twist V{{0.2 * std::sin(x), 0.02 * std::sin(3 * x), i < 100 ? -0.08 : 0.01 * std::sin(9 * x)},
                  {0, 2 * std::sin(x + 0.2) + 0.5, 0.1 * std::sin(x)}};
    b.move(V, 2e-3);
  }
  State s;
  t.traverse(s);
  return s.hash();
}

TEST(SteadyEffects, SwitchedOffAgainEachLeavesTheNominalModelBitForBit) {
  Bench plain = bench_of({});
  const std::uint64_t nominal = drive_about(*plain.terrain, plain);
  const Vec3 force = plain.result.impulse;
  for (const EffectInfo& e : effect_table()) {
    Bench b = bench_of({});
    b.terrain->set_effect(std::string(e.name), e.typical);
    b.terrain->set_effect(std::string(e.name), e.off);
    EXPECT_EQ(drive_about(*b.terrain, b), nominal) << e.name;
    EXPECT_EQ(b.result.impulse, force) << e.name;
  }
}

TEST(SteadyEffects, OnEachChangesTheForces) {
  for (const EffectInfo& e : effect_table()) {
    Setting s;
    s.options = "pass: 2\norder: 0.5\n";
    s.sinkage = 0.02;
    s.soil.shear.K = 4e-3;
    const Rolled plain = roll(s);
    s.effects = {{std::string(e.name), e.typical}};
    const Rolled with = roll(s);
    const double change = std::abs(with.drawbar - plain.drawbar) + std::abs(with.normal - plain.normal);
    EXPECT_GT(change, 0.01) << e.name;
  }
}

/// The other writing of the law: quasi-static, other pieces, other rule. It finds the sinkage that carries a load; the model, held at that
/// sinkage and rolled, must answer with that load, drawbar and torque. Where the stresses are smooth on the pieces both are good to 1e-6.
/// The rates have kinks inside of them (v_min), which the other's 10 points a piece see to 5e-4 of the load; the pan bends.
TEST(SteadyEffects, AgreeWithTheLawOfTheDiagnosis) {
  int compared = 0;
  for (const EffectInfo& e : effect_table())
    for (const double slip : {-0.5, -0.1, 0.0, 0.1, 0.3, 0.7})
      for (const double load : {60.0, 225.0})
        for (const double amplitude : {e.typical, e.lower < 0 ? -0.5 * e.typical : 0.5 * (e.off + e.typical)}) {
          Setting s;
          s.options = "pass: 2\norder: 0.6\npoints: 96\n";
          s.slip = slip;
          s.effects = {{std::string(e.name), amplitude}};
          s.soil.shear.K = 2e-3;
          bekker::EffectWheel wheel{s.radius, s.width, 0.16, {}};
          bekker::EffectCondition run{s.rim_speed, 2, 0.6};
          const BekkerSoil& b = s.soil;
          bekker::WheelState<double> q{b.pressure.k,
                                       b.pressure.n,
                                       b.shear.cohesion,
                                       b.shear.friction_angle,
                                       b.shear.K,
                                       b.angles.a0,
                                       b.angles.a1,
                                       slip,
                                       load,
                                       bekker::no_effects(),
                                       0};
          const auto i = static_cast<std::size_t>(e.id);
          q.effect[i] = amplitude;
          q.active = 1U << i;
          double theta = 0;
          bekker::WheelAnswer<double> a{};
          ASSERT_EQ(bekker::effect_equilibrium(wheel, run, q, 0, theta, a), bekker::ForceStatus::ok) << e.name;
          s.sinkage = a.sinkage;
          const Rolled r = roll(s);
          const bool kinks = e.id == bekker::Effect::pressure_rate || e.id == bekker::Effect::shear_rate ||
                             e.id == bekker::Effect::hard_pan;
          const double most = (kinks ? 5e-4 : 3e-6) * load;
          const auto where = [&] {
            return std::string(e.name) + " " + std::to_string(amplitude) + ", slip " + std::to_string(slip) + ", " +
                   std::to_string(load) + " N";
          };
          EXPECT_NEAR(r.normal, load, most) << where();
          EXPECT_NEAR(r.drawbar, a.drawbar, most) << where();
          EXPECT_NEAR(r.torque, a.torque, most * s.radius) << where();
          ++compared;
        }
  EXPECT_EQ(compared, 19 * 24);
}

TEST(SteadyEffects, RunBackwardsAsForwards) {
  for (const EffectInfo& e : effect_table()) {
    Setting s;
    s.options = "pass: 2\norder: 0.5\n";
    s.side_speed = 0.01;
    s.effects = {{std::string(e.name), e.typical}};
    const Rolled ahead = roll(s);
    s.rim_speed = -s.rim_speed;
    const Rolled back = roll(s);
    EXPECT_NEAR(back.drawbar, -ahead.drawbar, 1e-9 * ahead.normal) << e.name;
    EXPECT_NEAR(back.torque, -ahead.torque, 1e-9 * ahead.normal) << e.name;
    EXPECT_NEAR(back.normal, ahead.normal, 1e-9 * ahead.normal) << e.name;
    EXPECT_NEAR(back.side, ahead.side, 1e-9 * ahead.normal) << e.name;
  }
}

TEST(SteadyEffects, SharesAreTheChangeThatEachMakes) {
  Setting s;
  s.effects = {{"bulldozing", 1.0}, {"interface_friction", 0.7}};
  Bench b = bench_of(s);
  b.motion.X_WB_end.p.z() = s.radius - s.sinkage;
  for (int i = 0; i < 3000; ++i) b.move({{0.035, 0, 0}, {0, 0.05 / 0.13, 0}}, 5e-3);
  const ContactReport& r = b.result.report;
  ASSERT_EQ(r.effect_share.size(), b.terrain->effects().size());
  Setting less = s;
  for (std::size_t i = 0; i < r.effect_share.size(); ++i) {
    const std::string& id = b.terrain->effects()[i].id;
    if (id != "bulldozing" && id != "interface_friction") {
      EXPECT_TRUE(r.effect_share[i].isZero(0)) << id;
      continue;
    }
    less.effects = {s.effects[id == "bulldozing" ? 1 : 0]};
    const Rolled without = roll(less);
    // The steady state of the stick depends on the step by some 1e-6.
    EXPECT_NEAR(r.effect_share[i][0], r.drawbar_pull - without.drawbar, 1e-5 * r.normal_force) << id;
    EXPECT_NEAR(r.effect_share[i][3], r.driving_torque - without.torque, 1e-5 * r.normal_force) << id;
  }
}

TEST(SteadyEffects, WhatAModelOrSoilCannotIsRefusedByName) {
  Setting no_density;
  no_density.density = 0;
  Bench b = bench_of(no_density);
  EXPECT_EQ(message_of([&] { b.terrain->set_effect("bulldozing", 1); }),
            "effect 'bulldozing' of bekker.steady needs the bulk_density of soil 'test soil'");
  Setting closed;
  closed.options = "method: quadratic\n";
  Bench c = bench_of(closed);
  EXPECT_EQ(message_of([&] { c.terrain->set_effect("hard_pan", 5); }),
            "effect 'hard_pan' of bekker.steady needs 'method: nonlinear': the closed forms know the plain law only");
  EXPECT_EQ(message_of([&] { c.terrain->set_effect("hard_pen", 5); }),
            "bekker.steady has no effect 'hard_pen'; did you mean 'hard_pan'?");
  Setting rebound;
  rebound.soil.angles.b0 = 0.3;
  Bench d = bench_of(rebound);
  EXPECT_EQ(message_of([&] { d.terrain->set_effect("exit_angle", 0.8); }),
            "effect 'exit_angle' of bekker.steady and the soil's own b0 + b1 may be 1 at most together");
  Soil soil;
  soil.bekker = mojave();
  Bench e(bekker::steady_model(), soil, flat_ground(), {"mer", LuggedCylinder{0.125, 0.16, 0.01, 0.003, 24, 0.1}});
  EXPECT_EQ(message_of([&] { e.terrain->set_effect("lugs", 0.01); }),
            "effect 'lugs' of bekker.steady is for a wheel that is carried as smooth; wheel 'wheel' has lugs of its "
            "own, which the "
            "law takes already");
  Setting named;
  named.options = "pass: {rear: 2}\n";
  Bench f = bench_of(named);
  EXPECT_EQ(message_of([&] {
              f.move({{0, 0, 0}, {0, 0, 0}}, 1e-3);
            }),
            "option 'pass' of bekker.steady names a wheel 'rear', which there is not; wheels: wheel");
}

}  // namespace
}  // namespace grouser::test
