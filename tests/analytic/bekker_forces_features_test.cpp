// Limits and identities of each feature of forces(nonlinear), and the lanes behind it.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "bekker_random_rows.h"
#include "grouser/bekker/forces.h"
#include "kernel.h"
#include "lanes.h"

namespace grouser::bekker {
namespace {

using test_rows::any_row;

ForceCase plain() {
  ForceCase c;
  c.wheel = {0.13, 0.16};
  c.soil.modulus = 2.541e5 / std::pow(0.05, 1.387);
  c.soil.n = 1.387;
  c.soil.shear = {ShearLaw::Type::A, 500, 0.6, 5e-3, 1e-2, 0.6};
  c.soil.tan_phi = std::tan(0.6);
  c.arc = {0.5, 0.2, -0.1};
  c.slip = 0.3;
  c.slip_angle = 0.2;
  return c;
}
std::array<double, 6> of(const ForceResult& r) {
  EXPECT_EQ(r.status, ForceStatus::ok);
  const WheelWrench& w = r.wrench;
  return {w.Fx, w.Fy, w.Fz, w.Mx, w.My, w.Mz};
}
std::array<double, 6> exact(const ForceCase& c) { return of(forces(c, Method::nonlinear, 1e-12)); }
void expect_equal(const std::array<double, 6>& a, const std::array<double, 6>& b, double relative) {
  const double force = std::hypot(b[0], b[1], b[2]), moment = std::hypot(b[3], b[4], b[5]);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(a[i], b[i], relative * (i < 3 ? force : moment)) << "component " << i;
}

TEST(LockedWheel, IsTheLimitOfSlipToMinusOne) {
  // At slip -1 + d the displacement is 1/d times larger: what is left differs by the share of the arc where exp(-j/K)
  // has not died, ~ d.
  for (const auto type : {ShearLaw::Type::A, ShearLaw::Type::B, ShearLaw::Type::C})
    for (const auto lateral : {Lateral::isotropic, Lateral::anisotropic}) {
      ForceCase c = plain();
      c.soil.shear.type = type;
      c.soil.lateral = lateral;
      c.slip = -1;
      const auto locked = exact(c);
      c.slip = -1 + 1e-9;
      const auto nearly = exact(c);
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(nearly[i], locked[i], 1e-6 * std::abs(locked[2])) << i;
    }
}

TEST(LockedWheel, OfTypeAIsASlidingPlateOfCoulombFriction) {
  // Smooth arc, c = 0, beta = 0: tau_t = -sigma tan phi everywhere, so the torque is tan phi r times the pressure's own
  // integral.
  ForceCase c = plain();
  c.soil.shear.cohesion = 0;
  c.slip = -1;
  c.slip_angle = 0;
  const auto w = exact(c);
  ForceCase bare = c;
  bare.soil.tan_phi = 0;
  const auto p = exact(bare);
  // With a = integral sigma sin, b = integral sigma cos: Fx = -a - tan phi b, Fz = b - tan phi a.
  EXPECT_NEAR(w[0], p[0] - c.soil.tan_phi * p[2], 1e-11 * p[2]);
  EXPECT_NEAR(w[2], p[2] + c.soil.tan_phi * p[0], 1e-11 * p[2]);
}

TEST(SpinningWheel, HasNoSideForce) {
  ForceCase c = plain();
  c.slip = 1;  // v = 0: no slip angle is left
  const auto w = exact(c);
  EXPECT_EQ(w[1], 0);
  c.slip_angle = 0;
  expect_equal(exact(c), w, 1e-14);
}

TEST(Lugs, ThatFillTheSurfaceAreASmoothWheelOfTheirRadius) {
  ForceCase c = plain();
  c.wheel.lug_height = 0.02;
  c.wheel.lug_ratio = 1;
  ForceCase smooth = c;
  smooth.wheel = {0.15, 0.16};
  expect_equal(exact(c), exact(smooth), 1e-13);
}

TEST(Lugs, OfNoHeightDoNotMatter) {
  ForceCase c = plain();
  const auto smooth = exact(c);
  c.wheel.lug_height = 1e-12;  // theta_ca -> theta_f: both parts press alike
  c.wheel.lug_ratio = 0.3;
  expect_equal(exact(c), smooth, 1e-9);
}

TEST(Lugs, ThatAloneTouchPressWithTheirShare) {
  // Sunk by less than the lug height: the concave part carries nothing.
  ForceCase c = plain();
  c.arc = {0.2, 0.1, 0};
  c.soil.shear.cohesion = 0;
  c.slip_angle = 0;
  c.wheel.lug_height = 0.02;
  c.wheel.lug_ratio = 0.25;
  ForceCase smooth = c;
  smooth.wheel = {0.15, 0.16};
  smooth.soil.modulus *= 0.25;
  expect_equal(exact(c), exact(smooth), 1e-12);
}

TEST(Lugs, WithoutTipsTouchNothingWhileTheTreadIsClear) {
  ForceCase c = plain();
  c.arc = {0.2, 0.1, 0};
  c.wheel.lug_height = 0.02;
  c.wheel.lug_ratio = 0;
  for (const Method m : {Method::nonlinear, Method::quadratic, Method::linear}) {
    const WheelWrench w = forces(c, m, 1e-6).wrench;
    EXPECT_EQ(w.Fx, 0);
    EXPECT_EQ(w.Fz, 0);
    EXPECT_EQ(w.My, 0);
  }
}

TEST(Lugs, ThatAloneTouchLeaveTheTreadOutOfARutWhereverThetaMLies) {
  // Soft unloading, ko below the secant: the law of eq 2.12 goes on above the ground, the wheel does not. theta_m
  // behind the bottom, where the tread has no entry angle.
  ForceCase c = plain();
  c.arc = {0.2, -0.05, -0.15};
  c.soil.shear.cohesion = 0;
  c.wheel.lug_height = 0.02;
  c.wheel.lug_ratio = 0.25;
  c.unloading_sinkage = 0.004;
  c.soil.ko = 0.4 * c.soil.modulus * std::pow(0.004, c.soil.n - 1);
  ForceCase smooth = c;
  smooth.wheel = {0.15, 0.16};
  smooth.soil.modulus *= 0.25;
  smooth.soil.ko *= 0.25;
  expect_equal(exact(c), exact(smooth), 1e-12);
}

TEST(RepetitiveLoading, BelowTheEarlierSinkageAlongALinearSoilOfItsOwnSlopeIsVirgin) {
  // n = 1 and slope ko = k: eq 2.12 is k z on both sides of zu.
  ForceCase c = plain();
  c.soil.n = 1;
  c.soil.modulus = 2e6;
  const auto virgin = exact(c);
  c.soil.ko = 2e6;
  c.unloading_sinkage = 0.008;
  expect_equal(exact(c), virgin, 1e-11);
}

TEST(RepetitiveLoading, OfStiffSoilThatIsNotReachedCarriesNothing) {
  ForceCase c = plain();
  c.unloading_sinkage = 2 * 0.13 * (1 - std::cos(0.5));
  c.soil.ko = 1e12;
  const ForceResult r = forces(c, Method::nonlinear, 1e-6);
  EXPECT_EQ(r.status, ForceStatus::ok);
  EXPECT_EQ(r.wrench.Fz, 0);
  EXPECT_EQ(r.wrench.My, 0);  // no cohesion where nothing touches
}

TEST(SlipAngle, MirrorsTheSideForceOnly) {
  for (const auto lateral : {Lateral::isotropic, Lateral::anisotropic}) {
    ForceCase c = plain();
    c.soil.lateral = lateral;
    const auto a = exact(c);
    c.slip_angle = -c.slip_angle;
    const auto b = exact(c);
    expect_equal({a[0], -a[1], a[2], -a[3], a[4], -a[5]}, b, 1e-13);
  }
}

TEST(LateralModels, AgreeWithoutASlipAngleOnADrivenWheel) {
  ForceCase c = plain();
  c.slip_angle = 0;
  const auto isotropic = exact(c);
  c.soil.lateral = Lateral::anisotropic;
  expect_equal(exact(c), isotropic, 1e-12);
}

TEST(Forces, NameWhatTheyRefuse) {
  const auto status = [](auto change) {
    ForceCase c = plain();
    change(c);
    return forces(c, Method::nonlinear, 1e-6).status;
  };
  EXPECT_EQ(status([](ForceCase&) {}), ForceStatus::ok);
  EXPECT_EQ(status([](ForceCase& c) { c.arc.theta_m = 0.5; }), ForceStatus::no_pressure);
  EXPECT_EQ(status([](ForceCase& c) { c.slip = 1.1; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.slip = std::nan(""); }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.wheel.radius = 0; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.wheel.lug_ratio = 1.5; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.arc.theta_m = c.arc.theta_r = -0.5; }), ForceStatus::no_pressure);
  EXPECT_EQ(status([](ForceCase& c) { c.soil.shear.K = 0; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.slip_angle = 1.6; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.arc.theta_r = 0.3; }), ForceStatus::bad_argument);
  EXPECT_EQ(status([](ForceCase& c) { c.unloading_sinkage = 0.01; }), ForceStatus::bad_argument);  // no slope given
  EXPECT_EQ(forces(plain(), Method::nonlinear, 0).status, ForceStatus::bad_argument);
}

TEST(Kernels, OfEveryInstructionSetAgree) {
  std::vector<const Kernel*> kernels{&kernel_base};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels.push_back(&kernel_avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) kernels.push_back(&kernel_avx512);
#endif
  std::mt19937_64 rng(4);
  for (int i = 0; i < 300; ++i) {
    const ForceCase c = any_row(rng);
    const Arc arc(c);
    const Piece piece{0.1 * c.arc.theta_f, 0.2 * c.arc.theta_f, true};
    const PieceSums a = kernel_base.integrate(arc, piece, mapped_rule(1, 2, 1));
    for (const Kernel* k : kernels) {
      const PieceSums b = k->integrate(arc, piece, mapped_rule(1, 2, 1));
      const double size = std::hypot(a.Fx, a.Fy, a.Fz);
      EXPECT_NEAR(a.Fx, b.Fx, 1e-12 * size) << k->name << " row " << i;
      EXPECT_NEAR(a.Fy, b.Fy, 1e-12 * size) << k->name << " row " << i;
      EXPECT_NEAR(a.Fz, b.Fz, 1e-12 * size) << k->name << " row " << i;
      EXPECT_NEAR(a.My, b.My, 1e-12 * size) << k->name << " row " << i;
    }
  }
}

/// Largest error of f over random arguments, in units of the last place of the long double truth.
template <class F, class G, class Draw>
double worst_ulp(F f, G truth, Draw draw) {
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    double x[kLanes], y[kLanes];
    for (double& v : x) v = draw();
    store(y, f(load(x)));
    for (int k = 0; k < kLanes; ++k) {
      const long double t = truth(static_cast<long double>(x[k]));
      const double size = std::abs(static_cast<double>(t));
      const double ulp = std::nextafter(size, INFINITY) - size;
      worst = std::max(worst, static_cast<double>(std::abs(y[k] - t)) / ulp);
    }
  }
  return worst;
}

/// Largest error of f over random arguments, relative or absolute.
template <class F, class G, class Draw>
double worst_error(F f, G truth, Draw draw, bool relative) {
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = draw();
    const long double t = truth(static_cast<long double>(x));
    const double error = static_cast<double>(std::abs(f(splat(x))[0] - t));
    worst = std::max(worst, relative ? error / static_cast<double>(std::abs(t)) : error);
  }
  return worst;
}

TEST(Lanes, OfTenDigitsAreAccurateToThem) {
  std::mt19937_64 rng(6);
  std::uniform_real_distribution<double> exponent(-700, 700), decade(-300, 300), angle(-pi / 2, pi / 2);
  const auto ten = Digits::ten;
  EXPECT_LE(worst_error([](Lanes x) { return exp_of<ten>(x); }, [](long double x) { return std::exp(x); },
                        [&] { return exponent(rng); }, true),
            1e-10);
  EXPECT_LE(worst_error([](Lanes x) { return log_of<ten>(x); }, [](long double x) { return std::log(x); },
                        [&] { return std::pow(10, decade(rng)); }, false),
            6e-10);
  EXPECT_LE(worst_error([](Lanes x) { return sin_cos_half<ten>(x).sin; }, [](long double x) { return std::sin(x); },
                        [&] { return angle(rng); }, true),
            3e-11);
  EXPECT_LE(worst_error([](Lanes x) { return sin_cos_half<ten>(x).cos; }, [](long double x) { return std::cos(x); },
                        [&] { return angle(rng); }, false),
            4.1e-10);
  EXPECT_LE(worst_error([](Lanes x) { return inverse_sqrt_of<ten>(x); }, [](long double x) { return 1 / std::sqrt(x); },
                        [&] { return std::pow(10, decade(rng)); }, true),
            1e-12);
}

TEST(Lanes, AreAccurateToTheStatedUlp) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> exponent(-700, 700), decade(-300, 300), angle(-pi / 2, pi / 2);
  EXPECT_LE(worst_ulp([](Lanes x) { return exp_of(x); }, [](long double x) { return std::exp(x); },
                      [&] { return exponent(rng); }),
            2);
  EXPECT_LE(worst_ulp([](Lanes x) { return log_of(x); }, [](long double x) { return std::log(x); },
                      [&] { return std::pow(10, decade(rng)); }),
            2);
  EXPECT_LE(worst_ulp([](Lanes x) { return sin_cos_half(x).sin; }, [](long double x) { return std::sin(x); },
                      [&] { return angle(rng); }),
            3);
  // Next to pi/2 the cosine is good to the rounding of 1, not of itself.
  EXPECT_LE(worst_ulp([](Lanes x) { return 2 + sin_cos_half(x).cos; }, [](long double x) { return 2 + std::cos(x); },
                      [&] { return angle(rng); }),
            1.5);
  EXPECT_EQ(exp_of(splat(0.0))[0], 1);
  EXPECT_EQ(log_of(splat(1.0))[0], 0);
  EXPECT_GT(exp_of(splat(-1e300))[0], 0);  // underflow stops at exp(-708)
  EXPECT_LT(exp_of(splat(-1e300))[0], 1e-300);
}

}  // namespace
}  // namespace grouser::bekker
