#include "grouser/diagnosis/wheel_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "synthetic.h"

namespace grouser::diagnosis {
namespace {

using namespace grouser::test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const bekker::WheelSize mit{0.13, 0.16, 0, 0};

/// Table 4.8, the soil that the dissertation fitted to DEM wheel runs, with a1 = 0.60 in place of 0.90 so that the bound is far.
BekkerSoil table_4_8() {
  BekkerSoil s;
  s.pressure = {PressureSinkage::Law::k_b, 0, 0, 2.305e4, 0.418, 0.05};
  s.shear.cohesion = 96.24;
  s.shear.friction_angle = 0.606;
  s.shear.K = 4.534e-3;
  s.angles = {0.09, 0.60, 0, 0};
  return s;
}

/// Eqs 2.4 to 2.11 (beta = 0, theta_r = 0) by the midpoint rule, written out here on their own: {Fx, Fz, torque}.
std::array<double, 3> midpoint_forces(const BekkerSoil& soil, double s, double theta_f) {
  const double r = mit.radius, b = mit.width,
               modulus = soil.pressure.k / std::pow(soil.pressure.reference_width, soil.pressure.n);
  const double theta_m = (soil.angles.a0 + soil.angles.a1 * std::abs(s)) * theta_f,
               kappa = s >= 0 ? 1 - s : 1 / (1 + s);
  const int n = 1500;
  std::array<double, 3> out{};
  for (int i = 0; i < n; ++i) {
    // theta_f - theta = theta_f x^2 gathers the points at the entry, where the pressure starts as a power.
    const double x = (i + 0.5) / n, theta = theta_f * (1 - x * x), weight = 2 * theta_f * x / n;
    const double front = theta > theta_m ? theta : theta_f - theta * (theta_f - theta_m) / theta_m;
    const double sigma = modulus * std::pow(r * (std::cos(front) - std::cos(theta_f)), soil.pressure.n);
    const double j = r * ((theta_f - theta) - kappa * (std::sin(theta_f) - std::sin(theta)));
    const double top = soil.shear.cohesion + sigma * std::tan(soil.shear.friction_angle);
    const double tau = top * (1 - std::exp(-std::abs(j) / soil.shear.K)) * (1 - kappa * std::cos(theta) < 0 ? -1 : 1);
    out[0] += r * b * weight * (tau * std::cos(theta) - sigma * std::sin(theta));
    out[1] += r * b * weight * (tau * std::sin(theta) + sigma * std::cos(theta));
    out[2] += r * r * b * weight * tau;
  }
  return out;
}

WheelPoint midpoint_wheel(const BekkerSoil& soil, double load, double s) {
  double low = 1e-3, high = 1.5;
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    (midpoint_forces(soil, s, middle)[1] < load ? low : high) = middle;
  }
  const auto f = midpoint_forces(soil, s, low);
  WheelPoint p;
  p.slip = p.stated_slip = s;
  p.load = load;
  p.value = {f[0], f[2], mit.radius * (1 - std::cos(low)), nan};
  p.error = {2, 0.2, 1e-3, nan};
  return p;
}

/// 27 conditions; noise in units of the stated errors.
std::vector<WheelPoint> synthetic_wheel(double noise, unsigned seed) {
  static const std::vector<WheelPoint> clean = [] {
    std::vector<WheelPoint> out;
    for (const double load : {60.0, 115.0, 170.0})
      for (const double s : {-0.5, -0.2, -0.05, 0.0, 0.05, 0.1, 0.3, 0.5, 0.7})
        out.push_back(midpoint_wheel(table_4_8(), load, s));
    return out;
  }();
  Noise n(seed);
  std::vector<WheelPoint> out = clean;
  for (WheelPoint& p : out)
    for (std::size_t c = 0; c < 3; ++c) p.value[c] += n(noise * p.error[c]);
  return out;
}

std::vector<WheelVariable> all_variables() {
  return {{"k", 1e3, 1e7, {}},   {"n", 0.2, 2, {}},  {"friction_angle", 0.1, 0.9, {}},
          {"K", 1e-4, 5e-2, {}}, {"a0", 0, 0.8, {}}, {"a1", 0, 0.95, {}}};
}

/// Somewhere else to start from.
BekkerSoil far_start() {
  BekkerSoil s;
  s.pressure = {PressureSinkage::Law::k_b, 0, 0, 1e5, 0.8, 0.05};
  s.shear = {ShearLaw::Type::A, 96.24, 0.5, 2e-3, 0, 1};
  return s;
}

TEST(WheelFit, RecoversTheSoilFromItsWheelResults) {
  const WheelFit f = fit_wheel(mit, far_start(), synthetic_wheel(0, 1), all_variables(), bekker::Method::nonlinear,
                               ErrorModel::scaled, 3);
  ASSERT_TRUE(f.fit.converged) << f.fit.message;
  // The midpoint rule is good to about 1e-5 of the force.
  EXPECT_NEAR(f.fit.at("k").value, 2.305e4, 50);
  EXPECT_NEAR(f.fit.at("n").value, 0.418, 1e-3);
  EXPECT_NEAR(f.fit.at("friction_angle").value, 0.606, 1e-4);
  EXPECT_NEAR(f.fit.at("K").value, 4.534e-3, 1e-5);
  EXPECT_NEAR(f.fit.at("a0").value, 0.09, 1e-3);
  EXPECT_NEAR(f.fit.at("a1").value, 0.60, 1e-3);
}

// Linearised intervals of a fit that is far from linear (a sharp turn at slip 0, a0 near its bound, where no interval is given) hold less
// often than they say: 211 of 240 in 40 sets (88 %, nominal 95 %). Twenty sets here; below 80 % something is broken.
TEST(WheelFit, IntervalsHoldTheTruthInNearlyNineOfTenCasesUnderTheStatedNoise) {
  int held = 0;
  const std::vector<double> truth{2.305e4, 0.418, 0.606, 4.534e-3, 0.09, 0.60};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const WheelFit f = fit_wheel(mit, table_4_8(), synthetic_wheel(1, seed), all_variables(), bekker::Method::nonlinear,
                                 ErrorModel::stated, 1);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Estimate& e = f.fit.estimates[i];
      held += e.lower <= truth[i] && truth[i] <= e.upper;
    }
  }
  RecordProperty("held", held);
  EXPECT_GE(held, 96);
}

TEST(WheelFit, ConvertsSlipByDefinitionAndRadius) {
  // w = 1 rad/s, r = 0.1 m, v = 0.15 m/s: rim -0.5, symmetric -1/3; by R = 0.12 m the slip is (0.12 - 0.15)/0.15.
  EXPECT_NEAR(slip_at_radius(-0.5, true, 0.1, 0.1), -1.0 / 3, 1e-15);
  EXPECT_NEAR(slip_at_radius(-0.5, true, 0.1, 0.12), -0.2, 1e-15);
  EXPECT_NEAR(slip_at_radius(-1.0 / 3, false, 0.1, 0.12), -0.2, 1e-15);
  EXPECT_NEAR(slip_at_radius(0.2, false, 0.1, 0.1), 0.2, 1e-15);
  EXPECT_EQ(slip_at_radius(-1, false, 0.1, 0.12), -1);
}

TEST(WheelFit, ScatterIsThePooledDeviationBetweenRepeats) {
  std::vector<WheelPoint> p(4);
  std::vector<std::array<double, wheel_channels>> model(4, {10, nan, nan, nan});
  const double drawbar[] = {1, 3, 10, 14};
  for (std::size_t i = 0; i < 4; ++i) {
    p[i].value = {drawbar[i], nan, nan, nan};
    p[i].error = {1, nan, nan, nan};
    p[i].condition = i < 2 ? "a" : "b";
  }
  const auto e = channel_errors(p, model);
  ASSERT_EQ(e.size(), 1u);
  EXPECT_NEAR(e[0].scatter, std::sqrt((2 + 8) / 2.0), 1e-12);
  EXPECT_NEAR(e[0].bias, 3, 1e-12);
  EXPECT_NEAR(e[0].rmse, std::sqrt((81 + 49 + 0 + 16) / 4.0), 1e-12);
}

TEST(WheelFit, NamesThePointThatTheStartCannotCarry) {
  std::vector<WheelPoint> p = synthetic_wheel(0, 1);
  p[3].load = 1e6;
  EXPECT_THROW(
      {
        try {
          fit_wheel(mit, table_4_8(), p, all_variables(), bekker::Method::nonlinear, ErrorModel::scaled, 1);
        } catch (const std::invalid_argument& e) {
          EXPECT_NE(std::string(e.what()).find("at 1000000.0"), std::string::npos) << e.what();
          throw;
        }
      },
      std::invalid_argument);
}

}  // namespace
}  // namespace grouser::diagnosis
