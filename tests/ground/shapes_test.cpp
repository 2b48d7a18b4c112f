// Flat, slope, step, sinusoid and sums against closed forms.
#include <numbers>

#include "grouser/terrain/ground_sinusoid.h"
#include "grouser/terrain/ground_slope.h"
#include "grouser/terrain/ground_step.h"
#include "grouser/terrain/ground_sum.h"
#include "helpers.h"

namespace grouser {
namespace {

using ground_test::expect_normal_is_gradient;
constexpr double deg = std::numbers::pi / 180;

TEST(Flat, IsFlatAtItsHeight) {
  const GroundPtr g = flat_ground(0.25);
  EXPECT_EQ(g->height(-3, 17), 0.25);
  EXPECT_EQ(g->normal(1, 2), Vec3::UnitZ());
  EXPECT_TRUE(std::isinf(g->resolution()));
}

TEST(Slope, RisesByTheTangentAndLeansByTheAngle) {
  SlopeSettings p;
  p.angle = 30 * deg;
  p.frame.start = 2;
  const GroundPtr g = slope_ground(p);
  EXPECT_EQ(g->height(1.9, 5), 0);
  EXPECT_NEAR(g->height(5, -1), 3 / std::sqrt(3.0), 1e-14);
  // n = (-sin 30, 0, cos 30).
  EXPECT_NEAR((g->normal(5, 0) - Vec3(-0.5, 0, std::sqrt(0.75))).norm(), 0, 1e-15);
  EXPECT_EQ(g->normal(1, 0), Vec3::UnitZ());
}

TEST(Slope, TurnsWithItsHeading) {
  SlopeSettings p;
  p.angle = 45 * deg;
  p.frame.heading = 90 * deg;
  p.frame.start = 1;
  const GroundPtr g = slope_ground(p);
  EXPECT_NEAR(g->height(100, 3), 2, 1e-13);
  EXPECT_NEAR((g->normal(7, 3) - Vec3(0, -1, 1).normalized()).norm(), 0, 1e-14);
}

TEST(Slope, TransitionHasNoCrease) {
  SlopeSettings p;
  p.angle = 20 * deg;
  p.transition = 0.5;
  const GroundPtr g = slope_ground(p);
  for (double x : {-0.1, 0.1, 0.3, 0.49, 0.51, 2.0}) expect_normal_is_gradient(*g, x, 0.3, 1e-8);
  // At both ends of the transition height and gradient meet.
  for (double x : {0.0, 0.5}) {
    EXPECT_NEAR(g->height(x - 1e-9, 0), g->height(x + 1e-9, 0), 1e-9);
    EXPECT_NEAR((g->normal(x - 1e-9, 0) - g->normal(x + 1e-9, 0)).norm(), 0, 1e-8);
  }
}

TEST(Step, HasItsHeightBehindItsRamp) {
  StepSettings p;
  p.height = -0.05;
  p.ramp = 0.02;
  p.frame.start = 1;
  const GroundPtr g = step_ground(p);
  EXPECT_EQ(g->height(1, 0), 0);
  EXPECT_NEAR(g->height(1.01, 0), -0.025, 1e-14);
  EXPECT_EQ(g->height(1.03, 9), -0.05);
  expect_normal_is_gradient(*g, 1.005, 0, 1e-8);
  EXPECT_EQ(g->normal(1.5, 0), Vec3::UnitZ());
}

TEST(Step, WithoutRampIsVerticalAndItsNormalUpright) {
  StepSettings p;
  p.height = 0.1;
  const GroundPtr g = step_ground(p);
  EXPECT_EQ(g->height(-1e-12, 0), 0);
  EXPECT_EQ(g->height(0, 0), 0.1);
  EXPECT_EQ(g->normal(0, 0), Vec3::UnitZ());
}

TEST(Sinusoid, PeriodsOfTable36FollowFromRadPerMetre) {
  // 300, 150, 100 and 75 % of the MER wheel's 0.13 m maximum radius (ERRATA: the printed frequency is in rad/m). The
  // printed wavenumbers have
  // three digits, so the periods hold to 0.1 %.
  const double wavenumber[] = {16.1, 32.2, 48.3, 64.4}, period[] = {0.390, 0.195, 0.130, 0.0975};
  for (int i = 0; i < 4; ++i) {
    SinusoidSettings p;
    p.amplitude = 0.00975;
    p.wavenumber = wavenumber[i];
    const GroundPtr g = sinusoid_ground(p);
    // Period found from the zero crossings: bisection around the expected one.
    double lo = 0.75 * period[i], hi = 1.25 * period[i];
    for (int k = 0; k < 60; ++k) {
      const double mid = 0.5 * (lo + hi);
      (g->height(mid, 0) < 0 ? lo : hi) = mid;
    }
    EXPECT_NEAR(lo, period[i], 1.1e-3 * period[i]);
    EXPECT_NEAR(g->height(period[i] / 4, 2), 0.00975, 1e-5 * 0.00975);
  }
}

TEST(Sinusoid, NormalIsItsGradientAlsoInTheRunIn) {
  SinusoidSettings p;
  p.amplitude = 0.02;
  p.wavenumber = 20;
  p.phase = 0.7;
  p.run_in = 0.5;
  p.bounded_start = true;
  p.length = 3;
  p.frame = {30 * deg, 0.2, 0};
  const GroundPtr g = sinusoid_ground(p);
  for (double x = -0.5; x < 4.5; x += 0.0137) expect_normal_is_gradient(*g, x, 0.4, 1e-7);
}

TEST(Sinusoid, IsFlatOutsideAndSmoothAtItsEnds) {
  SinusoidSettings p;
  p.amplitude = 0.02;
  p.wavenumber = 20;
  p.phase = 1.0;
  p.run_in = 0.5;
  p.bounded_start = true;
  p.length = 3;
  p.frame.start = 1;
  const GroundPtr g = sinusoid_ground(p);
  EXPECT_EQ(g->height(0.999, 0), 0);
  EXPECT_EQ(g->height(4.001, 0), 0);
  for (double x : {1.0, 4.0}) {
    EXPECT_NEAR(g->height(x + 1e-6, 0) - g->height(x - 1e-6, 0), 0, 1e-12);
    EXPECT_NEAR((g->normal(x - 1e-6, 0) - g->normal(x + 1e-6, 0)).norm(), 0, 1e-6);
  }
  EXPECT_NEAR(g->height(2.5, 0), 0.02 * std::sin(20 * 1.5 + 1.0), 1e-15);
}

TEST(Sinusoid, RefusesToJump) {
  SinusoidSettings p;
  p.amplitude = 0.02;
  p.wavenumber = 20;
  p.bounded_start = true;
  EXPECT_NO_THROW(sinusoid_ground(p));
  p.phase = 0.5;
  EXPECT_THROW(sinusoid_ground(p), GroundError);
  p.phase = 0;
  p.length = 1.0;
  EXPECT_THROW(sinusoid_ground(p), GroundError);
  p.length = 10 * std::numbers::pi / 20;
  EXPECT_NO_THROW(sinusoid_ground(p));
}

TEST(Sum, AddsHeightsAndGradients) {
  SlopeSettings slope;
  slope.angle = 10 * deg;
  SinusoidSettings wave;
  wave.amplitude = 0.01;
  wave.wavenumber = 10;
  wave.frame.heading = 60 * deg;
  const GroundPtr a = slope_ground(slope), b = sinusoid_ground(wave), c = flat_ground(0.5);
  const GroundPtr sum = sum_ground({a, b, c});
  for (double x = 0.1; x < 3; x += 0.37) {
    EXPECT_DOUBLE_EQ(sum->height(x, 0.2), a->height(x, 0.2) + b->height(x, 0.2) + 0.5);
    expect_normal_is_gradient(*sum, x, 0.2, 1e-8);
  }
  EXPECT_EQ(sum->resolution(), b->resolution());
  EXPECT_EQ(sum->describe(),
            "slope 10 deg + sinusoid, amplitude 10 mm, period 628.319 mm, heading 60 deg + flat at 0.5 m");
}

TEST(Settings, OutOfRangeAreRefused) {
  SlopeSettings slope;
  slope.angle = 61 * deg;
  EXPECT_THROW(slope_ground(slope), GroundError);
  StepSettings step;
  step.ramp = 1e-4;
  EXPECT_THROW(step_ground(step), GroundError);
  SinusoidSettings wave;
  wave.amplitude = 1;
  EXPECT_THROW(sinusoid_ground(wave), GroundError);
  EXPECT_THROW(flat_ground(NAN), GroundError);
  EXPECT_THROW(sum_ground({}), GroundError);
}

}  // namespace
}  // namespace grouser
