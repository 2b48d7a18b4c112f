// The steady wheel with effects against the plain model and against limiting cases.
#include "grouser/bekker/effect_wheel.h"

#include <gtest/gtest.h>

#include <random>

namespace grouser::bekker {
namespace {

struct Soil {
  double k = 254.1e3, n = 1.387, c = 139.28, phi = 0.606, K = 0.5151e-3, a0 = 0.18, a1 = 0.32;
};

EffectWheel wheel() { return {0.13, 0.16, 0.16, {}}; }

WheelState<double> state(const Soil& s, double slip, double load) {
  WheelState<double> q{s.k, s.n, s.c, s.phi, s.K, s.a0, s.a1, slip, load, {}, 0};
  q.effect = no_effects();
  return q;
}

/// The same wheel by the library's own solver, another rule on other pieces.
Solution plain(const Soil& s, double slip, double load, double tolerance) {
  LoadCase c;
  c.wheel = {0.13, 0.16, 0, 0};
  BekkerSoil b;
  b.pressure = {PressureSinkage::Law::k_b, 0, 0, s.k, s.n, 0.16};
  b.shear.cohesion = s.c;
  b.shear.friction_angle = s.phi;
  b.shear.K = s.K;
  b.angles = {s.a0, s.a1, 0, 0};
  c.soil = SoilLaw::of(b, 0.16);
  c.load = load;
  c.slip = slip;
  return solve(c, Method::nonlinear, tolerance);
}

// Soils over the whole range of the priors and of Table 4.8, all slips: 1e-6 of the load, of load times radius, of the sinkage.
TEST(EffectWheel, WithoutEffectsAgreesWithTheSolverToAMillionth) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0, 1);
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const Soil s{
        254e3 * std::exp(3 * (u(random) - 0.7)), 0.4 + 1.2 * u(random), 600 * u(random), 0.4 + 0.35 * u(random),
        5e-4 * std::pow(40.0, u(random)),        0.35 * u(random),      0.5 * u(random)};
    const double slips[] = {-0.9, -0.7, -0.5, -0.3, -0.1, -0.02, 0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9};
    const double slip = slips[i % 13], load = 40 + 200 * u(random);
    const Solution ref = plain(s, slip, load, 1e-9);
    double theta = 0;
    WheelAnswer<double> a{};
    const ForceStatus status = effect_equilibrium(wheel(), {}, state(s, slip, load), 0, theta, a);
    ASSERT_EQ(status, ref.status) << slip << " " << s.a0 + s.a1 * std::abs(slip);
    if (status != ForceStatus::ok) continue;
    const double e =
        std::max({std::abs(a.drawbar - ref.wrench.Fx) / load, std::abs(a.torque + ref.wrench.My) / load / 0.13,
                  std::abs(a.sinkage - ref.sinkage) / ref.sinkage});
    EXPECT_LT(e, 1e-6) << "slip " << slip << " K " << s.K << " n " << s.n << " theta_f " << theta;
    worst = std::max(worst, e);
  }
  RecordProperty("worst", std::to_string(worst));
}

}  // namespace
}  // namespace grouser::bekker
