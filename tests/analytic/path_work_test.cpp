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

struct Step {
  PatchFinder finder;
  Pressing begin, end;
  double work;

  /// Work over a step that ends in m, at most `tolerance` off.
  Step(const WheelMotion& m, const Ground& ground, double dt, double tolerance) {
    begin = Pressing::of(finder.find(earlier(m.pose, m.V, dt), ground), m.V);
    end = Pressing::of(finder.find(m.pose, ground), m.V);
    work = PathWork(finder, ground, m, dt, tolerance, kCubic).between(begin, end);
  }
};

TEST(PathWork, OfALargeStepIsTheIntegralOfTheForce) {
  // From 1 mm above the ground to 4 mm deep in one step: energy(h) by hand. The wheel is clear of the ground for a fifth of the step.
  const auto ground = flat_ground();
  const double h = 0.004, dt = 1e-3, truth = energy(h), tolerance = 1e-3 * truth;
  EXPECT_NEAR(Step(at({0, 0, 0.13 - h}, {0.2, 0, -5}), *ground, dt, tolerance).work, truth, tolerance);
  EXPECT_NEAR(Step(at({0, 0, 0.13 + 0.001}, {0.2, 0, 5}), *ground, dt, tolerance).work, -truth, tolerance);
}

TEST(PathWork, OfAForceThatIsNoGradientIsWhatItDoesAndNotTheChangeOfItsPotential) {
  // A wheel that presses at a rate which is not that of its sinkage: 0.3 mm deeper by the patches, while rates at both ends say 0.6 mm. The
  // middle of the step knows the true ones, so the sum there is what a constant rate of the patches gives, plus what the wrong ends add.
  const auto ground = flat_ground();
  const double h = 0.004, dt = 1e-3;
  const WheelMotion m = at({0, 0, 0.13 - h}, {0.2, 0, -0.3});
  PatchFinder finder;
  const Pressing begin{h - 0.0003, 0.6}, end{h, 0.6};
  const auto constant = [](double) { return 100.0; };
  // Halved six times: 64 pieces; the outer two run from 0.6 to 0.3 m/s, the others stay at 0.3. By hand 100 N (0.3 mm + 2 (0.15/64) mm).
  EXPECT_NEAR(PathWork(finder, *ground, m, dt, 1e-12, constant).between(begin, end), 0.1 * (0.3 + 0.3 / 64), 1e-8);
}

TEST(PathWork, OfAWheelThatTurnsFarFromTheOriginOfTheWorldFindsTheSameGroundUnderIt) {
  // A turn of 0.0002 rad on the spot, 500 m from the origin, on ground with a kink every 15 mm, three of the ground samples. Counted from the
  // world's origin the samples would slide by 0.1 m. Counted along the wheel's own way, what the rates say is what the wheel sinks: here 5 %
  // of the change that the slide would make.
  const auto ground = test::ground_of(
      [](double x, double y) { return 0.012 * std::abs(std::remainder(x + 0.3 * y, 0.03) / 0.015); }, 1e-3);
  PatchFinder finder;
  const double dt = 1e-3;
  double slid = 0, left = 0;
  for (int i = 0; i < 20; ++i) {
    WheelMotion m = at({3 + 0.0013 * i, 500, 0.13 + 0.003}, {0, 0, 0});
    m.V.w = {0, 0, 0.2};
    m.carrier = carrier_axes(m.pose.axis_W);
    const double plain = finder.find(m.pose, *ground).sinkage - finder.find(earlier(m.pose, m.V, dt), *ground).sinkage;
    m = moved_on(m, 3, dt);
    const Pressing begin = Pressing::of(finder.find(earlier(m.pose, m.V, dt), *ground), m.V),
                   end = Pressing::of(finder.find(m.pose, *ground), m.V);
    slid += std::abs(plain);
    left += std::abs(end.sinkage - begin.sinkage - 0.5 * dt * (begin.rate + end.rate));
  }
  EXPECT_GT(slid, 20 * 10e-6);
  EXPECT_LT(left, 0.05 * slid);
}

TEST(PathWork, OverCurvedGroundIsTheChangeOfThePotentialOfTheTwoSinkages) {
  // The pressure of a patch is conservative on any ground (P3): the integral along the way, which asks for force and normal only, is the
  // difference of the potentials at the ends, which come from two sinkages.
  const auto ground = test::ground_of([](double x, double) { return 0.01 * std::sin(30 * x); }, 1e-3);
  const double dt = 5e-3;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.013 * i;
    const WheelMotion m = at({x, 0, 0.135 + 0.01 * std::sin(30 * x)}, {1.5, 0, 0.3 * std::cos(30 * x)});
    PatchFinder finder;
    const double h1 = finder.find(m.pose, *ground).sinkage, h0 = finder.find(earlier(m.pose, m.V, dt), *ground).sinkage;
    const double scale = energy(std::max(h0, h1));
    EXPECT_NEAR(Step(m, *ground, dt, 1e-3 * scale).work, energy(h1) - energy(h0), 2e-3 * scale + 1e-12) << x;
  }
}

}  // namespace
}  // namespace grouser
