#pragma once
// The stress law of the arc, written once: for one double and for lanes of them, with and without derivatives.
#include "arc.h"
#include "lanes.h"

namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE {

/// Where a point lies. theta is measured from the entry, on the rear branch also from the exit, so that nothing cancels
/// at the ends.
template <class V>
struct Place {
  V u;     ///< theta_f - theta
  V ue;    ///< theta_f - theta_e of the pressure: u ahead of theta_m, (theta - theta_r) stretch behind
  V ueca;  ///< the same of the concave part between lugs, < 0 where it does not touch
};

template <class V>
struct StressPoint {
  V sin, cos;                        ///< of theta
  V sigma, tau_max, tau_t, tau_l;    ///< [Pa]
  V j;                               ///< [m], not where locked
  V t_by_t, l_by_t, t_by_l, l_by_l;  ///< d tau/d(e_t, e_l), filled with derivatives only
};

template <class V>
struct Mobilised {
  V f, df;  ///< share of tau_max, its derivative by j
};

// A: Arc, an arc with named effects (effect_arc.h), or the arcs of several wheels in the lanes (rows_body.h), of which
// A::kFeatures tells that there are neither lugs, reloading nor locked wheels.
template <class A>
inline constexpr bool has_effects = requires {
  A::kEffects;
};

/// Rows of a batch need ten digits of the functions only.
template <class A>
inline constexpr Digits digits_of = A::kTenDigits ? Digits::ten : Digits::all;

/// Eq 2.9 in the errata's forms at displacement j >= 0.
template <class V, class A>
GROUSER_INLINE Mobilised<V> mobilised_at(const A& a, V j) {
  const V x = j * a.inv_K, e = exp_of<digits_of<A>>(-x);
  if (a.type == ShearLaw::Type::A) return {1 - e, e * a.inv_K};
  if (a.type == ShearLaw::Type::B) {
    const V f = 2.718281828459045235 * e;
    return {x * f, (1 - x) * f * a.inv_K};
  }
  const V p = a.hump * e;
  return {a.Kr * (1 + p) * (1 - e), (a.Kr * a.inv_K) * ((1 + p) * e - p * (1 - e))};
}

/// Share of tau_max at j -> infinity.
GROUSER_INLINE double residual_share(const Arc& a) {
  return a.type == ShearLaw::Type::A ? 1 : (a.type == ShearLaw::Type::B ? 0 : a.Kr);
}

/// Eqs 2.4 and 2.12 at sinkage z >= 0.
template <class V, class A>
GROUSER_INLINE V pressure_at(const A& a, V z) {
  const V s = a.modulus * pow_of<digits_of<A>>(max_of(z, V{} + 1e-300), a.n);
  if constexpr (has_effects<A>) return s * a.pan(z);
  if constexpr (A::kFeatures)
    if (a.zu > 0) {  // out of the soil (z <= 0) nothing presses, however soft the unloading
      const V again = select(z > 0, max_of(a.peak - a.slope * (a.zu - z), 0 * z), 0 * z);
      return select(z >= a.zu, s, again);
    }
  return s;
}

/// k (cos(entry - ue) - cos entry) k = radius, without cancellation.
template <class V, class R>
GROUSER_INLINE V sinkage_at(R radius, R sin_entry, R cos_entry, const SinCos<V>& half) {
  return (2 * radius) * half.sin * (sin_entry * half.cos - cos_entry * half.sin);
}

/// Share of tau_max at displacement j with what effects make of it.
template <class V, class A>
GROUSER_INLINE Mobilised<V> share_at(const A& a, V j) {
  Mobilised<V> m = mobilised_at(a, j);
  if constexpr (has_effects<A>) a.soften(j, m.f, m.df);
  return m;
}

/// Radius at which the soil shears.
template <class A>
GROUSER_INLINE auto shear_radius_of(const A& a) {
  if constexpr (has_effects<A>)
    return a.shear_radius;
  else
    return a.r;
}

/// shared: ue is u (ahead of theta_m).
template <bool kDerivatives, class V, class A>
GROUSER_INLINE StressPoint<V> stress_of(const A& a, const Place<V>& p, bool shared) {
  StressPoint<V> o;
  const SinCos<V> half = sin_cos_half<digits_of<A>>(0.5 * p.u);
  const V sin_u = 2 * half.sin * half.cos, cos_u = 1 - 2 * half.sin * half.sin;
  o.sin = a.sin_f * cos_u - a.cos_f * sin_u;
  o.cos = a.cos_f * cos_u + a.sin_f * sin_u;

  const SinCos<V> half_e = shared ? half : sin_cos_half<digits_of<A>>(0.5 * p.ue);
  o.sigma = pressure_at(a, sinkage_at(a.r, a.sin_f, a.cos_f, half_e));
  if constexpr (A::kFeatures) {
    if (a.lugs) {  // eq 2.15
      o.sigma = a.mu * o.sigma;
      if (a.concave) {
        const V z = sinkage_at(a.r_ca, a.sin_ca, a.cos_ca, sin_cos_half<digits_of<A>>(0.5 * p.ueca));
        o.sigma = o.sigma + select(p.ueca >= 0, (1 - a.mu) * pressure_at(a, z), 0 * z);
      }
    }
  }
  if constexpr (has_effects<A>) o.sigma = o.sigma * a.pressure_rate(o.sin);
  o.tau_max = a.cohesion + a.tan_phi * o.sigma;
  if constexpr (has_effects<A>) o.tau_max = o.tau_max * a.shear_rate(o.cos);
  if constexpr (A::kFeatures) {
    if (a.zu > 0) o.tau_max = select(o.sigma > 0, o.tau_max, 0 * o.sigma);  // a reloading wheel that does not touch

    if (a.locked) {
      const double f = residual_share(a);
      if (a.anisotropic) {
        const double side = a.tan_beta > 0 ? 1 : (a.tan_beta < 0 ? -1 : 0);
        o.tau_t = -f * o.tau_max;
        o.tau_l = (f * side) * o.tau_max;
      } else {
        const V scale = f * o.tau_max / sqrt_of(o.cos * o.cos + a.tan_beta * a.tan_beta + 1e-300);
        o.tau_t = -(scale * o.cos);
        o.tau_l = scale * a.tan_beta;
      }
      return o;
    }
  }

  // Eq 2.7 as corrected, with sin theta_f - sin theta = 2 sin(u/2) cos(theta_f - u/2).
  const auto R = shear_radius_of(a);
  const V dj = (2 * R) * half.sin * (a.cos_f * half.cos + a.sin_f * half.sin), arc = R * p.u;
  const V jt = arc - (1 - a.e.t) * dj, jl = a.e.l * arc;
  const V j2 = jt * jt + (jl * jl + 1e-300), j = j2 * inverse_sqrt_of<digits_of<A>>(j2);
  o.j = j;
  if (a.anisotropic) {
    const Mobilised<V> t = share_at(a, abs_of(jt)), l = share_at(a, abs_of(jl));
    o.tau_t = o.tau_max * with_sign(t.f, jt);
    o.tau_l = o.tau_max * with_sign(l.f, jl);
    if constexpr (kDerivatives) {
      o.t_by_t = o.tau_max * t.df * dj;
      o.l_by_l = o.tau_max * l.df * arc;
      o.l_by_t = o.t_by_l = 0 * arc;
    }
    return o;
  }
  const Mobilised<V> m = share_at(a, j);
  // 1 - kappa cos theta = e_t cos theta + 2 sin^2(theta/2): nothing cancels near pure rolling; at theta = 0 the limit
  // from either side.
  const V h = a.sin_half * half.cos - a.cos_half * half.sin, vt = 2 * h * h + (a.e.t * o.cos + 1e-140);
  const V speed2 = vt * vt + (a.e.l * a.e.l + 1e-300), inverse = inverse_sqrt_of<digits_of<A>>(speed2);
  const V ct = vt * inverse, cl = a.e.l * inverse, tau = o.tau_max * m.f;
  o.tau_t = tau * ct;
  o.tau_l = tau * cl;
  if constexpr (kDerivatives) {
    // j and the direction depend on e. The direction's true derivative is unbounded at rest: its speed is kept above
    // 1e-4.
    const V slope = select(j > 0, o.tau_max * m.df / max_of(j, 0 * j + 1e-300), 0 * j);
    const V turn = tau / max_of(speed2 * inverse, 0 * inverse + 1e-4);
    const V by_t = slope * jt * dj, by_l = slope * jl * arc;
    o.t_by_t = by_t * ct + turn * o.cos * cl * cl;
    o.l_by_t = by_t * cl - turn * o.cos * ct * cl;
    // At j_l = 0 the derivative of |j| by e.l vanishes and the direction alone turns.
    o.t_by_l = by_l * ct - turn * ct * cl;
    o.l_by_l = by_l * cl + turn * ct * ct;
  }
  return o;
}

/// Weighted stresses of one point onto the sums of eq 2.11: Fx, Fy, Fz, Mx, My, Mz without r b and r^2 b.
template <class V>
GROUSER_INLINE void add_wrench(const StressPoint<V>& p, V sigma, V t, V l, V* sum) {
  sum[0] += t * p.cos - sigma * p.sin;
  sum[1] -= l;
  sum[2] += sigma * p.cos + t * p.sin;
  sum[3] -= l * p.cos;
  sum[4] -= t;
  sum[5] -= l * p.sin;
}

/// Place of theta, anywhere in theta_r..theta_f.
template <class V>
GROUSER_INLINE Place<V> place_of(const Arc& a, V theta) {
  const V u = a.theta_f - theta, rear = theta - a.theta_r;
  const auto ahead = theta >= a.theta_m;
  return {u, select(ahead, u, rear * a.stretch), select(ahead, a.theta_ca - theta, rear * a.stretch_ca)};
}

}  // namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE
