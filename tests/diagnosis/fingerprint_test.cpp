// What each effect does to a wheel, against a formula written here, a parameter of the plain law, or a limiting case.
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/bekker/effect_wheel.h"

namespace grouser::bekker {
namespace {

struct Outcome {
  double F, T, z, theta;
};

struct Setting {
  double k = 254.1e3, n = 1.387, c = 139.28, phi = 0.606, K = 0.5151e-3, a0 = 0.18, a1 = 0.32, slip = 0.3, load = 115,
         rim = 0.039, radius = 0.13;
  int pass = 1;
  double order = 0;
};

Outcome turn(const Setting& s, const EffectValues& e) {
  WheelState<double> q{s.k, s.n, s.c, s.phi, s.K, s.a0, s.a1, s.slip, s.load, e, 0};
  for (const EffectInfo& i : effect_table())
    if (e[static_cast<std::size_t>(i.id)] != i.off) q.active |= 1U << static_cast<unsigned>(i.id);
  double theta = 0;
  WheelAnswer<double> a{};
  EXPECT_EQ(effect_equilibrium({s.radius, 0.16, 0.16, {}}, {s.rim, s.pass, s.order}, q, 0, theta, a), ForceStatus::ok);
  return {a.drawbar, a.torque, a.sinkage, theta};
}
Outcome plain(const Setting& s) { return turn(s, no_effects()); }
Outcome with(const Setting& s, Effect e, double x) {
  EffectValues v = no_effects();
  v[static_cast<std::size_t>(e)] = x;
  return turn(s, v);
}
// The equilibrium is solved to 1e-9 of the load; the rest is rounding.
void expect_same(const Outcome& a, const Outcome& b, double tolerance = 1e-6) {
  EXPECT_NEAR(a.F, b.F, tolerance * 115);
  EXPECT_NEAR(a.T, b.T, tolerance * 15);
  EXPECT_NEAR(a.z, b.z, tolerance * 0.02);
}

TEST(Fingerprint, AnAmplitudeOfZeroIsBitwiseTheNominalModel) {
  for (const double slip : {-0.6, -0.1, 0.0, 0.2, 0.7}) {
    Setting s;
    s.slip = slip, s.pass = 2, s.order = 0.5;
    WheelState<double> q{s.k, s.n, s.c, s.phi, s.K, s.a0, s.a1, s.slip, s.load, no_effects(), 0}, all = q;
    all.active = (1U << effect_count) - 1;  // every effect looked at, each off
    double ta = 0, tb = 0;
    WheelAnswer<double> a{}, b{};
    ASSERT_EQ(effect_equilibrium({0.13, 0.16, 0.16, {}}, {0.039, 2, 0.5}, q, 0, ta, a), ForceStatus::ok);
    ASSERT_EQ(effect_equilibrium({0.13, 0.16, 0.16, {}}, {0.039, 2, 0.5}, all, 0, tb, b), ForceStatus::ok);
    EXPECT_EQ(a.drawbar, b.drawbar);
    EXPECT_EQ(a.torque, b.torque);
    EXPECT_EQ(a.sinkage, b.sinkage);
    EXPECT_EQ(ta, tb);
  }
}

TEST(Fingerprint, SlipSinkageExponentIsAnotherExponentAtEachSlip) {
  Setting s, t;
  s.slip = -0.4, t.slip = -0.4, t.n = s.n + 0.5 * 0.4;
  expect_same(with(s, Effect::slip_sinkage_exponent, 0.5), plain(t));
}

TEST(Fingerprint, SlipSinkageFactorIsASofterSoilAtEachSlip) {  // sigma at z/f is k f^-n at z
  Setting s, t;
  s.slip = t.slip = 0.5;
  t.k = s.k * std::pow(1.5 / 0.75, -0.7 * s.n);
  expect_same(with(s, Effect::slip_sinkage_factor, 0.7), plain(t));
}

TEST(Fingerprint, SlipDiggingSinksWithoutForce) {
  Setting s;
  s.slip = 0.6;
  Outcome p = plain(s);
  p.z += 0.002 * 1.5;
  expect_same(with(s, Effect::slip_digging, 0.002), p);
  s.slip = -0.6;
  expect_same(with(s, Effect::slip_digging, 0.002), plain(s));
}

TEST(Fingerprint, RepetitiveLoadingAndPassStrengthActFromTheSecondPassOn) {
  Setting s, t;
  expect_same(with(s, Effect::repetitive_loading, 0.8), plain(s));
  expect_same(with(s, Effect::pass_strength, 0.1), plain(s));
  s.pass = t.pass = 2;
  t.k = 1.8 * s.k;
  expect_same(with(s, Effect::repetitive_loading, 0.8), plain(t));
  t = s;
  t.phi = std::atan(1.1 * std::tan(s.phi));
  expect_same(with(s, Effect::pass_strength, 0.1), plain(t));
}

TEST(Fingerprint, BulldozingTakesThePassiveForceOfTheSinkage) {
  const Setting s;
  const Outcome p = plain(s), b = with(s, Effect::bulldozing, 1.5);
  const double Kp = (1 + std::sin(s.phi)) / (1 - std::sin(s.phi));  // Rankine in its other form
  EXPECT_NEAR(p.F - b.F, 1.5 * 0.16 * (0.5 * 1600 * 9.81 * p.z * p.z * Kp + 2 * s.c * p.z * std::sqrt(Kp)), 1e-9);
  EXPECT_EQ(p.T, b.T);
  EXPECT_EQ(p.z, b.z);
}

TEST(Fingerprint, SideWallDragsOnTheSunkenSegment) {
  const Setting s;
  const Outcome p = plain(s), w = with(s, Effect::side_wall, 2);
  double area = 0;  // strips of the segment, midpoint rule
  for (int i = 0; i < 4000; ++i) {
    const double y = s.radius - p.z * (i + 0.5) / 4000;
    area += 2 * std::sqrt(s.radius * s.radius - y * y) * p.z / 4000;
  }
  EXPECT_NEAR(p.F - w.F, 2 * area * (s.c + (1 - std::sin(s.phi)) * 1600 * 9.81 * p.z * std::tan(s.phi)),
              1e-4 * (p.F - w.F));
}

TEST(Fingerprint, InterfaceFrictionIsAnotherFrictionAngle) {
  Setting s, t;
  t.phi = std::atan(0.75 * std::tan(s.phi));
  expect_same(with(s, Effect::interface_friction, 0.75), plain(t));
}

TEST(Fingerprint, ShearModulusLoadAndPreparationDriftAreParametersOfTheRun) {
  Setting s, t;
  s.load = t.load = 200;
  t.K = s.K * std::sqrt(2.0);
  expect_same(with(s, Effect::shear_modulus_load, 0.5), plain(t));
  t = s;
  s.order = 0.5, t.k = 1.15 * s.k;
  expect_same(with(s, Effect::preparation_drift, 0.3), plain(t));
}

TEST(Fingerprint, ContactAngleCurvatureMovesTheLargestPressure) {
  Setting s, t;
  s.slip = t.slip = -0.5, t.a0 = s.a0 - 0.2 * 0.25;
  expect_same(with(s, Effect::contact_angle_curvature, 0.2), plain(t));
}

TEST(Fingerprint, PlateSizeIsTheModulusOfItsOwnContactLength) {
  const Setting s;
  const Outcome p = with(s, Effect::plate_size, 0.4);
  Setting t;
  t.k = s.k * std::pow(0.13 * std::sin(p.theta) / 0.05, -0.4);
  expect_same(p, plain(t), 1e-5);
}

TEST(Fingerprint, ShearRateScalesTheShearOfALockedWheelNotAtAllAndOfASpinningOneByItsSpeed) {
  Setting s, t;  // near full slip every point slides at the rim's speed: tau (1 + zeta ln(v/v0))
  s.slip = t.slip = 0.999, s.rim = t.rim = 0.05;
  const double factor = 1 + 0.04 * std::log(0.05 / 0.01);
  t.c = s.c * factor, t.phi = std::atan(std::tan(s.phi) * factor);
  expect_same(with(s, Effect::shear_rate, 0.04), plain(t), 2e-4);
}

TEST(Fingerprint, PressureRateStiffensTheFasterWheel) {
  Setting slow, fast;
  slow.rim = 0.01, fast.rim = 0.5;
  EXPECT_LT(with(fast, Effect::pressure_rate, 0.1).z, with(slow, Effect::pressure_rate, 0.1).z);
  EXPECT_EQ(plain(fast).z, plain(slow).z);
}

TEST(Fingerprint, AHardPanStopsTheWheelAboveIt) {
  Setting s;
  s.load = 400;
  EXPECT_GT(plain(s).z, 0.03);
  EXPECT_LT(with(s, Effect::hard_pan, 1 / 0.03).z, 0.03);
  s.load = 1;  // far above it nothing is felt: sigma grows by z/H
  EXPECT_NEAR(with(s, Effect::hard_pan, 1 / 0.3).z, plain(s).z, 0.01 * plain(s).z);
}

TEST(Fingerprint, ResidualShearRaisesThePeakByItsShare) {
  Setting s, t;  // with paths far below Kw and far above K the whole arc is at the peak
  s.K = t.K = 1e-6, s.slip = t.slip = 0.02, s.load = t.load = 5, s.a0 = t.a0 = 0.3;
  t.c = 1.3 * s.c, t.phi = std::atan(1.3 * std::tan(s.phi));
  const Outcome a = with(s, Effect::residual_shear, 0.3), b = plain(t);
  EXPECT_LT(a.T, b.T);
  EXPECT_GT(a.T, 0.9 * b.T);
}

TEST(Fingerprint, ExitAngleLengthensTheContactAndLiftsTheWheel) {
  const Setting s;
  EXPECT_LT(with(s, Effect::exit_angle, 0.3).z, plain(s).z);
  EXPECT_GT(with(s, Effect::exit_angle, 0.3).T, plain(s).T);
}

TEST(Fingerprint, AFlexibleWheelIsALargerOneThatTravelsAsTheSmallOneDoes) {
  Setting s, t;
  const double grow = 1 + 0.1 * 115 / 100;
  t.radius = s.radius * grow;
  t.slip = 1 - (1 - s.slip) / grow;  // the same v/w
  t.rim = s.rim * grow;
  t.a0 = s.a0 + s.a1 * (s.slip - t.slip);  // theta_m goes by the slip as stated
  expect_same(with(s, Effect::flexible_wheel, 0.1), plain(t));
}

TEST(Fingerprint, LugsShearFurtherOutAndWithALongerLever) {
  Setting s;
  s.slip = 0.5;  // shear is complete: the torque grows with the square of the lever, the sinkage barely moves
  const Outcome p = plain(s), l = with(s, Effect::lugs, 0.01);
  EXPECT_NEAR(l.T / p.T, std::pow(0.135 / 0.13, 2), 0.03);
  EXPECT_GT(l.F, p.F);
}

}  // namespace
}  // namespace grouser::bekker
