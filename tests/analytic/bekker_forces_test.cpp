#include <gtest/gtest.h>

#include "grouser/bekker/wheel_forces.h"
#include "helpers.h"

namespace grouser::bekker {
namespace {

using test::mojave;

/// Eqs 2.4-2.11 with the errata's forms, written directly in kappa and beta, and adaptive Simpson: nothing shared with the library.
struct Direct {
  WheelSize w;
  BekkerSoil s;
  double theta_f, kappa, beta;

  double theta_m = 0, theta_r = 0, k = 0;
  void prepare() {
    const double slip = kappa <= 1 ? 1 - kappa : 1 / kappa - 1;
    theta_m = (s.angles.a0 + s.angles.a1 * std::abs(slip)) * theta_f;
    theta_r = -(s.angles.b0 + s.angles.b1 * std::abs(slip)) * theta_f;
    k = s.pressure.k / std::pow(s.pressure.reference_width, s.pressure.n);
  }
  std::array<double, 6> density(double th) const {
    double te = th;
    if (th < theta_m) te = theta_f - (th - theta_r) * (theta_f - theta_m) / (theta_m - theta_r);
    const double z = std::max(0.0, w.radius * (std::cos(te) - std::cos(theta_f)));
    const double sigma = k * std::pow(z, s.pressure.n);
    const double jt = w.radius * ((theta_f - th) - kappa * (std::sin(theta_f) - std::sin(th)));
    const double jl = w.radius * kappa * (theta_f - th) * std::tan(beta);
    const double j = std::hypot(jt, jl);
    double f = 0;
    const auto& sh = s.shear;
    if (sh.type == ShearLaw::Type::A) f = 1 - std::exp(-j / sh.K);
    if (sh.type == ShearLaw::Type::B) f = j / sh.Kw * std::exp(1 - j / sh.Kw);
    if (sh.type == ShearLaw::Type::C)
      f = sh.Kr * (1 + (1 / (sh.Kr * (1 - std::exp(-1.0))) - 1) * std::exp(1 - j / sh.Kw)) * (1 - std::exp(-j / sh.Kw));
    const double tau = z > 0 ? (sh.cohesion + sigma * std::tan(sh.friction_angle)) * f : 0;
    const double vt = 1 - kappa * std::cos(th), vl = kappa * std::tan(beta), v = std::hypot(vt, vl);
    const double tt = v > 0 ? tau * vt / v : 0, tl = v > 0 ? tau * vl / v : 0;
    return {-sigma * std::sin(th) + tt * std::cos(th),
            -tl,
            sigma * std::cos(th) + tt * std::sin(th),
            -tl * std::cos(th),
            -tt,
            -tl * std::sin(th)};
  }
  double simpson(int c, double a, double b, double fa, double fm, double fb, double whole, double tol,
                 int depth) const {
    const double m = 0.5 * (a + b), l = 0.5 * (a + m), r = 0.5 * (m + b);
    const double fl = density(l)[c], fr = density(r)[c];
    const double left = (m - a) / 6 * (fa + 4 * fl + fm), right = (b - m) / 6 * (fm + 4 * fr + fb);
    if (depth <= 0 || std::abs(left + right - whole) < 15 * tol) return left + right + (left + right - whole) / 15;
    return simpson(c, a, m, fa, fl, fm, left, tol / 2, depth - 1) +
           simpson(c, m, b, fm, fr, fb, right, tol / 2, depth - 1);
  }
  double integral(int c) const {
    double sum = 0;
    const double cuts[] = {theta_r, theta_m, theta_f};
    for (int piece = 0; piece < 2; ++piece)
      for (int i = 0; i < 16; ++i) {
        const double a = cuts[piece] + (cuts[piece + 1] - cuts[piece]) * i / 16;
        const double b = cuts[piece] + (cuts[piece + 1] - cuts[piece]) * (i + 1) / 16;
        const double fa = density(a)[c], fm = density(0.5 * (a + b))[c], fb = density(b)[c];
        sum += simpson(c, a, b, fa, fm, fb, (b - a) / 6 * (fa + 4 * fm + fb), 1e-6, 22);
      }
    return sum * w.radius * w.width * (c < 3 ? 1 : w.radius);
  }
};

Direct random_row(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(0, 1);
  Direct d;
  d.w = {0.05 + 0.4 * u(rng), 0.03 + 0.3 * u(rng)};
  d.s.pressure = {PressureSinkage::Law::k_b, 0, 0, std::pow(10, 4 + 2 * u(rng)), 0.4 + 1.4 * u(rng), 0.05};
  d.s.shear = {static_cast<ShearLaw::Type>(rng() % 3),
               3000 * u(rng),
               0.2 + 0.5 * u(rng),
               5e-4 + 0.03 * u(rng),
               2e-3 + 0.03 * u(rng),
               0.3 + 0.6 * u(rng)};
  d.s.angles = {0.1 + 0.3 * u(rng), 0.3 * u(rng), 0.3 * u(rng) * static_cast<double>(rng() % 2), 0};
  d.theta_f = 0.1 + 0.9 * u(rng);
  d.kappa = kappa_of_slip(-0.9 + 1.85 * u(rng));
  d.beta = 0.5 * (2 * u(rng) - 1) * static_cast<double>(rng() % 4 != 0);
  d.prepare();
  return d;
}

TEST(BekkerForces, AgreeWithIndependentAdaptiveQuadratureOnRandomRows) {
  std::mt19937 rng(7);
  double worst_default = 0, worst_fine = 0;
  for (int row = 0; row < 200; ++row) {
    const Direct d = random_row(rng);
    const SoilLaw soil = SoilLaw::of(d.s, d.w.width);
    const WheelForces a = steady_forces(d.w, soil, d.theta_f, d.kappa, d.beta);
    const WheelForces b = steady_forces(d.w, soil, d.theta_f, d.kappa, d.beta, {96, 0});
    const double x[] = {a.Fx, a.Fy, a.Fz, a.Mx, a.My, a.Mz}, y[] = {b.Fx, b.Fy, b.Fz, b.Mx, b.My, b.Mz};
    double size = 0;
    std::array<double, 6> truth{};
    for (int c = 0; c < 6; ++c) truth[c] = d.integral(c);
    size = std::hypot(truth[0], truth[1], truth[2]);
    for (int c = 0; c < 6; ++c) {
      const double scale = size * (c < 3 ? 1 : d.w.radius);
      worst_default = std::max(worst_default, std::abs(x[c] - truth[c]) / scale);
      worst_fine = std::max(worst_fine, std::abs(y[c] - truth[c]) / scale);
    }
  }
  RecordProperty("worst_default", std::to_string(worst_default * 1e6) + "e-6");
  RecordProperty("worst_fine", std::to_string(worst_fine * 1e6) + "e-6");
  EXPECT_LT(worst_default, 5e-4);  // of the force: twice the largest error of README.md's table
  EXPECT_LT(worst_fine, 1e-6);
}

TEST(BekkerForces, ToleranceOptionReachesItsTolerance) {
  std::mt19937 rng(11);
  for (int row = 0; row < 50; ++row) {
    const Direct d = random_row(rng);
    const SoilLaw soil = SoilLaw::of(d.s, d.w.width);
    const WheelForces a = steady_forces(d.w, soil, d.theta_f, d.kappa, d.beta, {10, 1e-4});
    const double size = std::hypot(a.Fx, a.Fy, a.Fz);
    EXPECT_NEAR(a.Fx, d.integral(0), 2e-4 * size);
    EXPECT_NEAR(a.Fz, d.integral(2), 2e-4 * size);
  }
}

TEST(BekkerForces, ReproduceTheErratasSinkageOfTheMitWheel) {
  const WheelSize wheel{0.13, 0.16};
  const ShearState rolling = shear_state(1.0);
  const auto plate = steady_equilibrium(wheel, SoilLaw::of(mojave(0.05), 0.16), 115, rolling);
  const auto own = steady_equilibrium(wheel, SoilLaw::of(mojave(0), 0.16), 115, rolling);
  EXPECT_NEAR(plate.sinkage, 9.6e-3, 0.05e-3);  // printed to 0.1 mm
  EXPECT_NEAR(own.sinkage, 21.9e-3, 0.05e-3);
}

TEST(BekkerForces, ReproduceAnIndependentStudyOfTheMitWheelUnderSlip) {
  const WheelSize wheel{0.13, 0.16};
  const SoilLaw soil = SoilLaw::of(mojave(), 0.16);
  const auto a = steady_equilibrium(wheel, soil, 115, shear_state(kappa_of_slip(0.3)));
  EXPECT_NEAR(a.forces.Fx, 55, 0.5);
  EXPECT_NEAR(-a.forces.My, 9.6, 0.05);
  EXPECT_NEAR(a.sinkage, 10.0e-3, 0.05e-3);
  const auto b = steady_equilibrium(wheel, soil, 115, shear_state(kappa_of_slip(0.7)));
  EXPECT_NEAR(b.forces.Fx, 51, 0.5);
  EXPECT_NEAR(b.sinkage, 11e-3, 0.5e-3);
}

TEST(BekkerForces, EquilibriumBalancesTheLoad) {
  const WheelSize wheel{0.13, 0.16};
  const SoilLaw soil = SoilLaw::of(mojave(), 0.16);
  for (double load : {1e-3, 1.0, 60.0, 115.0, 225.0, 600.0})
    for (double slip : {-0.9, -0.3, 0.0, 0.1, 0.7, 1.0}) {
      const auto q = steady_equilibrium(wheel, soil, load, shear_state(kappa_of_slip(slip), 0.1));
      ASSERT_EQ(q.status, Equilibrium::Status::ok);
      EXPECT_NEAR(q.forces.Fz, load, 1e-9 * load) << load << " " << slip;
    }
}

TEST(BekkerForces, InfeasibleLoadsAreNamed) {
  const WheelSize wheel{0.13, 0.16};
  const SoilLaw soil = SoilLaw::of(mojave(), 0.16);
  EXPECT_EQ(steady_equilibrium(wheel, soil, 1e7, {}).status, Equilibrium::Status::too_soft);
  EXPECT_EQ(steady_equilibrium(wheel, soil, -1, {}).status, Equilibrium::Status::bad_argument);
  EXPECT_NE(name_of(Equilibrium::Status::too_soft).find("hub"), std::string_view::npos);
}

TEST(BekkerForces, PressureAloneIsBuoyancyAndCompactionWork) {
  // no shear, theta_m = 0: sigma = k z. n = 1: vertical force = k times the volume displaced by the front half. Any n: resistance per
  // width = work of compacting to depth h, k h^(n+1)/(n+1) (Bekker).
  BekkerSoil s;
  s.shear = {ShearLaw::Type::A, 0, 0, 0.01, 0, 1};
  s.angles = {1e-9, 0, 0, 0};
  const WheelSize w{0.3, 0.2};
  for (double n : {0.5, 1.0, 1.4}) {
    s.pressure = {PressureSinkage::Law::kc_kphi, 0, 1e6, 0, n, 0.05};
    const double tf = 0.5, h = w.radius * (1 - std::cos(tf));
    const WheelForces f = steady_forces(w, SoilLaw::of(s, w.width), tf, 0.9, 0.0, {40, 0});
    EXPECT_NEAR(-f.Fx, w.width * 1e6 * std::pow(h, n + 1) / (n + 1), 1e-6 * f.Fz);
    if (n == 1.0) {
      const double half_segment = 0.5 * w.radius * w.radius * (tf - std::sin(tf) * std::cos(tf));
      EXPECT_NEAR(f.Fz, 1e6 * w.width * half_segment, 1e-6 * f.Fz);
    }
  }
}

TEST(BekkerForces, NoSlipAngleNoSideForceAndOppositeAnglesMirror) {
  const WheelSize w{0.13, 0.16};
  const SoilLaw soil = SoilLaw::of(mojave(), 0.16);
  for (double kappa : {0.4, 1.0, 2.0}) {
    const WheelForces z = steady_forces(w, soil, 0.4, kappa, 0.0), a = steady_forces(w, soil, 0.4, kappa, 0.2),
                      b = steady_forces(w, soil, 0.4, kappa, -0.2);
    EXPECT_EQ(z.Fy, 0);
    EXPECT_EQ(z.Mx, 0);
    EXPECT_EQ(z.Mz, 0);
    EXPECT_LT(a.Fy, 0);  // moving left, pushed right
    EXPECT_DOUBLE_EQ(a.Fy, -b.Fy);
    EXPECT_DOUBLE_EQ(a.Fx, b.Fx);
    EXPECT_DOUBLE_EQ(a.Mz, -b.Mz);
  }
}

TEST(BekkerForces, LockedWheelMobilisesTheWholeStrength) {
  const WheelSize w{0.13, 0.16};
  BekkerSoil s = mojave();
  const WheelForces a = steady_forces(w, SoilLaw::of(s, 0.16), 0.4, INFINITY, 0.0);
  EXPECT_NEAR(a.My, a.capacity * w.radius, 1e-9 * a.capacity);  // tau_t = -tau_max everywhere
  s.shear = {ShearLaw::Type::C, 139, 0.6, 0, 0.01, 0.7};
  const WheelForces c = steady_forces(w, SoilLaw::of(s, 0.16), 0.4, INFINITY, 0.0);
  EXPECT_NEAR(c.My, 0.7 * c.capacity * w.radius, 1e-9 * c.capacity);
  s.shear.type = ShearLaw::Type::B;
  EXPECT_NEAR(steady_forces(w, SoilLaw::of(s, 0.16), 0.4, INFINITY, 0.0).My, 0, 1e-12);
}

TEST(BekkerForces, ShearLawsHaveTheirPublishedShape) {
  ShearLaw a{ShearLaw::Type::A, 0, 0, 0.01, 0, 1}, b{ShearLaw::Type::B, 0, 0, 0, 0.02, 1},
      c{ShearLaw::Type::C, 0, 0, 0, 0.02, 0.66};
  EXPECT_NEAR(mobilised(a, 0.01), 0.6321205588, 1e-9);  // one K: 63 %
  EXPECT_NEAR(mobilised(b, 0.02), 1, 1e-12);            // peak at Kw
  EXPECT_LT(mobilised(b, 0.019), 1);
  EXPECT_LT(mobilised(b, 0.021), 1);
  EXPECT_NEAR(mobilised(c, 0.02), 1, 1e-12);   // the peak, near Kw
  EXPECT_NEAR(mobilised(c, 1.0), 0.66, 1e-9);  // residual
  for (const ShearLaw& l : {a, b, c}) EXPECT_EQ(mobilised(l, 0), 0);
}

TEST(BekkerForces, WongsBrakingAngleHasTheErratasJumpAndSize) {
  const SoilLaw soil = SoilLaw::of(mojave(), 0.16, ThetaMLaw::wong_braking);
  const double deg = pi / 180;
  EXPECT_NEAR(contact_range(soil, 22.6 * deg, -1e-9).theta_m, 0, 1e-6);  // jumps from a0 theta_f at s = 0
  EXPECT_NEAR(contact_range(soil, 22.6 * deg, -0.3).theta_m, 24 * deg, 0.1 * deg);
  EXPECT_TRUE(contact_range(soil, 22.6 * deg, -0.3).front_branch_empty);
  EXPECT_FALSE(contact_range(soil, 22.6 * deg, 0.3).front_branch_empty);
}

TEST(BekkerForces, DerivativesByTheShearStateMatchDifferences) {
  const WheelSize w{0.13, 0.16};
  BekkerSoil s = mojave();
  s.shear.K = 0.01;
  s.angles = {0.3, 0, 0, 0};  // theta_m fixed, as in the derivative
  const SoilLaw soil = SoilLaw::of(s, 0.16);
  for (const ShearState e :
       {ShearState{0.3, 0.1}, ShearState{0.05, -0.2}, ShearState{-1.5, 0.3}, ShearState{0.9, 0.0}}) {
    const Quadrature q{60, 0};
    const WheelForces f = steady_forces(w, soil, 0.4, e, q);
    const double d = 1e-5;
    const auto get = [&](double dt, double dl) { return steady_forces(w, soil, 0.4, {e.t + dt, e.l + dl}, q); };
    const auto tp = get(d, 0), tm = get(-d, 0), lp = get(0, d), lm = get(0, -d);
    EXPECT_NEAR(f.d_t[0], (tp.Fx - tm.Fx) / (2 * d), 2e-3 * f.Fz);
    EXPECT_NEAR(f.d_t[4], (tp.My - tm.My) / (2 * d), 2e-3 * f.Fz * w.radius);
    EXPECT_NEAR(f.d_l[1], (lp.Fy - lm.Fy) / (2 * d), 2e-3 * f.Fz);
    EXPECT_NEAR(f.d_l[5], (lp.Mz - lm.Mz) / (2 * d), 2e-3 * f.Fz * w.radius);
  }
}

}  // namespace
}  // namespace grouser::bekker
