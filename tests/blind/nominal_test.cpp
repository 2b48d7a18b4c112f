// The generator's wheel against closed forms, published figures and another rule.
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "wheel.h"

namespace blind {
namespace {

Stress mojave(double slip, double entry_share = 0) {
  Stress s;
  s.k = 254.1e3;
  s.n = 1.387;
  s.c = 139.28;
  s.tan_phi = std::tan(0.606);
  s.K = 0.5151e-3;
  s.mid_share = 0.18 + 0.32 * std::abs(slip);
  s.rear_share = entry_share;
  s.travel = 0.13 * speed_ratio(slip);
  return s;
}

// Eq 2.11 as printed in the textbook, point by point, adaptive Gauss-Kronrod between every place where the integrand
// can bend.
Sums by_the_book(const Stress& s, double entry) {
  const double mid = s.mid_share * entry, rear = -s.rear_share * entry, r = s.radius, R = s.lever;
  const auto sigma = [&](double t) {
    const double e = t >= mid ? t : entry - (t - rear) * (entry - mid) / (mid - rear);
    const double z = r * (std::cos(e) - std::cos(entry));
    double p = s.k * std::pow(std::max(z, 0.0) / s.reference_width, s.n) / (1 - z * s.inverse_pan_depth);
    if (s.pressure_rate != 0) p *= std::pow(std::max(s.travel * s.omega * std::sin(t), 0.001) / 0.01, s.pressure_rate);
    return p;
  };
  const auto tau = [&](double t) {
    const double j = R * (entry - t) - s.travel * (std::sin(entry) - std::sin(t));
    const double v = s.omega * (R - s.travel * std::cos(t));
    double out = (s.c + sigma(t) * s.tan_phi) * (1 - std::exp(-std::abs(j) / s.K)) *
                 (1 + s.residual * std::exp(-std::abs(j) / 0.01));
    if (s.shear_rate != 0) out *= 1 + s.shear_rate * std::log(std::max(std::abs(v), 0.001) / 0.01);
    return v < 0 ? -out : out;
  };
  const int slices = 400;
  Sums out;
  const auto add = [&](double from, double to) {
    for (int i = 0; i < slices; ++i) {
      // Slices grow from both ends, where layers are.
      const auto place = [&](double u) { return from + (to - from) * u * u * (3 - 2 * u); };
      const double a = place(static_cast<double>(i) / slices), b = place((i + 1.0) / slices);
      using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
      out.fx +=
          s.width * Rule::integrate([&](double t) { return R * tau(t) * std::cos(t) - r * sigma(t) * std::sin(t); }, a,
                                    b, 2, 1e-11);
      out.fz +=
          s.width * Rule::integrate([&](double t) { return r * sigma(t) * std::cos(t) + R * tau(t) * std::sin(t); }, a,
                                    b, 2, 1e-11);
      out.torque += s.width * R * R * Rule::integrate([&](double t) { return tau(t); }, a, b, 2, 1e-11);
    }
  };
  double cut = mid;
  if (s.travel > R) cut = std::min(std::max(std::acos(R / s.travel), rear), entry);
  add(rear, std::min(mid, cut));
  add(std::min(mid, cut), std::max(mid, cut));
  add(std::max(mid, cut), entry);
  return out;
}

void expect_close(const Sums& a, const Sums& b, double share) {
  const double force = std::hypot(b.fx, b.fz);
  EXPECT_NEAR(a.fx, b.fx, share * force);
  EXPECT_NEAR(a.fz, b.fz, share * force);
  EXPECT_NEAR(a.torque, b.torque, share * 0.13 * force);
}

TEST(BlindWheel, AgreesWithAdaptiveQuadratureOfTheTextbookEquations) {
  // 1e-6 of the force is 1e-4 N, a 20,000th of the noise; the 1200 slices do not know where j changes sign.
  for (const double slip : {-0.7, -0.3, -0.1, 0.0, 0.1, 0.3, 0.7})
    for (const double entry : {0.25, 0.6, 0.9})
      expect_close(arc_sums(mojave(slip), entry), by_the_book(mojave(slip), entry), 1e-6);
}

TEST(BlindWheel, AgreesWithItWithEveryStressEffectOn) {
  for (const double slip : {-0.5, 0.0, 0.4}) {
    Stress s = mojave(slip, 0.3);
    s.residual = 0.3;
    s.inverse_pan_depth = 5;
    s.lever = 0.134;
    s.pressure_rate = 0.1;
    s.shear_rate = 0.04;
    s.omega = 0.9;
    // Kinks of the rate laws lie inside slices of the reference.
    expect_close(arc_sums(s, 0.55), by_the_book(s, 0.55), 5e-6);
  }
}

TEST(BlindWheel, SinksAsPublishedAtZeroSlip) {
  // Table 4.1 and 4.6, 115 N: 21.9 mm with the wheel's width as reference, 9.6 mm with the plate's 0.05 m.
  const Wheel wheel;
  EXPECT_NEAR(simulate(wheel, Soil{}, {}, {0.0, 115}).sinkage, 21.9e-3, 0.05e-3);
  Soil plate;
  plate.k *= std::pow(0.16 / 0.05, plate.n);
  EXPECT_NEAR(simulate(wheel, plate, {}, {0.0, 115}).sinkage, 9.6e-3, 0.05e-3);
}

TEST(BlindWheel, IsTheClosedFormOnAFrictionlessLinearSoil) {
  // n = 1, theta_m = theta_f/2, theta_r = 0: the pressure is mirrored about theta_m.
  Stress s;
  s.k = 1e5;
  s.n = 1;
  s.mid_share = 0.5;
  const double f = 0.7, h = f / 2, cf = std::cos(f), q = s.k * 0.13 / 0.16 * 0.13 * 0.16;
  const double front = 0.5 * (f - h) + 0.25 * (std::sin(2 * f) - std::sin(2 * h)) - cf * (std::sin(f) - std::sin(h));
  // Behind theta_m: integral of (cos(f - t) - cos f) cos t over 0..f/2.
  const double behind = 0.5 * cf * h + 0.25 * (std::sin(f) - std::sin(f - 2 * h)) - cf * std::sin(h);
  const double front_x = 0.25 * (std::cos(2 * h) - std::cos(2 * f)) - cf * (std::cos(h) - std::cos(f));
  const double behind_x = 0.25 * (std::cos(f) - std::cos(2 * h - f)) + 0.5 * h * std::sin(f) - cf * (1 - std::cos(h));
  const Sums sums = arc_sums(s, f);
  EXPECT_NEAR(sums.fz, q * (front + behind), 1e-9 * q);
  EXPECT_NEAR(sums.fx, -q * (front_x + behind_x), 1e-9 * q);
  EXPECT_EQ(sums.torque, 0.0);
}

TEST(BlindWheel, IsTheClosedFormOnAWeightlessClay) {
  // Only cohesion. Spinning (v = 0): j = r (theta_f - theta).
  Stress s;
  s.k = 1e-9;
  s.c = 1000;
  s.travel = 0;
  const double f = 0.8, r = 0.13, b = 0.16;
  for (const double K : {1e-6, 1e-3, 0.05}) {
    s.K = K;
    const Sums sums = arc_sums(s, f);
    EXPECT_NEAR(sums.torque, r * r * b * 1000 * (f - K / r * (1 - std::exp(-r * f / K))), 1e-7);
  }
  s.K = 1e-7;
  s.residual = 0.4;
  const Sums peak = arc_sums(s, f);
  EXPECT_NEAR(peak.torque, r * r * b * 1000 * (f + 0.4 * 0.01 / r * (1 - std::exp(-r * f / 0.01))), 1e-5);
  s.residual = 0;
  s.rear_share = 0.25;
  s.lever = 0.14;
  const Sums wide = arc_sums(s, f);  // all mobilised over 1.25 theta_f
  EXPECT_NEAR(wide.torque, 0.14 * 0.14 * b * 1000 * 1.25 * f, 1e-5);
  EXPECT_NEAR(wide.fx, 0.14 * b * 1000 * (std::sin(f) + std::sin(0.25 * f)), 1e-4);
  EXPECT_NEAR(wide.fz, 0.14 * b * 1000 * (std::cos(0.25 * f) - std::cos(f)), 1e-4);
}

TEST(BlindWheel, CoarseSchemeComesCloserWithTheSquareOfItsCells) {
  const Stress s = mojave(0.5);
  const Sums exact = arc_sums(s, 0.6), hundred = arc_sums(s, 0.6, 100), four_hundred = arc_sums(s, 0.6, 400);
  // The shear layer of half a millimetre holds only a few cells: second order in sight, not reached.
  EXPECT_GT(std::abs(hundred.torque - exact.torque), 4 * std::abs(four_hundred.torque - exact.torque));
  EXPECT_NEAR(hundred.fz, exact.fz, 1e-3 * exact.fz);
}

TEST(BlindWheel, CarriesItsLoad) {
  const Wheel wheel;
  for (const double slip : {-0.7, 0.0, 0.7})
    for (const double load : {60.0, 225.0}) {
      const Condition run{slip, load};
      EXPECT_NEAR(at_entry(wheel, Soil{}, {}, run, entry_angle(wheel, Soil{}, {}, run)).excess, 0.0, 1e-7);
    }
}

TEST(BlindWheel, RefusesALoadThatNoSinkageCarries) {
  Soil mud;
  mud.k = 100;
  mud.phi = 0.05;
  EXPECT_THROW(simulate(Wheel{}, mud, {}, {0.3, 225}), std::runtime_error);
}

}  // namespace
}  // namespace blind
