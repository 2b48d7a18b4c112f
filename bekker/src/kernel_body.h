// Included by one unit per instruction set, which defines GROUSER_KERNEL.
#include "kernel.h"
#include "product_rule.h"
#include "rows_body.h"
#include "stress.h"

namespace grouser::bekker {
namespace {

/// Sums of eight vectors, each over its lanes.
GROUSER_INLINE void store_sums(const Lanes (&v)[8], double* out) {
#if GROUSER_LANES == 8
  Lanes a[4], b[2];
  for (int i = 0; i < 4; ++i)  // pairs of neighbours
    a[i] = __builtin_shufflevector(v[2 * i], v[2 * i + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(v[2 * i], v[2 * i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  for (int i = 0; i < 2; ++i)
    b[i] = __builtin_shufflevector(a[2 * i], a[2 * i + 1], 0, 1, 4, 5, 8, 9, 12, 13) +
           __builtin_shufflevector(a[2 * i], a[2 * i + 1], 2, 3, 6, 7, 10, 11, 14, 15);
  store(out, __builtin_shufflevector(b[0], b[1], 0, 1, 4, 5, 8, 9, 12, 13) +
                 __builtin_shufflevector(b[0], b[1], 2, 3, 6, 7, 10, 11, 14, 15));
#else
  for (int i = 0; i < 8; ++i) out[i] = sum_of(v[i]);
#endif
}

template <bool kFront>
GROUSER_INLINE Place<Lanes> place_on(const Arc& a, Lanes s) {
  if (kFront) return {s, s, s - (a.theta_f - a.theta_ca)};
  return {(a.theta_f - a.theta_r) - s, s * a.stretch, s * a.stretch_ca};
}

template <bool kFront>
GROUSER_INLINE void add_points(const Arc& a, const Piece& piece, const MappedRule& rule, double* out) {
  Lanes sum[8] = {}, null_l = {};
  for (int i = 0; i < rule.n; i += kLanes) {
    const Lanes s = piece.start + piece.length * load(rule.x + i), w = load(rule.w + i);
    const StressPoint<Lanes> p = stress_of<false>(a, place_on<kFront>(a, s), kFront);
    const Lanes sigma = w * p.sigma, t = w * p.tau_t, l = w * p.tau_l, null = load(rule.null + i);
    add_wrench(p, sigma, t, l, sum);
    sum[6] += null * sigma;
    sum[7] += null * t;
    null_l += null * l;
  }
  store_sums(sum, out);
  out[8] = sum_of(null_l);
}

ArcSines sines(double theta_f, double beta) {
  const SinCos<double> entry = sin_cos_polynomial(0.5 * theta_f), slip = sin_cos_polynomial(beta);
  return {entry.sin, entry.cos, slip.sin / slip.cos};
}

PieceSums integrate(const Arc& a, const Piece& piece, const MappedRule& rule) {
  alignas(64) double s[9];
  if (piece.front) {
    add_points<true>(a, piece, rule, s);
  } else {
    add_points<false>(a, piece, rule, s);
  }
  const double k = piece.length;
  return {k * s[0], k * s[1], k * s[2], k * s[3], k * s[4], k * s[5], k * s[6], k * s[7], k * s[8]};
}

template <bool kFront>
GROUSER_INLINE void add_slopes(const Arc& a, const Piece& piece, int p, int q, const GaussRule& rule, SlopeSums& out) {
  // phi(y) = c1 y + c2 y^2 + c3 y^3 for (p, q) = (1,1), (2,1), (1,2), (2,2).
  const double c1 = p == 1 ? q : 0, c2 = p == 1 ? 1 - q : 2 * q - 1, c3 = p == 2 ? 2 - 2 * q : 0;
  Lanes force[6] = {}, by_t[6] = {}, by_l[6] = {}, px{}, pz{}, capacity{};
  const auto add = [](Lanes(&sum)[6], Lanes t, Lanes l, Lanes s, Lanes c) [[gnu::always_inline]] {
    sum[0] += t * c;
    sum[1] -= l;
    sum[2] += t * s;
    sum[3] -= l * c;
    sum[4] -= t;
    sum[5] -= l * s;
  };
  for (int i = 0; i < rule.n; i += kLanes) {  // the rule's weights beyond n are zero
    const Lanes y = load(rule.x.data() + i), w = load(rule.w.data() + i) * (c1 + y * (2 * c2 + y * (3 * c3)));
    const Lanes s = piece.start + piece.length * (y * (c1 + y * (c2 + y * c3)));
    const StressPoint<Lanes> at = stress_of<true>(a, place_on<kFront>(a, s), kFront);
    px -= w * at.sigma * at.sin;
    pz += w * at.sigma * at.cos;
    capacity += w * at.tau_max;
    add(force, w * at.tau_t, w * at.tau_l, at.sin, at.cos);
    add(by_t, w * at.t_by_t, w * at.l_by_t, at.sin, at.cos);
    add(by_l, w * at.t_by_l, w * at.l_by_l, at.sin, at.cos);
  }
  const double k = piece.length, x = k * sum_of(px), z = k * sum_of(pz);
  out.pressure_x += x;
  out.pressure_z += z;
  out.capacity += k * sum_of(capacity);
  out.Fx += x + k * sum_of(force[0]);
  out.Fy += k * sum_of(force[1]);
  out.Fz += z + k * sum_of(force[2]);
  out.Mx += k * sum_of(force[3]);
  out.My += k * sum_of(force[4]);
  out.Mz += k * sum_of(force[5]);
  for (int i = 0; i < 6; ++i) {
    out.d_t[i] += k * sum_of(by_t[i]);
    out.d_l[i] += k * sum_of(by_l[i]);
  }
}

void integrate_slopes(const Arc& a, const Piece& piece, int p, int q, const GaussRule& rule, SlopeSums& out) {
  if (piece.front) {
    add_slopes<true>(a, piece, p, q, rule, out);
  } else {
    add_slopes<false>(a, piece, p, q, rule, out);
  }
}

StressSums closed_form(const Arc& a, Method method) {
  ProductRule rule(a, method);
  StressSums out;
  for (int first = 0; first < rule.size(); first += kLanes) {
    const int n = rule.size() - first < kLanes ? rule.size() - first : kLanes;
    Lanes at;
    for (int i = 0; i < kLanes; ++i) at[i] = rule.angles()[first + (i < n ? i : n - 1)];
    const StressPoint<Lanes> p = stress_of<false>(a, place_of(a, at), false);
    double sigma[kLanes], t[kLanes], l[kLanes];
    store(sigma, p.sigma);
    store(t, p.tau_t);
    store(l, p.tau_l);
    if (first == 0) rule.weigh();  // after the stresses, whose functions wait for each other: so both are done at once
    for (int k = 0; k < n; ++k) {
      const double one = rule.one(first + k), sine = rule.sine(first + k), cosine = rule.cosine(first + k);
      out.sigma_sine += sigma[k] * sine;
      out.sigma_cosine += sigma[k] * cosine;
      out.t_one += t[k] * one;
      out.t_sine += t[k] * sine;
      out.t_cosine += t[k] * cosine;
      out.l_one += l[k] * one;
      out.l_sine += l[k] * sine;
      out.l_cosine += l[k] * cosine;
    }
  }
  return out;
}

}  // namespace

extern const Kernel GROUSER_KERNEL;
const Kernel GROUSER_KERNEL{GROUSER_KERNEL_NAME, sines,     integrate,     integrate_slopes,
                            closed_form,         plan_rows, integrate_rows};

}  // namespace grouser::bekker
