#pragma once
// Linear and quadratic closed forms of the wheel force (eqs 2.17 to 2.20), written as product integration: the
// integrals of eq 2.11 of a parabola or a straight line through stresses at a few angles are weighted sums of these
// stresses. For the lanes of the unit that includes it.
#include <algorithm>
#include <array>
#include <cmath>

#include "arc.h"
#include "lanes.h"

namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE {

inline constexpr double kInside = 1e-9;  // of a piece: a node at the edge of touching soil is taken from inside

/// s = sin(h)/h and d = (sin h - h cos h)/h^3 for |h| <= pi/2, by their series: the second loses all digits as
/// written for small h.
struct Moments {
  double s, d;
};
inline constexpr std::array<double, 12> kS = [] {
  std::array<double, 12> c{};
  double f = 1;
  for (int k = 0; k < 12; ++k) {
    c[k] = f;
    f /= -(2.0 * k + 2) * (2.0 * k + 3);
  }
  return c;
}();
inline constexpr std::array<double, 12> kD = [] {
  std::array<double, 12> c{};
  double f = 1.0 / 6;  // 1/(2k + 3)!
  for (int k = 0; k < 12; ++k) {
    c[k] = (2 * k + 2) * f;
    f /= -(2.0 * k + 4) * (2.0 * k + 5);
  }
  return c;
}();
template <int kTerms>
GROUSER_INLINE Moments moments(double x) {  // pairs by x^2: half as long a chain
  const double x2 = x * x;
  double s = 0, d = 0;
  for (int k = kTerms - 2; k >= 0; k -= 2) {
    s = s * x2 + (kS[k] + x * kS[k + 1]);
    d = d * x2 + (kD[k] + x * kD[k + 1]);
  }
  return {s, d};
}

/// Ends of the pieces, in order.
class ClosedFormCuts {
 public:
  struct Cut {
    double theta;
    bool jump;  ///< the stresses on both sides differ
  };
  explicit ClosedFormCuts(const Arc& a) {
    add(a.theta_r, false);
    if (a.theta_m > a.theta_r) add(a.theta_m, false);
    if (a.concave) add(a.theta_ca, false);
    add(a.theta_f, false);
    if (a.zu > 0) add_reloading(a);
    // Braking: sliding turns round at cos theta = 1/kappa.
    if (a.e.t < 0 && !a.anisotropic && !a.locked && (1 - a.e.t) * a.cos_f < 1) {
      const double turn = std::acos(1 / (1 - a.e.t));
      add(turn, true);
      if (-turn > a.theta_r) add(-turn, true);
    }
  }
  int size() const { return n_; }
  const Cut& operator[](int i) const { return cuts_[i]; }

 private:
  void add(double theta, bool jump) {
    int i = n_++;
    for (; i > 0 && cuts_[i - 1].theta > theta; --i) cuts_[i] = cuts_[i - 1];
    cuts_[i] = {theta, jump};
  }
  /// Eq 2.12: where a surface begins to press (there cohesion jumps) and where virgin soil begins.
  void add_reloading(const Arc& a) {
    const double touch = a.zu - a.peak / a.slope;
    const auto surface = [&](double r, double entry, double cos_entry, double stretch) {
      for (const double depth : {touch, a.zu}) {
        const double cosine = cos_entry + depth / r;
        if (!(depth > 0) || !(cosine < 1)) continue;
        const double theta = std::acos(cosine);
        if (!(theta > a.theta_m)) continue;
        add(theta, depth == touch);
        if (stretch > 0) add(a.theta_r + (entry - theta) / stretch, depth == touch);
      }
    };
    surface(a.r, a.theta_f, a.cos_f, a.stretch);
    if (a.concave) surface(a.r_ca, a.theta_ca, a.cos_ca, a.stretch_ca);
  }

  int n_ = 0;
  std::array<Cut, 16> cuts_;
};

/// Angles and weights of one arc: integral of p(theta) {1, sin theta, cos theta} over the arc = sum of p_i {one_i,
/// sine_i, cosine_i} for every stress p (eqs 2.18 and 2.19 collected by stress). Pieces: rear and front branch (eq
/// 2.17); with lugs the front branch is cut where the concave tread enters; a reloading wheel also where it touches
/// and where virgin soil begins (eq 2.12); under braking where sliding turns round. Exact in the stresses to rounding
/// at any length of arc: no division by its length occurs.
class ProductRule {
 public:
  static constexpr int kMost = 48;
  ProductRule(const Arc& arc, Method method);  ///< the angles
  void weigh();                                ///< the weights

  int size() const { return n_; }
  const double* angles() const { return theta_.data(); }
  double one(int i) const { return one_[i]; }
  double sine(int i) const { return sine_[i]; }
  double cosine(int i) const { return cosine_[i]; }

 private:
  struct Piece {
    double from, to;
    int a, middle, b;  ///< nodes
    bool shared;       ///< a is the last piece's b
    bool rear;         ///< the whole rear branch
  };
  int node(double theta);

  bool parabola_;
  int n_ = 0, pieces_ = 0;
  std::array<double, kMost> theta_, one_, sine_, cosine_;
  std::array<Piece, 16> piece_;
};

inline int ProductRule::node(double theta) {
  theta_[n_] = theta;
  return n_++;
}

inline ProductRule::ProductRule(const Arc& arc, Method method) : parabola_(method == Method::quadratic) {
  const ClosedFormCuts cuts(arc);
  int a = -1;  // node at the start of the next piece, shared with the last one
  for (int i = 0; i + 1 < cuts.size(); ++i) {
    const double from = cuts[i].theta, to = cuts[i + 1].theta;
    if (!(to > from)) continue;
    const double inset = kInside * (to - from);
    const bool shared = a >= 0;
    if (!shared) a = node(cuts[i].jump ? from + inset : from);
    const int middle = parabola_ ? node(0.5 * (from + to)) : a, b = node(cuts[i + 1].jump ? to - inset : to);
    piece_[pieces_++] = {from, to, a, middle, b, shared, from <= arc.theta_r && to <= arc.theta_m};
    a = cuts[i + 1].jump ? -1 : b;
  }
  // The stresses at the entry are zero; a locked wheel alone mobilises the cohesion there, which the straight line
  // leaves out.
  if (!(parabola_ && arc.locked)) --n_;
}

// With theta = m + x, x in [-h, h], and the even and odd part of p about m:
//   integral p cos theta = cos m E - sin m O,  integral p sin theta = sin m E + cos m O,
//   E = integral p cos x = h [2 S p_m + (S - 2 D)(p_a + p_b - 2 p_m)]  (parabola),  h S (p_a + p_b)  (straight line),
//   O = integral p sin x = h^2 D (p_b - p_a),   S = sin(h)/h,  D = (sin h - h cos h)/h^3.
inline void ProductRule::weigh() {
  for (int i = 0; i < pieces_; ++i) {
    const Piece& p = piece_[i];
    const double h = 0.5 * (p.to - p.from), x = h * h;
    const SinCos<double> half = sin_cos_polynomial(0.25 * (p.to + p.from));
    const double sin_m = 2 * half.sin * half.cos, cos_m = 1 - 2 * half.sin * half.sin;
    const Moments q = x < 0.3 ? moments<8>(x) : moments<12>(x);
    const double end = h * (parabola_ ? q.s - 2 * q.d : q.s), odd = x * q.d;
    const double sine_b = sin_m * end + cos_m * odd, cosine_b = cos_m * end - sin_m * odd;
    const double one = parabola_ ? h / 3 : h;
    const auto add = [this](int node, double w, double sine, double cosine, bool more) {
      one_[node] = more ? one_[node] + w : w;
      sine_[node] = more ? sine_[node] + sine : sine;
      cosine_[node] = more ? cosine_[node] + cosine : cosine;
    };
    add(p.a, one, sin_m * end - cos_m * odd, cos_m * end + sin_m * odd, p.shared);
    add(p.b, one, sine_b, cosine_b, false);
    if (parabola_) {
      const double centre = 4 * h * q.d;
      add(p.middle, 4 * one, sin_m * centre, cos_m * centre, false);
    } else if (p.rear) {  // eq 2.20: the rear line ends in p_m + p_r
      add(p.a, one, sine_b, cosine_b, true);
    }
  }
}

}  // namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE
