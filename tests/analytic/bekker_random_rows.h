#pragma once
// Random rows of `forces` and their integrals by a rule and a code path of their own: equations 2.4 to 2.15 written out
// point by point in long double, kinks found by scanning the arc, tanh-sinh on each piece. Nothing here is shared with
// the library.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "grouser/bekker/forces.h"

namespace grouser::bekker::test_rows {

/// Real is double where a million rows are to be done, long double where the last digits count.
template <class Real>
class WrittenOutIn {
 public:
  explicit WrittenOutIn(const ForceCase& c)
      : c_(c), rs_(Real(c.wheel.radius) + c.wheel.lug_height), f_(c.arc.theta_f), m_(c.arc.theta_m), r_(c.arc.theta_r) {
    const Real hf = rs_ * (1 - std::cos(f_)), hg = c.wheel.lug_height;
    fca_ = hf > hg ? std::acos((rs_ - hf) / Real(c.wheel.radius)) : 0;
    locked_ = c.slip == -1;
    kappa_ = c.slip >= 0 ? 1 - Real(c.slip) : (locked_ ? 1 : 1 / (1 + Real(c.slip)));
  }

  Real depth(Real theta, Real radius, Real entry) const {
    const Real te = theta >= m_ ? theta : entry - (theta - r_) * (entry - m_) / (m_ - r_);
    return 2 * radius * std::sin((entry + te) / 2) * std::sin((entry - te) / 2);  // cos te - cos entry
  }
  Real tip_depth(Real theta) const { return depth(theta, rs_, f_); }
  Real concave_depth(Real theta) const {
    return fca_ > m_ && theta < fca_ ? depth(theta, Real(c_.wheel.radius), fca_) : Real(-1);
  }
  Real pressure(Real z) const {
    if (z <= 0) return 0;
    const Real zu = c_.unloading_sinkage, n = c_.soil.n, k = c_.soil.modulus;
    if (z >= zu) return k * std::pow(z, n);
    return std::max(Real(0), k * std::pow(zu, n) - (Real(c_.soil.ko) + c_.soil.Au * zu) * (zu - z));
  }
  Real share(Real j) const {
    const ShearLaw& s = c_.soil.shear;
    const Real e = std::exp(Real(1)), x = j / (s.type == ShearLaw::Type::A ? s.K : s.Kw);
    switch (s.type) {
      case ShearLaw::Type::A:
        return 1 - std::exp(-x);
      case ShearLaw::Type::B:
        return x * std::exp(1 - x);
      case ShearLaw::Type::C:
        return s.Kr * (1 + (1 / (s.Kr * (1 - 1 / e)) - 1) * std::exp(1 - x)) * (1 - std::exp(-x));
    }
    return 0;
  }
  Real jt(Real theta) const { return rs_ * ((f_ - theta) - kappa_ * (std::sin(f_) - std::sin(theta))); }
  Real vt(Real theta) const {
    const Real h = std::sin(theta / 2);
    return locked_ ? -std::cos(theta) : (1 - kappa_) + kappa_ * 2 * h * h;
  }

  std::array<Real, 6> density(Real th) const {
    Real sigma = pressure(tip_depth(th));
    if (c_.wheel.lug_height > 0)
      sigma = c_.wheel.lug_ratio * sigma + (1 - Real(c_.wheel.lug_ratio)) * pressure(concave_depth(th));
    Real cap = c_.soil.shear.cohesion + sigma * c_.soil.tan_phi;
    if (c_.unloading_sinkage > 0 && !(sigma > 0)) cap = 0;
    if (c_.wheel.lug_height > 0 && c_.wheel.lug_ratio == 0 && !(fca_ > m_ && fca_ > 0)) cap = 0;  // nothing touches
    const Real tb = std::tan(Real(c_.slip_angle)), t = jt(th), l = rs_ * kappa_ * (f_ - th) * tb;
    const auto sign = [](Real x) { return Real((x > 0) - (x < 0)); };
    Real tt, tl;
    if (c_.soil.lateral == Lateral::anisotropic) {
      const Real full = c_.soil.shear.type == ShearLaw::Type::A   ? 1
                        : c_.soil.shear.type == ShearLaw::Type::B ? 0
                                                                  : c_.soil.shear.Kr;
      tt = locked_ ? -full * cap : cap * share(std::abs(t)) * sign(t);
      tl = locked_ ? full * cap * sign(tb) : cap * share(std::abs(l)) * sign(l);
    } else {
      const Real full = c_.soil.shear.type == ShearLaw::Type::A   ? 1
                        : c_.soil.shear.type == ShearLaw::Type::B ? 0
                                                                  : c_.soil.shear.Kr;
      const Real v = vt(th), w = locked_ ? tb : kappa_ * tb, norm = std::hypot(v, w);
      const Real tau = cap * (locked_ ? full : share(std::hypot(t, l)));
      tt = norm > 0 ? tau * v / norm : 0;
      tl = norm > 0 ? tau * w / norm : 0;
    }
    const Real s = std::sin(th), co = std::cos(th);
    return {-sigma * s + tt * co, -tl, sigma * co + tt * s, -tl * co, -tt, -tl * s};
  }

  /// Ends of the smooth pieces: sign changes of everything whose sign matters, from 100 samples a part and bisection.
  /// Between the turns of the sliding, where j_t is greatest or least, and the bottom everything is monotone: j_t has at
  /// most one zero a part, however close the turn is to the entry, where j_t is zero too.
  std::vector<Real> ends() const {
    const Real zu = c_.unloading_sinkage;
    const Real slope = Real(c_.soil.ko) + c_.soil.Au * zu;
    const Real z0 = zu > 0 ? zu - c_.soil.modulus * std::pow(zu, Real(c_.soil.n)) / slope : 0;
    std::vector<Real> out{r_, m_, f_};
    if (r_ < 0) out.push_back(0);  // the sliding velocity is least at the bottom
    if (c_.wheel.lug_height > 0 && fca_ > m_) out.push_back(fca_);
    std::vector<Real> marks{r_, m_, f_};
    if (r_ < 0) marks.push_back(0);  // signs change in pairs about the bottom
    const std::vector<Real> turns = zeros([&](Real t) { return vt(t); }, marks);
    marks.insert(marks.end(), turns.begin(), turns.end());
    out.insert(out.end(), turns.begin(), turns.end());
    const std::vector<std::function<Real(Real)>> signs{[&](Real t) { return jt(t); },
                                                       [&](Real t) { return tip_depth(t) - zu; },
                                                       [&](Real t) { return tip_depth(t) - z0; },
                                                       [&](Real t) { return concave_depth(t) - zu; },
                                                       [&](Real t) { return concave_depth(t) - z0; },
                                                       [&](Real t) { return concave_depth(t); }};
    for (const auto& g : signs) {
      const std::vector<Real> at = zeros(g, marks);
      out.insert(out.end(), at.begin(), at.end());
    }
    std::sort(out.begin(), out.end());
    return out;
  }

  /// Force [N] and moment [N m].
  std::array<double, 6> integral() const {
    const std::vector<Real> e = ends();
    std::array<Real, 6> total{};
    for (std::size_t i = 0; i + 1 < e.size(); ++i)
      if (e[i + 1] - e[i] > Real(1e-15)) {
        const auto part = tanh_sinh(e[i], e[i + 1]);
        for (int k = 0; k < 6; ++k) total[k] += part[k];
      }
    std::array<double, 6> out;
    for (int k = 0; k < 6; ++k) out[k] = double(total[k] * rs_ * c_.wheel.width * (k < 3 ? Real(1) : rs_));
    return out;
  }

 private:
  static std::vector<Real> zeros(const std::function<Real(Real)>& g, std::vector<Real> marks) {
    std::sort(marks.begin(), marks.end());
    std::vector<Real> out;
    const int samples = 100;
    for (std::size_t part = 0; part + 1 < marks.size(); ++part) {
      const Real lo = marks[part], hi = marks[part + 1];
      for (int i = 0; i < samples && hi > lo; ++i) {
        Real a = lo + (hi - lo) * i / samples, b = lo + (hi - lo) * (i + 1) / samples;
        const Real fa = g(a);
        if (!(fa * g(b) < 0)) continue;
        for (int k = 0; k < 64; ++k) {
          const Real h = (a + b) / 2;
          ((g(h) < 0) == (fa < 0) ? a : b) = h;
        }
        out.push_back((a + b) / 2);
      }
    }
    return out;
  }

  /// Trapezoidal rule in t after theta = middle + half tanh(pi/2 sinh t), halved until two results agree to 1e-12
  /// of the piece, at least to steps of 0.05: where shear builds up within 1e-8 of the arc, coarser steps in t can miss
  /// the layer and agree.
  std::array<Real, 6> tanh_sinh(Real a, Real b) const {
    const Real half = (b - a) / 2, reach = Real(3.4), quarter = std::acos(Real(-1)) / 2;
    const auto at = [&](Real t, std::array<Real, 6>& sum) {
      const Real s = quarter * std::sinh(t), c = std::cosh(s), w = quarter * std::cosh(t) / (c * c);
      const Real inset = half * std::exp(-std::abs(s)) / c;  // distance to the nearer end
      const auto d = density(s < 0 ? a + inset : b - inset);
      for (int k = 0; k < 6; ++k) sum[k] += w * d[k];
    };
    std::array<Real, 6> sum{}, last{};
    Real step = reach / 8;
    for (int i = -8; i <= 8; ++i) at(i * step, sum);
    for (int level = 0; level < 9; ++level) {
      for (int k = 0; k < 6; ++k) last[k] = sum[k] * step * half;
      const int n = 8 << level;
      for (int i = -n; i < n; ++i) at((i + Real(0.5)) * step, sum);
      step /= 2;
      Real size[2] = {0, 0}, gap[2] = {0, 0};
      for (int k = 0; k < 6; ++k) {
        size[k / 3] += std::abs(sum[k] * step * half);
        gap[k / 3] += std::abs(sum[k] * step * half - last[k]);
      }
      if (level > 2 && gap[0] <= Real(1e-12) * size[0] && gap[1] <= Real(1e-12) * size[1]) break;
    }
    for (int k = 0; k < 6; ++k) sum[k] *= step * half;
    return sum;
  }

  ForceCase c_;
  Real rs_, f_, m_, r_, fca_ = 0, kappa_ = 1;
  bool locked_ = false;
};
using WrittenOut = WrittenOutIn<long double>;

/// Every feature of the law, with its awkward corners.
inline ForceCase any_row(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto u = [&](double lo, double hi) { return lo + (hi - lo) * uniform(rng); };
  const auto chance = [&](double p) { return uniform(rng) < p; };
  const auto decade = [&](double lo, double hi) { return std::pow(10.0, u(std::log10(lo), std::log10(hi))); };
  ForceCase c;
  c.wheel.radius = u(0.04, 0.6);
  c.wheel.width = u(0.03, 0.4);
  c.soil.n = chance(0.1) ? 1 : u(0.3, 2);
  c.soil.modulus = decade(1e4, 1e7) / std::pow(0.05, c.soil.n - 1);
  c.soil.shear.type = static_cast<ShearLaw::Type>(rng() % 3);
  c.soil.shear.cohesion = chance(0.2) ? 0 : u(0, 5000);
  c.soil.shear.friction_angle = u(0.1, 0.75);
  c.soil.tan_phi = std::tan(c.soil.shear.friction_angle);
  c.soil.shear.K = decade(5e-4, 4e-2);
  c.soil.shear.Kw = decade(2e-3, 5e-2);
  c.soil.shear.Kr = u(0.3, 1);
  if (chance(0.3)) c.soil.lateral = Lateral::anisotropic;
  c.arc.theta_f = u(0.05, 1.3);
  // theta_m anywhere from behind the bottom to a thousandth of theta_f below the entry.
  const double where = uniform(rng);
  c.arc.theta_m = c.arc.theta_f * (where < 0.08   ? 0
                                   : where < 0.14 ? u(-0.5, 0)
                                   : where < 0.24 ? decade(0.01, 0.1)
                                   : where < 0.6  ? u(0.05, 0.7)
                                   : where < 0.9  ? u(0.7, 0.99)
                                                  : 1 - decade(1e-3, 1e-1));
  c.arc.theta_r = chance(0.4) ? 0 : -c.arc.theta_f * u(0, 0.9);
  if (c.arc.theta_r > c.arc.theta_m) c.arc.theta_r = c.arc.theta_m * u(1, 2);
  const double kind = uniform(rng);
  c.slip = kind < 0.05   ? -1
           : kind < 0.1  ? 1
           : kind < 0.15 ? 0
           : kind < 0.3  ? (chance(0.5) ? 1 : -1) * decade(1e-6, 1e-1)
                         : u(-0.98, 1);
  c.slip_angle = chance(0.25) ? 0 : (chance(0.5) ? 1 : -1) * (chance(0.3) ? decade(1e-5, 1e-1) : u(0, 1.2));
  if (chance(0.4)) {
    c.wheel.lug_height = c.wheel.radius * u(0.01, 0.3);
    c.wheel.lug_ratio = chance(0.1) ? 0 : chance(0.1) ? 1 : u(0.02, 0.9);
  }
  if (chance(0.4)) {
    const double deepest = c.wheel.outer_radius() * (std::cos(c.arc.theta_m) - std::cos(c.arc.theta_f));
    c.unloading_sinkage = deepest * u(0.05, 1.5);
    const double mean = c.soil.modulus * std::pow(c.unloading_sinkage, c.soil.n - 1);
    c.soil.ko = chance(0.5) ? 0 : mean * u(0, 2);
    c.soil.Au = mean * decade(0.3, 30) / c.unloading_sinkage;
  }
  return c;
}

/// The same over wider ranges, spread evenly over what decides how hard a row is: r/K 1 to 1000, entry 1 to 85 degrees,
/// slip within 1e-6 of -1, 0 and 1.
inline ForceCase wide_row(std::mt19937_64& rng) {
  ForceCase c = any_row(rng);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto u = [&](double lo, double hi) { return lo + (hi - lo) * uniform(rng); };
  const auto chance = [&](double p) { return uniform(rng) < p; };
  const auto decade = [&](double lo, double hi) { return std::pow(10.0, u(std::log10(lo), std::log10(hi))); };
  const double degree = std::acos(-1.0) / 180, before = c.arc.theta_f;
  c.soil.n = u(0.3, 2);
  c.soil.shear.K = c.soil.shear.Kw = c.wheel.outer_radius() / decade(1, 1000);
  c.arc.theta_f = chance(0.2) ? decade(1, 85) * degree : u(1, 85) * degree;
  c.arc.theta_m *= c.arc.theta_f / before;
  c.arc.theta_r *= c.arc.theta_f / before;
  const double kind = uniform(rng);
  c.slip = kind < 0.03   ? -1
           : kind < 0.06 ? 1
           : kind < 0.09 ? 0
           : kind < 0.15 ? -1 + decade(1e-6, 1e-1)
           : kind < 0.2  ? 1 - decade(1e-6, 1e-1)
           : kind < 0.3  ? (chance(0.5) ? 1 : -1) * decade(1e-6, 1e-1)
                         : u(-1, 1);
  if (c.unloading_sinkage > 0) {
    const double deepest = c.wheel.outer_radius() * (std::cos(c.arc.theta_m) - std::cos(c.arc.theta_f));
    c.unloading_sinkage = deepest * u(0.05, 1.5);
    const double mean = c.soil.modulus * std::pow(c.unloading_sinkage, c.soil.n - 1);
    c.soil.ko = chance(0.5) ? 0 : mean * u(0, 2);
    c.soil.Au = mean * decade(0.3, 30) / c.unloading_sinkage;
  }
  return c;
}

struct Gap {
  double force = 0, moment = 0;  ///< relative to |F| and |M|
};
inline Gap gap_of(const WheelWrench& w, const std::array<double, 6>& truth, double radius) {
  const std::array<double, 6> x{w.Fx, w.Fy, w.Fz, w.Mx, w.My, w.Mz};
  Gap g;
  double force = 0, moment = 0;
  for (int k = 0; k < 6; ++k) {
    (k < 3 ? g.force : g.moment) += (x[k] - truth[k]) * (x[k] - truth[k]);
    (k < 3 ? force : moment) += truth[k] * truth[k];
  }
  moment += 1e-40 * radius * radius * force;
  g.force = force > 0 ? std::sqrt(g.force / force) : (g.force > 0 ? 1 : 0);
  g.moment = moment > 0 ? std::sqrt(g.moment / moment) : (g.moment > 0 ? 1 : 0);
  return g;
}

}  // namespace grouser::bekker::test_rows
