// Each effect in the limits where it is something else that is known.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "wheel.h"

namespace blind {
namespace {

const Wheel wheel;
const Soil soil;

Channels with(Id id, double x, const Condition& run, const Soil& s = soil) {
  Amplitudes a;
  a[id] = x;
  return simulate(wheel, s, a, run);
}
Channels plain(const Condition& run, const Soil& s = soil) { return simulate(wheel, s, {}, run); }

// Both loads are balanced to 1e-11, so equal physics agrees to rounding of the root.
void expect_same(const Channels& a, const Channels& b, double share = 1e-8) {
  EXPECT_NEAR(a.drawbar, b.drawbar, share * 100);
  EXPECT_NEAR(a.torque, b.torque, share * 10);
  EXPECT_NEAR(a.sinkage, b.sinkage, share * 0.03);
}
void expect_change(const Channels& a, const Channels& b, double drawbar, double torque, double sinkage_change) {
  EXPECT_NEAR(a.drawbar - b.drawbar, drawbar, 1e-8);
  EXPECT_NEAR(a.torque - b.torque, torque, 1e-8);
  EXPECT_NEAR(a.sinkage - b.sinkage, sinkage_change, 1e-10);
}
Soil changed(double Soil::*what, double value) {
  Soil s = soil;
  s.*what = value;
  return s;
}

TEST(BlindEffects, AreInTheOrderOfTheirIdsAndNamedOnce) {
  std::set<std::string_view> names;
  for (int i = 0; i < kEffects; ++i) {
    EXPECT_EQ(static_cast<int>(effects()[static_cast<std::size_t>(i)].id), i);
    names.insert(effects()[static_cast<std::size_t>(i)].name);
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kEffects));
  EXPECT_THROW(effect("sinkage_slip"), std::invalid_argument);
}

TEST(BlindEffects, EachChangesSomethingSomewhere) {
  for (const Effect& e : effects()) {
    double moved = 0;
    for (const double slip : {-0.3, 0.3}) {
      const Condition run{slip, 170, 0.9, 2, 0.7};
      const Channels a = with(e.id, (e.signs < 0 ? -0.5 : 0.5) * e.typical, run), b = plain(run);
      moved = std::max({moved, std::abs(a.drawbar - b.drawbar), std::abs(a.torque - b.torque),
                        100 * std::abs(a.sinkage - b.sinkage)});
    }
    EXPECT_GT(moved, 1e-3) << e.name;
  }
}

TEST(BlindEffects, SlipSinkageIsAnotherExponentOrAnotherModulusAtThatSlip) {
  for (const double slip : {-0.4, 0.0, 0.4}) {
    const Condition run{slip, 115};
    expect_same(with(Id::slip_sinkage_exponent, 0.5, run),
                plain(run, changed(&Soil::n, soil.n + 0.5 * std::abs(slip))));
    const double K = (1 + std::abs(slip)) / (1 - 0.5 * std::abs(slip));
    expect_same(with(Id::slip_sinkage_factor, 0.4, run),
                plain(run, changed(&Soil::k, soil.k * std::pow(K, -0.4 * soil.n))));
  }
}

TEST(BlindEffects, DiggingSinksWithoutBearing) {
  expect_change(with(Id::slip_digging, 0.004, {0.5, 115}), plain({0.5, 115}), 0, 0, 0.004);
  expect_change(with(Id::slip_digging, 0.004, {-0.5, 115}), plain({-0.5, 115}), 0, 0, 0);
}

TEST(BlindEffects, PressureRateIsAModulusWhenAllSpeedsAreScaled) {
  // Where the floor of the normal speed holds, at the lowest point, the scaling fails: 2e-4 of the load's balance.
  const double m = 0.1;
  const Condition slow{0.3, 115, 0.45}, quick{0.3, 115, 0.9};
  Amplitudes a;
  a[Id::pressure_rate] = m;
  expect_same(simulate(wheel, soil, a, quick), simulate(wheel, changed(&Soil::k, soil.k * std::pow(2.0, m)), a, slow),
              2e-3);
}

TEST(BlindEffects, ShearRateOfASpinningWheelIsOneFactor) {
  const Condition spinning{1.0, 115, 0.3};
  const double factor = 1 + 0.05 * std::log(0.13 * 0.3 / 0.01);
  Soil scaled = changed(&Soil::phi, std::atan(std::tan(soil.phi) * factor));
  scaled.c *= factor;
  expect_same(with(Id::shear_rate, 0.05, spinning), plain(spinning, scaled));
}

TEST(BlindEffects, PassEffectsActOnTheSecondPassOnly) {
  for (const Id id : {Id::repetitive_loading, Id::pass_strength})
    expect_same(with(id, 0.2, {0.3, 115, 0.3, 1}), plain({0.3, 115, 0.3, 1}));
  const Condition second{0.3, 115, 0.3, 2};
  expect_same(with(Id::repetitive_loading, 0.8, second), plain(second, changed(&Soil::k, 1.8 * soil.k)));
  expect_same(with(Id::pass_strength, 0.1, second),
              plain(second, changed(&Soil::phi, std::atan(1.1 * std::tan(soil.phi)))));
}

TEST(BlindEffects, InterfaceFrictionIsAParameterShift) {
  const Condition run{0.3, 115};
  expect_same(with(Id::interface_friction, -0.2, run),
              plain(run, changed(&Soil::phi, std::atan(0.8 * std::tan(soil.phi)))));
}

TEST(BlindEffects, AddedDragIsTheFormulaAtTheSinkage) {
  Soil sand = changed(&Soil::c, 0.0);
  const Condition run{0.3, 115};
  const Channels bare = plain(run, sand);
  const double z = bare.sinkage, sine = std::sin(sand.phi),
               Kp = (1 + sine) / (1 - sine);  // Rankine's passive coefficient
  expect_change(with(Id::bulldozing, 1.5, run, sand), bare, -1.5 * 0.16 * 0.5 * 1600 * 9.81 * z * z * Kp, 0, 0);
  const double chord = 2 * std::sqrt(0.13 * 0.13 - (0.13 - z) * (0.13 - z));
  const double area = 0.13 * 0.13 * std::acos(1 - z / 0.13) - 0.5 * chord * (0.13 - z);  // segment of a disc
  expect_change(with(Id::side_wall, 2, run, sand), bare, -2 * area * (1 - sine) * 1600 * 9.81 * z * std::tan(sand.phi),
                0, 0);
}

TEST(BlindEffects, LugsOnClayTurnByALongerLever) {
  // Spinning on soil with little but cohesion, all of it mobilised.
  Stress s;
  s.k = 1e-9;
  s.c = 500;
  s.K = 1e-8;
  s.travel = 0;
  Stress lugged = s;
  lugged.lever = s.radius + 0.5 * 0.01;
  EXPECT_NEAR(arc_sums(lugged, 0.5).torque / arc_sums(s, 0.5).torque, (0.135 / 0.13) * (0.135 / 0.13),
              1e-7);  // the layer is 1e-8 of the arc
  const Condition spinning{1.0, 115};
  EXPECT_GT(with(Id::lugs, 0.01, spinning).torque, 1.03 * plain(spinning).torque);
}

TEST(BlindEffects, AFlexibleWheelSpinningIsALargerOne) {
  const Condition spinning{1.0, 200};
  Wheel larger = wheel;
  larger.radius *= 1.1;
  expect_same(with(Id::flexible_wheel, 0.05, spinning), simulate(larger, soil, {}, spinning));
}

TEST(BlindEffects, APanHoldsTheWheelAboveIt) {
  const Condition heavy{0.3, 225};
  EXPECT_LT(with(Id::hard_pan, 40.0, heavy).sinkage, 1 / 40.0);
  EXPECT_GT(plain(heavy).sinkage, 1 / 40.0);
  expect_same(with(Id::hard_pan, 1e-9, heavy), plain(heavy));
}

TEST(BlindEffects, CurvatureIsALinearLawAtOneSlip) {
  expect_same(with(Id::contact_angle_curvature, 0.2, {0.5, 115}),
              plain({0.5, 115}, changed(&Soil::a1, soil.a1 + 0.2 * 0.5)));
  expect_same(with(Id::contact_angle_curvature, 0.2, {-0.5, 115}),
              plain({-0.5, 115}, changed(&Soil::a1, soil.a1 - 0.2 * 0.5)));
}

TEST(BlindEffects, CovariatesAreOtherParametersOfThatRun) {
  expect_same(with(Id::shear_modulus_load, 0.5, {0.1, 200}),
              plain({0.1, 200}, changed(&Soil::K, soil.K * std::sqrt(2.0))));
  expect_same(with(Id::shear_modulus_load, 0.5, {0.1, 100}), plain({0.1, 100}));
  expect_same(with(Id::preparation_drift, -0.2, {0.1, 115, 0.3, 1, 0.5}),
              plain({0.1, 115}, changed(&Soil::k, 0.9 * soil.k)));
  const Condition run{0.2, 115};
  Amplitudes a;
  a[Id::plate_size] = 0.3;
  const double entry = entry_angle(wheel, soil, a, run);
  const Soil scaled = changed(&Soil::k, soil.k * std::pow(0.13 * std::sin(entry) / 0.05, -0.3));
  EXPECT_NEAR(entry, entry_angle(wheel, scaled, {}, run), 1e-9);
}

TEST(BlindEffects, SensorsChangeOnlyTheirChannel) {
  const Condition run{0.3, 115, 0.9};
  const Channels y = plain(run);
  expect_change(with(Id::torque_offset, -0.3, run), y, 0, -0.3, 0);
  expect_change(with(Id::torque_viscous, 0.4, run), y, 0, 0.36, 0);
  expect_change(with(Id::torque_bearing, 0.002, run), y, 0, 0.23, 0);
  expect_change(with(Id::drawbar_bias, 2, run), y, 2, 0, 0);
  expect_change(with(Id::bed_slope, 0.02, run), y, -115 * std::tan(0.02), 0, 0);
  expect_change(with(Id::sinkage_datum, -0.001, run), y, 0, 0, -0.001);
  expect_change(with(Id::rig_compliance, 1e-5, run), y, 0, 0, 1.15e-3);
  expect_change(with(Id::drawbar_gain, 0.05, run), y, 0.05 * y.drawbar, 0, 0);
  expect_change(with(Id::torque_gain, 0.05, run), y, 0, 0.05 * y.torque, 0);
  expect_same(with(Id::load_error, 0.1, run), plain({0.3, 126.5, 0.9}));
  expect_same(with(Id::wheel_radius_error, 0.1, run), plain({1 - 0.7 * 1.1, 115, 0.9}));
  expect_same(with(Id::wheel_radius_error, 0.1, {-0.5, 115}), plain({1 / 2.2 - 1, 115}));
}

TEST(BlindEffects, OutsideTheLibraryAreWhatTheySay) {
  const Condition run{0.3, 100, 0.2};
  expect_same(with(Id::load_cohesion, 300, run), plain(run, changed(&Soil::c, soil.c + 300)));
  expect_same(with(Id::dilatancy_peak, 0.1, run), plain(run, changed(&Soil::phi, std::atan(1.1 * std::tan(soil.phi)))));
  expect_change(with(Id::dwell_creep, 0.003, run), plain(run), 0, 0, 0.003 * std::exp(-1.0));
  expect_same(with(Id::settling_exponent, 0.5, {0.3, 115, 1e-9}), plain({0.3, 115, 1e-9}));
  const double full = (1 - std::exp(-0.13 * 0.9 / 0.04)) * (1 - std::exp(-2.25));
  expect_same(with(Id::settling_exponent, 0.5, {0.3, 225, 0.9}),
              plain({0.3, 225, 0.9}, changed(&Soil::n, soil.n + 0.5 * full)));
  Condition early = run, late = run;
  late.order_share = 1.0 / 7.0;  // half a period on
  const double a = with(Id::tidal_thrust, 2, early).drawbar - plain(early).drawbar,
               b = with(Id::tidal_thrust, 2, late).drawbar - plain(late).drawbar;
  EXPECT_NEAR(a, -b, 1e-9);
  EXPECT_NEAR(a, 2 * std::sin(0.6), 1e-9);
}

TEST(BlindEffects, ReportedValuesReturn) {
  EXPECT_DOUBLE_EQ(reported(Id::interface_friction, -0.25), 0.75);
  EXPECT_DOUBLE_EQ(from_reported(Id::interface_friction, 0.75, "1"), -0.25);
  EXPECT_DOUBLE_EQ(from_reported(Id::hard_pan, 0.2, "m"), 5.0);
  EXPECT_DOUBLE_EQ(from_reported(Id::hard_pan, 5.0, "1/m"), 5.0);
  EXPECT_NEAR(from_reported(Id::bed_slope, 180, "deg"), 3.14159265, 1e-8);
}

}  // namespace
}  // namespace blind
