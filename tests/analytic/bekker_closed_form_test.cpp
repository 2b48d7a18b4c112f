// Closed forms against eqs 2.4 to 2.20 written down a second time, in the dissertation's own symbols, with other
// quadratures.
#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss.hpp>
#include <random>
#include <vector>

#include "../../bekker/src/closed_form.h"

namespace grouser::bekker {
namespace {

constexpr double deg = pi / 180;
using Six = std::array<double, 6>;

Six six(const WheelWrench& w) { return {w.Fx, w.Fy, w.Fz, w.Mx, w.My, w.Mz}; }
double size(const Six& w) { return std::hypot(w[0], w[1], w[2]); }

/// Stresses of eqs 2.4 to 2.15 for type A, isotropic; slip in (-1, 1).
struct Printed {
  double c, tan_phi, n, K, k, r, b, hg = 0, mu = 0, tf, tm, tr, s, beta, zu = 0, ko = 0, Au = 0;

  double rs() const { return r + hg; }
  double theta_fca() const {
    const double hf = rs() * (1 - std::cos(tf));
    return hf > hg ? std::acos((rs() - hf) / r) : 0;
  }
  double pressure(double radius, double entry, double th) const {
    if (entry <= tm) return 0;
    const double te = th >= tm ? th : entry - (th - tr) * (entry - tm) / (tm - tr);
    const double z = radius * (std::cos(te) - std::cos(entry));
    if (z < 0) return 0;
    if (z >= zu) return k * std::pow(z, n);
    return std::max(0.0, k * std::pow(zu, n) - (ko + Au * zu) * (zu - z));
  }
  /// sigma_e, tau_et, tau_el
  std::array<double, 3> stress(double th) const {
    double sigma = pressure(rs(), tf, th);
    if (hg > 0) sigma = mu * sigma + (th <= theta_fca() ? (1 - mu) * pressure(r, theta_fca(), th) : 0);
    if (zu > 0 && !(sigma > 0)) return {0, 0, 0};
    const double kappa = s >= 0 ? 1 - s : 1 / (1 + s);
    const double jt = rs() * ((tf - th) - kappa * (std::sin(tf) - std::sin(th)));
    const double jl = rs() * kappa * (tf - th) * std::tan(beta);
    const double tau = (c + sigma * tan_phi) * (1 - std::exp(-std::hypot(jt, jl) / K));
    const double vt = 1 - kappa * std::cos(th), vl = kappa * std::tan(beta), v = std::hypot(vt, vl);
    return {sigma, v > 0 ? tau * vt / v : 0, v > 0 ? tau * vl / v : 0};
  }
  ForceCase force_case() const {
    ForceCase f;
    f.wheel = {r, b, hg, mu};
    f.soil.modulus = k;
    f.soil.n = n;
    f.soil.shear = {ShearLaw::Type::A, c, std::atan(tan_phi), K, 0, 1};
    f.soil.tan_phi = tan_phi;
    f.soil.ko = ko;
    f.soil.Au = Au;
    f.arc = {tf, tm, tr};
    f.slip = s;
    f.slip_angle = beta;
    f.unloading_sinkage = zu;
    return f;
  }

  /// Eq 2.11 of stresses p(theta) = (sigma, tau_t, tau_l) on [lo, hi], rule of 30 points in x with theta = hi - (hi
  /// - lo) x^2.
  template <class P>
  void add(Six& out, double lo, double hi, const P& p) const {
    for (int i = 0; i < 6; ++i) {
      const auto density = [&](double x) {
        const double th = hi - (hi - lo) * x * x, w = 2 * x * (hi - lo);
        const auto [sg, t, l] = p(th);
        const double cs = std::cos(th), sn = std::sin(th);
        const double of[6] = {-sg * sn + t * cs, -l, sg * cs + t * sn, -l * cs, -t, -l * sn};
        return w * of[i];
      };
      out[i] +=
          rs() * b * (i < 3 ? 1 : rs()) * boost::math::quadrature::gauss<double, 30>::integrate(density, 0.0, 1.0);
    }
  }
  Six integral() const {
    std::vector<double> cuts{tr, tm, tf};
    if (hg > 0 && theta_fca() > tm) cuts.push_back(theta_fca());
    std::sort(cuts.begin(), cuts.end());
    Six out{};
    const int parts = zu > 0 ? 400 : 3;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
      for (int k2 = 0; k2 < parts; ++k2) {
        const double d = (cuts[i + 1] - cuts[i]) / parts;
        add(out, cuts[i] + k2 * d, k2 + 1 == parts ? cuts[i + 1] : cuts[i] + (k2 + 1) * d,
            [&](double th) { return stress(th); });
      }
    return out;
  }
  /// Parabola through both ends and the middle of each piece; `last`: the stress at its end, or that of the law.
  Six parabolas(const std::vector<double>& cuts) const {
    Six out{};
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const double lo = cuts[i], hi = cuts[i + 1], m = 0.5 * (lo + hi);
      const auto p0 = stress(lo), p1 = stress(m), p2 = stress(hi);
      add(out, lo, hi, [&](double th) {
        std::array<double, 3> p{};
        for (int q = 0; q < 3; ++q)  // Lagrange
          p[q] = p0[q] * (th - m) * (th - hi) / ((lo - m) * (lo - hi)) +
                 p1[q] * (th - lo) * (th - hi) / ((m - lo) * (m - hi)) +
                 p2[q] * (th - lo) * (th - m) / ((hi - lo) * (hi - m));
        return p;
      });
    }
    return out;
  }
  /// Eq 2.20 of a smooth wheel.
  Six lines() const {
    Six out{};
    const auto pm = stress(tm), pr = stress(tr);
    const auto scaled = [](const std::array<double, 3>& a, double x, const std::array<double, 3>& d, double y) {
      return std::array{a[0] * x + d[0] * y, a[1] * x + d[1] * y, a[2] * x + d[2] * y};
    };
    add(out, tm, tf, [&](double th) { return scaled(pm, (tf - th) / (tf - tm), pr, 0); });
    add(out, tr, tm, [&](double th) { return scaled(pm, (th - tr) / (tm - tr), pr, 1); });
    return out;
  }
};

/// Table 2.2 [SI], wheels S and L of Table 2.3.
struct Named {
  const char* name;
  double c, phi, n, K, kc, kphi;
};
constexpr Named kSoils[] = {{"dry sand", 1000, 0.52, 1.1, 0.025, 900, 1523400},
                            {"sandy loam", 1700, 0.51, 0.7, 0.025, 5300, 1515000},
                            {"clayey soil", 4140, 0.23, 0.5, 0.01, 13200, 692200}};
Printed dissertation(const Named& soil, bool lugged, double theta_f) {
  Printed p{};
  p.c = soil.c;
  p.tan_phi = std::tan(soil.phi);
  p.n = soil.n;
  p.K = soil.K;
  p.b = 0.075;
  p.r = 0.08;
  p.k = soil.kc / p.b + soil.kphi;
  if (lugged) p.hg = 0.005, p.mu = 0.1;
  p.tf = theta_f;
  p.tm = 0.5 * theta_f;
  return p;
}

struct Spread {
  double mean = 0, sd = 0;
};
/// Fig 2.15's four errors [%] over slip 0.1..0.8 and slip angle 0..36 degrees.
template <class Approximate>
std::array<Spread, 4> errors(Printed p, const Approximate& approximate) {
  std::array<std::vector<double>, 4> e;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 10; ++k) {
      p.s = 0.1 * (i + 1);
      p.beta = 4 * deg * k;
      const Six t = p.integral(), a = approximate(p);
      e[0].push_back(100 * std::abs(a[0] / a[2] - t[0] / t[2]));
      e[1].push_back(100 * std::abs(a[1] / a[2] - t[1] / t[2]));
      e[2].push_back(100 * std::abs(a[2] / t[2] - 1));
      e[3].push_back(100 * std::abs(a[4] / t[4] - 1));
    }
  std::array<Spread, 4> out;
  for (int c = 0; c < 4; ++c) {
    for (double x : e[c]) out[c].mean += x / static_cast<double>(e[c].size());
    for (double x : e[c]) out[c].sd += (x - out[c].mean) * (x - out[c].mean) / static_cast<double>(e[c].size());
    out[c].sd = std::sqrt(out[c].sd);
  }
  return out;
}
const auto library = [](Method m) { return [m](const Printed& p) { return six(closed_form(p.force_case(), m)); }; };

Printed random_row(std::mt19937& rng) {
  std::uniform_real_distribution<double> u(0, 1);
  Printed p{};
  p.c = 3000 * u(rng);
  p.tan_phi = std::tan(0.2 + 0.5 * u(rng));
  p.n = 0.4 + 1.4 * u(rng);
  p.K = 5e-4 + 0.03 * u(rng);
  p.k = std::pow(10, 4 + 2 * u(rng));
  p.r = 0.05 + 0.4 * u(rng);
  p.b = 0.03 + 0.3 * u(rng);
  p.tf = std::pow(10, -3 + 3 * u(rng));
  p.tm = (0.1 + 0.8 * u(rng)) * p.tf;
  p.tr = -0.5 * u(rng) * p.tf * static_cast<double>(rng() % 2);
  p.s = 0.99 * u(rng);
  p.beta = 1.2 * (u(rng) - 0.5);
  return p;
}

TEST(ClosedForm, IntegratesTheParabolasAndLinesOfEquations217To220) {
  // The stresses are those of this file, the integral of the polynomials is a Gauss rule that is exact to rounding
  // for them. What is left is rounding of the stresses: z = r (cos theta - cos theta_f) as printed loses digits at
  // small arcs (1e-16/theta^2), times n.
  std::mt19937 rng(21);
  double quadratic = 0, linear = 0;
  for (int row = 0; row < 3000; ++row) {
    const Printed p = random_row(rng);
    const Six q = p.parabolas({p.tr, p.tm, p.tf}), l = p.lines();
    const Six a = six(closed_form(p.force_case(), Method::quadratic)),
              d = six(closed_form(p.force_case(), Method::linear));
    const double rounding = 1e-12 + 3e-15 / (p.tf * p.tf);
    for (int i = 0; i < 6; ++i) {
      const double lever = i < 3 ? 1 : p.r;
      quadratic = std::max(quadratic, std::abs(a[i] - q[i]) / (size(q) * lever) / rounding);
      linear = std::max(linear, std::abs(d[i] - l[i]) / (size(l) * lever) / rounding);
    }
  }
  EXPECT_LT(quadratic, 1);
  EXPECT_LT(linear, 1);
}

TEST(ClosedForm, ReproducesFigure215) {
  // Published to 0.01 %. Its grid of slips and angles is not printed, so a mean may differ by the share of its
  // corners: 0.03 points where the error is nearly constant (quadratic), and one tenth of the mean for the linear
  // form, whose error runs over the grid.
  const Printed p = dissertation(kSoils[1], false, 30 * deg);
  const auto q = errors(p, library(Method::quadratic));
  const double published[4] = {0.11, 0.04, 1.96, 1.35}, spread[4] = {0.04, 0.03, 0.05, 0.13};
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(q[c].mean, published[c], 0.03) << c;
    EXPECT_NEAR(q[c].sd, spread[c], 0.03) << c;
  }
  const auto l = errors(p, library(Method::linear));
  const double published_linear[4] = {1.51, 0.60, 20.37, 13.19}, of_linear[4] = {0.3, 0.2, 0.2, 0.5};
  for (int c = 0; c < 4; ++c) {
    EXPECT_NEAR(l[c].mean, published_linear[c], of_linear[c]) << c;
    RecordProperty("linear" + std::to_string(c), std::to_string(l[c].mean) + " +- " + std::to_string(l[c].sd));
    RecordProperty("quadratic" + std::to_string(c), std::to_string(q[c].mean) + " +- " + std::to_string(q[c].sd));
  }
}

TEST(ClosedForm, QuadraticIsNearTheIntegralForBothWheelsAndThreeSoils) {
  // Fig 2.16's range; its own numbers are lost. The text: "lower by an order of magnitude" than linear. Clayey soil
  // (n = 0.5) is the worst.
  for (const Named& soil : kSoils)
    for (const bool lugged : {false, true})
      for (const double theta_f : {20., 30., 40., 50.}) {
        const Printed p = dissertation(soil, lugged, theta_f * deg);
        const auto q = errors(p, library(Method::quadratic)), l = errors(p, library(Method::linear));
        const std::string where = std::string(soil.name) + (lugged ? " L " : " S ") + std::to_string(theta_f);
        EXPECT_LT(q[2].mean, 5) << where;
        EXPECT_LT(q[3].mean, 5) << where;
        EXPECT_LT(q[0].mean, lugged && theta_f < 25 ? 2.5 : 0.6) << where;  // the tips alone press there, Fz is small
        EXPECT_LT(q[2].mean, 0.5 * l[2].mean) << where;
      }
}

TEST(ClosedForm, WithLugsTheCutAtTheConcaveEntryIsNearerThanTheEquivalentAngle) {
  // Eq 2.16's theta_feq replaces theta_f "to simplify the derivations". Readings of eq 2.17 with eq 2.15's stresses:
  // front parabola to theta_feq; front parabola to theta_ft; two front parabolas that meet at theta_fca (the
  // library's).
  double cut = 0, equivalent = 0, tip = 0;
  for (const Named& soil : kSoils)
    for (const double theta_f :
         {30., 40., 50.}) {  // at 20 degrees theta_feq lies behind theta_m: that reading has no front branch
      const Printed p = dissertation(soil, true, theta_f * deg);
      const double feq = p.mu * p.tf + (1 - p.mu) * p.theta_fca();
      cut = std::max(cut, errors(p, library(Method::quadratic))[2].mean);
      tip = std::max(tip, errors(p, [](const Printed& x) { return x.parabolas({x.tr, x.tm, x.tf}); })[2].mean);
      equivalent = std::max(equivalent, errors(p,
                                               [&](const Printed& x) {
                                                 return x.parabolas({x.tr, x.tm, feq});
                                               })[2]
                                            .mean);
    }
  RecordProperty("cut", std::to_string(cut));
  RecordProperty("tip", std::to_string(tip));
  RecordProperty("equivalent", std::to_string(equivalent));
  EXPECT_LT(cut, tip);
  EXPECT_LT(cut, equivalent);
}

TEST(ClosedForm, FollowsAReloadingWheelToAFewPercent) {
  // Eq 2.12: cut where the wheel touches and where virgin soil begins. One parabola over all of it would be off by
  // tens of percent.
  double worst = 0;
  for (const bool lugged : {false, true})
    for (const double share : {0.2, 0.6, 0.9, 0.99, 1.01})  // of the deepest point
      for (const double slip : {-0.3, 0.1, 0.6}) {
        Printed p = dissertation(kSoils[1], lugged, 30 * deg);
        p.zu = share * p.rs() * (std::cos(p.tm) - std::cos(p.tf));
        p.Au = 503e6;
        p.ko = 1e7;
        p.s = slip;
        p.beta = 0.1;
        const Six t = p.integral(), q = six(closed_form(p.force_case(), Method::quadratic));
        for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(q[i] - t[i]) / size(t));
      }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 0.04);
}

TEST(ClosedForm, UnderBrakingIsContinuousInTheEntryAngleAndNearTheIntegral) {
  // Without slip angle the shear jumps where sliding turns, at cos theta = 1/kappa. Were it not cut there, the force
  // would jump whenever a node passes that angle, and a load inside the jump would have no entry angle. K = 2 mm, so
  // that the jump is large.
  double error = 0, jump = 0, uncut = 0;
  for (const double s : {-0.02, -0.05, -0.1, -0.3}) {
    Printed p = dissertation(kSoils[1], false, 30 * deg);
    p.K = 0.002;
    p.s = s;
    Six last{}, last_two{};
    for (int k = 0; k <= 4000; ++k) {
      p.tf = (20 + 30 * k / 4000.0) * deg;
      p.tm = 0.5 * p.tf;
      const Six q = six(closed_form(p.force_case(), Method::quadratic)), two = p.parabolas({p.tr, p.tm, p.tf});
      for (int i = 0; i < 6 && k > 0; ++i) {
        const double lever = i < 3 ? 1 : p.r;
        jump = std::max(jump, std::abs(q[i] - last[i]) / (size(q) * lever));
        uncut = std::max(uncut, std::abs(two[i] - last_two[i]) / (size(q) * lever));
      }
      last = q;
      last_two = two;
      if (k % 1000 != 0) continue;
      const double turn = std::acos(1 + s);
      std::vector<double> cuts{p.tr, p.tm, p.tf};
      if (turn < p.tf) cuts.push_back(turn);
      std::sort(cuts.begin(), cuts.end());
      Six t{};
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
        for (int part = 0; part < 200; ++part) {
          const double d = (cuts[i + 1] - cuts[i]) / 200;
          p.add(t, cuts[i] + part * d, cuts[i] + (part + 1) * d, [&](double th) { return p.stress(th); });
        }
      for (const int i : {0, 2}) error = std::max(error, std::abs(q[i] - t[i]) / size(t));
    }
  }
  RecordProperty("error", std::to_string(error));
  RecordProperty("jump", std::to_string(jump));
  RecordProperty("uncut", std::to_string(uncut));
  EXPECT_LT(jump, 0.003);  // a step of 0.0075 degrees changes Fz by 0.1 %
  EXPECT_GT(uncut, 0.03);
  EXPECT_LT(error, 0.08);
}

TEST(ClosedForm, DerivativesAreThoseOfTheForm) {
  std::mt19937 rng(5);
  for (int row = 0; row < 200; ++row) {
    Printed p = random_row(rng);
    if (row % 2 == 0) p.hg = 0.05 * p.r, p.mu = 0.2;
    const ForceCase c = p.force_case();
    const ShearState e = shear_state(kappa_of_slip(c.slip), c.slip_angle);
    const auto at = [&](double t, double l) {
      double pz;
      return six(closed_form(Arc(c.wheel, c.soil, c.arc, {e.t + t, e.l + l}), Method::quadratic, pz));
    };
    const WheelForces f = closed_form_forces(Arc(c.wheel, c.soil, c.arc, e), Method::quadratic);
    const Six w = at(0, 0), mine{f.Fx, f.Fy, f.Fz, f.Mx, f.My, f.Mz};
    const double d = 1e-6, force = size(w), speed = std::hypot(1 - (1 - e.t), e.l);
    for (int i = 0; i < 6; ++i) {
      const double lever = i < 3 ? 1 : p.rs();
      EXPECT_NEAR(mine[i], w[i], 1e-12 * force * lever);
      if (speed < 0.05) continue;  // the direction turns within the step of the difference
      const double scale = force * lever * (1 + p.r / p.K) / speed;
      EXPECT_NEAR(f.d_t[i], (at(d, 0)[i] - at(-d, 0)[i]) / (2 * d), 1e-4 * scale) << row << " " << i;
      EXPECT_NEAR(f.d_l[i], (at(0, d)[i] - at(0, -d)[i]) / (2 * d), 1e-4 * scale) << row << " " << i;
    }
  }
}

TEST(ClosedForm, LockedWheelIsFullyMobilised) {
  // Uniform pressure is not possible, cohesion alone is: no friction, tau = c against travel, so that My = r^2 b c
  // (theta_f - theta_r).
  Printed p = dissertation(kSoils[2], false, 30 * deg);
  p.tan_phi = 0;
  p.s = -1;
  const WheelWrench w = closed_form(p.force_case(), Method::quadratic);
  EXPECT_NEAR(w.My, p.r * p.r * p.b * p.c * p.tf, 1e-12);
}

}  // namespace
}  // namespace grouser::bekker
