// Effects of bekker.soil_node: off leaves nothing, on each does what its formula says, passes are the nodes' own memory.
#include <gtest/gtest.h>

#include "analytic/helpers.h"
#include "grouser/bekker/effects.h"
#include "grouser/bekker/soil_node.h"

namespace grouser::test {
namespace {

Soil soil_of(const BekkerSoil& b) {
  Soil s;
  s.name = "test soil";
  s.bekker = b;
  s.bulk_density = 1600;
  return s;
}

Bench nodes(const std::string& id = "", double amplitude = 0, const BekkerSoil& soil = mojave(0.16)) {
  Bench b(bekker::soil_node_model(), soil_of(soil), flat_ground(), mit_wheel(),
          "spacing: 5 mm\nrate_reference: 10 mm/s\n");
  if (!id.empty()) b.terrain->set_effect(id, amplitude);
  return b;
}

struct Means {
  double drawbar = 0, torque = 0, normal = 0;
};

/// From x to x + 0.3 m at a fixed depth and slip; means over the last third. Set down and lifted in between.
Means roll(Bench& b, double depth, double slip, double rim_speed = 0.1) {
  const double dt = 1e-3, v = rim_speed * (1 - slip);
  b.motion.X_WB_end.p = Vec3(0, 0, 0.132);
  const auto set_height = [&](double z) {
    const double way = z - b.motion.X_WB_end.p.z();
    for (int i = 0; i < 50; ++i) b.move({{0, 0, way / 50 / dt}, {0, 0, 0}}, dt);
  };
  set_height(0.13 - depth);
  Means m;
  const int steps = static_cast<int>(0.3 / v / dt);
  int n = 0;
  for (int i = 0; i < steps; ++i) {
    const ContactReport& r = b.move({{v, 0, 0}, {0, rim_speed / 0.13, 0}}, dt).report;
    if (3 * i < 2 * steps) continue;
    m.drawbar += r.drawbar_pull, m.torque += r.driving_torque, m.normal += r.normal_force;
    ++n;
  }
  m.drawbar /= n, m.torque /= n, m.normal /= n;
  set_height(0.132);
  return m;
}

void expect_near(const Means& a, const Means& b, double share, const std::string& what) {
  EXPECT_NEAR(a.normal, b.normal, share * b.normal) << what;
  EXPECT_NEAR(a.drawbar, b.drawbar, share * b.normal) << what;
  EXPECT_NEAR(a.torque, b.torque, share * b.normal * 0.13) << what;
}

TEST(NodeEffects, SwitchedOffAgainEachLeavesTheNominalModelBitForBit) {
  Bench plain = nodes();
  roll(plain, 0.008, 0.3);
  State nominal;
  plain.terrain->traverse(nominal);
  for (const Effect& e : plain.terrain->effects()) {
    Bench b = nodes(e.id, 0.5 * (e.lower + e.upper));
    b.terrain->set_effect(e.id, e.amplitude);
    roll(b, 0.008, 0.3);
    State s;
    b.terrain->traverse(s);
    EXPECT_EQ(s.hash(), nominal.hash()) << e.id;
  }
}

// Effects that only change a parameter: the plain model with that parameter. Slip has settled to exp(-2.2) and less over the way
// before the means: 3 % of the force for the exponent, which halves the pressure.
TEST(NodeEffects, ThatOnlyChangeAParameterAreThatParameter) {
  const auto with = [](const char* id, double amplitude) {
    Bench b = nodes(id, amplitude);
    return roll(b, 0.008, 0.3);
  };
  const auto plain = [](auto&& change) {
    BekkerSoil s = mojave(0.16);
    change(s);
    Bench b = nodes("", 0, s);
    return roll(b, 0.008, 0.3);
  };
  expect_near(with("interface_friction", 0.7),
              plain([](BekkerSoil& s) { s.shear.friction_angle = std::atan(0.7 * std::tan(s.shear.friction_angle)); }),
              1e-9, "interface_friction");
  expect_near(with("slip_sinkage_factor", 0.7),
              plain([](BekkerSoil& s) { s.pressure.k *= std::pow(1.3 / 0.85, -0.7 * s.pressure.n); }), 0.01, "factor");
  expect_near(with("slip_sinkage_exponent", 0.8), plain([](BekkerSoil& s) { s.pressure.n += 0.24; }), 0.03, "exponent");
  const double length = 0.13 * std::sin(std::acos(1 - 0.008 / 0.13));
  expect_near(with("plate_size", -1.0), plain([&](BekkerSoil& s) { s.pressure.k *= length / 0.05; }), 0.01,
              "plate_size");
}

// Pressed straight down the wheel feels the integral of its pressure over x (here by 2000 midpoints): nodes of 5 mm see it to 1 %.
TEST(NodeEffects, HardPanIsItsFormulaUnderAWheelThatIsPressedIn) {
  BekkerSoil slick = mojave(0.16);  // without friction along the wheel's surface
  slick.shear.cohesion = slick.shear.friction_angle = 0;
  Bench b = nodes("hard_pan", 20, slick);
  b.motion.X_WB_end.p = Vec3(0, 0, 0.1301);
  for (int i = 0; i < 400; ++i) b.move({{0, 0, -0.03}, {0, 0, 0}}, 1e-3);
  const double h = 0.13 - b.motion.X_WB_end.p.z(), half = std::sqrt(0.13 * 0.13 - (0.13 - h) * (0.13 - h));
  double F = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = half * (2 * (i + 0.5) / 2000 - 1), z = std::sqrt(0.13 * 0.13 - x * x) - (0.13 - h);
    F += 0.16 * 2 * half / 2000 * 254.1e3 * std::pow(z / 0.16, 1.387) / (1 - 20 * z);
  }
  EXPECT_NEAR(b.force(1e-3).z(), F, 0.01 * F);
}

// A locked wheel dragged by j: every node has slid by j, so the drag goes with f(j), and the effect adds rho exp(-j/Kw) of it.
TEST(NodeEffects, ResidualShearIsItsFormulaUnderADraggedWheel) {
  BekkerSoil s = mojave(0.16);
  s.shear.K = 2e-3;
  const auto drag = [&](double rho, double j) {
    Bench b = nodes(rho > 0 ? "residual_shear" : "", rho, s);
    b.motion.X_WB_end.p = Vec3(0, 0, 0.1301);
    for (int i = 0; i < 100; ++i) b.move({{0, 0, -0.06}, {0, 0, 0}}, 1e-3);
    for (int i = 0; i < 200; ++i) b.move({{j / 0.2, 0, 0}, {0, 0, 0}}, 1e-3);
    return b.moment(1e-3).y();
  };
  for (const double j : {0.001, 0.004})  // nodes that come in ahead slide less: 3 %
    EXPECT_NEAR(drag(0.4, j) / drag(0, j), 1 + 0.4 * std::exp(-j / 0.01), 0.03) << j;
}

TEST(NodeEffects, OfPassesActOnTrodSoilAloneAndByTheirAmount) {
  for (const char* id : {"repetitive_loading", "pass_strength"}) {
    Bench plain = nodes(), b = nodes(id, 0.5);
    const Means first = roll(plain, 0.008, 0.3), same = roll(b, 0.008, 0.3);
    EXPECT_EQ(same.normal, first.normal) << id;  // bit for bit: no node was pressed before
    EXPECT_EQ(same.torque, first.torque) << id;
    const Means second = roll(plain, 0.012, 0.3), stiffer = roll(b, 0.012, 0.3);
    if (std::string(id) == "repetitive_loading") {
      // Deeper than the first pass everywhere but at the arc's ends: the stiffer curve carries up to 1.5 times as much.
      EXPECT_GT(stiffer.normal, 1.3 * second.normal);
      EXPECT_LT(stiffer.normal, 1.5 * second.normal);
    } else {
      // Cohesion carries the rest.
      EXPECT_GT(stiffer.torque, 1.4 * second.torque);
      EXPECT_LT(stiffer.torque, 1.5 * second.torque);
    }
  }
}

TEST(NodeEffects, SofterTrodSoilDoesNotJump) {
  // repetitive_loading below zero: reloading meets the softer curve early. The force of a slowly sinking wheel never falls.
  Bench b = nodes("repetitive_loading", -0.4);
  roll(b, 0.008, 0.3);
  b.motion.X_WB_end.p = Vec3(0.15, 0, 0.1301);
  double last = 0;
  for (int i = 0; i < 600; ++i) {
    const double F = b.move({{0, 0, -0.02}, {0, 0, 0}}, 1e-3).impulse.z() / 1e-3;
    EXPECT_GT(F, last - 0.5) << i;
    last = F;
  }
  EXPECT_GT(last, 20);
}

TEST(NodeEffects, LedgerClosesWithEach) {
  const Bench plain = nodes();
  for (const Effect& e : plain.terrain->effects()) {
    const double typical = e.id == "interface_friction" ? 0.7 : e.id == "soil_damping" ? 1 : std::min(e.upper, 0.3);
    Bench b = nodes(e.id, e.id == "hard_pan" ? 10 : typical);
    roll(b, 0.008, 0.3);
    roll(b, 0.010, 0.3);
    const EnergyLedger& l = b.terrain->energy();
    EXPECT_LT(std::abs(l.residual()), 5e-3 * l.gross) << e.id;
    EXPECT_LT(l.work_on_bodies, 0) << e.id;
  }
}

}  // namespace
}  // namespace grouser::test
