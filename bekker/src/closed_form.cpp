#include "closed_form.h"

#include <algorithm>
#include <cmath>

#include "lanes.h"

namespace grouser::bekker {

namespace {

constexpr double kInside = 1e-9;  // of a piece: a node at the edge of touching soil is taken from inside

/// s = sin(h)/h and d = (sin h - h cos h)/h^3 for |h| <= pi/2, by their series: the second loses all digits as
/// written for small h.
struct Moments {
  Lanes s, d;
};
constexpr std::array<double, 12> kS = [] {
  std::array<double, 12> c{};
  double f = 1;
  for (int k = 0; k < 12; ++k) {
    c[k] = f;
    f /= -(2.0 * k + 2) * (2.0 * k + 3);
  }
  return c;
}();
constexpr std::array<double, 12> kD = [] {
  std::array<double, 12> c{};
  double f = 1.0 / 6;  // 1/(2k + 3)!
  for (int k = 0; k < 12; ++k) {
    c[k] = (2 * k + 2) * f;
    f /= -(2.0 * k + 4) * (2.0 * k + 5);
  }
  return c;
}();
template <int kTerms>
Moments moments(Lanes x) {  // pairs by x^2: half as long a chain
  const Lanes x2 = x * x;
  Lanes s{}, d{};
  for (int k = kTerms - 2; k >= 0; k -= 2) {
    s = s * x2 + (kS[k] + x * kS[k + 1]);
    d = d * x2 + (kD[k] + x * kD[k + 1]);
  }
  return {s, d};
}

/// Ends of the pieces, in order.
class Cuts {
 public:
  struct Cut {
    double theta;
    bool jump;  ///< the stresses on both sides differ
  };
  explicit Cuts(const Arc& a) {
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

}  // namespace

int ProductRule::node(double theta) {
  theta_[n_] = theta;
  return n_++;
}

ProductRule::ProductRule(const Arc& arc, Method method) : parabola_(method == Method::quadratic) {
  const Cuts cuts(arc);
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
void ProductRule::weigh() {
  for (int first = 0; first < pieces_; first += kLanes) {
    const int count = std::min(kLanes, pieces_ - first);
    Lanes from, to;
    for (int k = 0; k < kLanes; ++k) {
      const Piece& p = piece_[first + std::min(k, count - 1)];
      from[k] = p.from;
      to[k] = p.to;
    }
    const Lanes h = 0.5 * (to - from), x = h * h;
    const SinCos<Lanes> quarter = sin_cos_half(0.25 * (to + from));
    const Lanes sin_m = 2 * quarter.sin * quarter.cos, cos_m = 1 - 2 * quarter.sin * quarter.sin;
    bool small = true;
    for (int k = 0; k < kLanes; ++k) small = small && x[k] < 0.3;
    const Moments q = small ? moments<8>(x) : moments<12>(x);
    const Lanes end = h * (parabola_ ? q.s - 2 * q.d : q.s), odd = x * q.d, centre = 4 * h * q.d;
    const Lanes sine_a = sin_m * end - cos_m * odd, cosine_a = cos_m * end + sin_m * odd;
    const Lanes sine_b = sin_m * end + cos_m * odd, cosine_b = cos_m * end - sin_m * odd;
    const Lanes sine_m = sin_m * centre, cosine_m = cos_m * centre;
    for (int k = 0; k < count; ++k) {
      const Piece& p = piece_[first + k];
      const double one = parabola_ ? h[k] / 3 : h[k];
      one_[p.a] = p.shared ? one_[p.a] + one : one;
      sine_[p.a] = p.shared ? sine_[p.a] + sine_a[k] : sine_a[k];
      cosine_[p.a] = p.shared ? cosine_[p.a] + cosine_a[k] : cosine_a[k];
      one_[p.b] = one;
      sine_[p.b] = sine_b[k];
      cosine_[p.b] = cosine_b[k];
      if (parabola_) {
        one_[p.middle] = 4 * one;
        sine_[p.middle] = sine_m[k];
        cosine_[p.middle] = cosine_m[k];
      } else if (p.rear) {  // eq 2.20: the rear line ends in p_m + p_r
        one_[p.a] += one;
        sine_[p.a] += sine_b[k];
        cosine_[p.a] += cosine_b[k];
      }
    }
  }
}

WheelWrench closed_form(const Arc& arc, Method method, double& pressure_z) {
  ProductRule rule(arc, method);
  double px = 0, pz = 0, tx = 0, tz = 0, t = 0, l = 0, lx = 0, lz = 0;
  std::array<ArcStress, 8> stress;
  for (int start = 0; start < rule.size(); start += 8) {
    const int count = std::min(8, rule.size() - start);
    stresses_at(arc, rule.angles() + start, count, stress.data());
    if (start == 0) rule.weigh();  // after the stresses, so that the processor does both at once
    for (int k = 0; k < count; ++k) {
      const int i = start + k;
      const ArcStress& s = stress[k];
      px -= s.sigma * rule.sine(i);
      pz += s.sigma * rule.cosine(i);
      tx += s.tau_t * rule.cosine(i);
      tz += s.tau_t * rule.sine(i);
      t += s.tau_t * rule.one(i);
      l += s.tau_l * rule.one(i);
      lx += s.tau_l * rule.cosine(i);
      lz += s.tau_l * rule.sine(i);
    }
  }
  const double rb = arc.r * arc.b, rrb = arc.r * rb;
  pressure_z = rb * pz;
  return {rb * (px + tx), -rb * l, rb * (pz + tz), -rrb * lx, -rrb * t, -rrb * lz};
}

WheelWrench closed_form(const ForceCase& c, Method method) {
  double pressure_z;
  return closed_form(Arc(c), method, pressure_z);
}

WheelForces closed_form_forces(const Arc& arc, Method method) {
  ProductRule rule(arc, method);
  rule.weigh();
  WheelForces out;
  const double rb = arc.r * arc.b, rrb = arc.r * rb;
  const auto add = [&](std::array<double, 6>& d, int i, double t, double l) {
    d[0] += rb * t * rule.cosine(i);
    d[1] -= rb * l * rule.one(i);
    d[2] += rb * t * rule.sine(i);
    d[3] -= rrb * l * rule.cosine(i);
    d[4] -= rrb * t * rule.one(i);
    d[5] -= rrb * l * rule.sine(i);
  };
  std::array<double, 6> shear{};
  for (int i = 0; i < rule.size(); ++i) {
    ArcSlope slope;
    const ArcStress s = stress_at(arc, rule.angles()[i], slope);
    out.pressure_x -= rb * s.sigma * rule.sine(i);
    out.pressure_z += rb * s.sigma * rule.cosine(i);
    out.capacity += rb * arc.tan_phi * s.sigma * rule.one(i);
    add(shear, i, s.tau_t, s.tau_l);
    add(out.d_t, i, slope.tau_t_by_t, slope.tau_l_by_t);
    add(out.d_l, i, slope.tau_t_by_l, slope.tau_l_by_l);
  }
  out.capacity += rb * arc.cohesion * (arc.theta_f - arc.theta_r);
  out.Fx = out.pressure_x + shear[0];
  out.Fy = shear[1];
  out.Fz = out.pressure_z + shear[2];
  out.Mx = shear[3];
  out.My = shear[4];
  out.Mz = shear[5];
  out.evaluations = rule.size();
  return out;
}

}  // namespace grouser::bekker
