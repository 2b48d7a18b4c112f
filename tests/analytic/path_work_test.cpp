// Work of pressing over a step: the integral itself, whatever a potential is said to be.
#include "grouser/terrain/path_work.h"

#include <gtest/gtest.h>

#include "helpers.h"

namespace grouser {
namespace {

const auto kCubic = [](double h) { return 3e9 * h * h * h; };
double energy(double h) { return 0.75e9 * h * h * h * h; }

WheelMotion at(const Vec3& hub, const Vec3& v) {
  WheelMotion m;
  m.pose = {hub, Vec3::UnitY(), 0.13, 0.16};
  m.V.v = v;
  return m;
}

/// path_work over a step that ends in m, told that the potential has changed by `expected`.
double work(const WheelMotion& m, const Ground& ground, double dt, double expected, double tolerance) {
  PatchFinder finder;
  const double begin = pressing_power(finder.find(earlier(m.pose, m.V, dt), ground), m.V, kCubic);
  const double end = pressing_power(finder.find(m.pose, ground), m.V, kCubic);
  return path_work(finder, ground, m, dt, begin, end, expected, tolerance, kCubic);
}

TEST(PathWork, OfALargeStepIsTheIntegralOfTheForceWhateverThePotentialIsSaidToBe) {
  // From 1 mm above the ground to 4 mm deep in one step: energy(h) by hand. The integrand is zero for a fifth of the step, so what is left is
  // the tolerance of the adaptive rule. Told a wrong potential, the work is the same.
  const auto ground = flat_ground();
  const double h = 0.004, dt = 1e-3, truth = energy(h), tolerance = 1e-3 * truth;
  const WheelMotion m = at({0, 0, 0.13 - h}, {0.2, 0, -5});
  for (const double said : {truth, 0.5 * truth, 2 * truth, 0.0})
    EXPECT_NEAR(work(m, *ground, dt, said, tolerance), truth, tolerance);
}

TEST(PathWork, OverCurvedGroundIsTheChangeOfThePotentialOfTheTwoSinkages) {
  // The pressure of a patch is conservative on any ground (P3): the integral along the way, which asks for force and normal only, is the
  // difference of the potentials at the ends, which come from two sinkages.
  const auto ground = test::ground_of([](double x, double) { return 0.01 * std::sin(30 * x); }, 1e-3);
  PatchFinder finder;
  const double dt = 5e-3;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.013 * i;
    const WheelMotion m = at({x, 0, 0.135 + 0.01 * std::sin(30 * x)}, {1.5, 0, 0.3 * std::cos(30 * x)});
    const double h1 = finder.find(m.pose, *ground).sinkage, h0 = finder.find(earlier(m.pose, m.V, dt), *ground).sinkage;
    const double scale = energy(std::max(h0, h1));
    EXPECT_NEAR(work(m, *ground, dt, NAN, 1e-3 * scale), energy(h1) - energy(h0), 2e-3 * scale + 1e-12) << x;
  }
}

}  // namespace
}  // namespace grouser
