#pragma once
// The contact law in lanes, written once for grain-grain and grain-surface contacts, single and double precision
// (equations D1 to D14 of the module's README).
#include "kernel.h"
#include "lanes.h"

namespace grouser::dem::inline GROUSER_DEM_ISA {

/// Coefficients in lanes: one value for all, or looked up by the type of the pair.
template <class V>
struct Coefficients {
  V kn, kt, cn, ct, mu, mur, kc;
};

template <class V>
struct Geometry {
  Vec3L<V> n;      ///< unit normal, i to j
  V delta;         ///< overlap; <= 0: no contact
  Vec3L<V> u;      ///< velocity of i against j at the contact, with spins
  V un;            ///< u.n, positive when closing
  Vec3L<V> spin;   ///< w_i - w_j
  Vec3L<V> drift;  ///< v_i - v_j (centres), for the rate reading without spin
  V reff, inv_m;   ///< R*, 1/m*
  V ieff;          ///< eq 3.19
  V mobility_t;    ///< sum over both of contacts/effective mass at the contact, for the implicit dampers
  V mobility_r;    ///< the same for rotation
  V area;          ///< area of the circle of contact (eq 3.5), only for cohesion
};

template <class V>
struct Result {
  V fn;           ///< normal force, positive: repulsion
  Vec3L<V> ft;    ///< tangential force on j
  Vec3L<V> roll;  ///< rolling torque on i
  V k;            ///< tangent normal stiffness
};

template <class V>
struct History {
  Vec3L<V> s, t;
};

template <class V, class R>
GROUSER_INLINE Vec3L<V> load3(const R (&a)[3][kBlock], int at) {
  return {load_as<V>(a[0] + at), load_as<V>(a[1] + at), load_as<V>(a[2] + at)};
}
template <class V, class R>
GROUSER_INLINE void store3(R (&a)[3][kBlock], int at, const Vec3L<V>& x) {
  store_as(a[0] + at, x.x);
  store_as(a[1] + at, x.y);
  store_as(a[2] + at, x.z);
}
template <class V>
GROUSER_INLINE double sum_of(V x) {
  double s = 0;
  for (std::size_t k = 0; k < sizeof(V) / sizeof(x[0]); ++k) s += static_cast<double>(x[k]);
  return s;
}

/// One step of the law. With kLedger the energies are added to `e`; the forces are the same bits. `past`: lanes from
/// `at` on.
template <class R, bool kLedger, bool kPlain, class V = typename LanesOf<R>::V>
GROUSER_INLINE Result<V> contact_law(const StepWork<R>& w, const Coefficients<V>& c, const Geometry<V>& g,
                                     History<V>& h, [[maybe_unused]] Past<R>* past, [[maybe_unused]] int at,
                                     [[maybe_unused]] Energies* e) {
  // The usual law is compiled without the others.
  const bool ch3 = !kPlain && w.ch3, spring_cap = !kPlain && w.spring_cap, cohesive = !kPlain && w.cohesive,
             without_spin = !kPlain && w.rate_without_spin;
  const V zero = V{}, tiny = zero + R(1e-12);
  const auto active = g.delta > 0;
  const V overlap = larger(g.delta, tiny), rd = g.reff * overlap, inv_a = inverse_root(rd), a = rd * inv_a;
  const V kn = c.kn * a, kt = c.kt * a;
  const V meff = inverse(g.inv_m);
  const V q = ch3 ? a * meff : root(a * meff);
  V fn = kn * overlap + (c.cn * q) * g.un;
  fn = active ? fn : zero;
  // The ledger follows a contact from the positions of the last step to these: u dt is exactly what it moved by in
  // between, and the mean of the forces at both ends times that is the work which all grains together did on it.
  const V half = zero + R(0.5);
  [[maybe_unused]] V kt_before, kt_now;
  if constexpr (kLedger) {
    const V way = g.un * w.dt, damper = active ? (c.cn * q) * g.un : zero;
    kt_before = c.kt * root(g.reff * larger(g.delta - way, zero));
    kt_now = active ? kt : zero;
    e->normal_spring += sum_of(active ? R(0.4) * kn * overlap * overlap : zero);
    e->normal_damping += sum_of(half * (load_as<V>(past->normal + at) + damper) * way);
    store_as(past->normal + at, damper);
  }

  const Vec3L<V> ut = less(g.u, g.un, g.n);
  // Tangential spring: the old one turned into the new contact plane, then stretched.
  Vec3L<V> s = less(h.s, dot(h.s, g.n), g.n);
  [[maybe_unused]] const History<V> old = h;
  [[maybe_unused]] const Vec3L<V> turned = s;
  s = {s.x + ut.x * w.dt, s.y + ut.y * w.dt, s.z + ut.z * w.dt};
  V gt = c.ct * q;
  gt = gt * inverse(1 + (w.implicit * gt) * g.mobility_t);
  Vec3L<V> ft = {kt * s.x, kt * s.y, kt * s.z};
  const V limit = c.mu * absolute(fn);
  const V smallest = zero + R(1e-30);
  if (spring_cap) {
    const V size2 = dot(ft, ft);
    const auto slides = size2 > limit * limit;
    const V m = slides ? limit * inverse_root(larger(size2, smallest)) : zero + 1;
    gt = slides ? zero : gt;
    ft = {m * ft.x + gt * ut.x, m * ft.y + gt * ut.y, m * ft.z + gt * ut.z};
    h.s = {m * s.x, m * s.y, m * s.z};
    ft = {active ? ft.x : zero, active ? ft.y : zero, active ? ft.z : zero};
    h.s = {active ? h.s.x : zero, active ? h.s.y : zero, active ? h.s.z : zero};
  } else {
    ft = {ft.x + gt * ut.x, ft.y + gt * ut.y, ft.z + gt * ut.z};
    const V size2 = dot(ft, ft);
    const auto slides = size2 > limit * limit;
    const V m = slides ? limit * inverse_root(larger(size2, smallest)) : zero + 1;
    ft = scaled(m, ft);
    const V inv_kt = inverse(kt);
    h.s = {slides ? ft.x * inv_kt : s.x, slides ? ft.y * inv_kt : s.y, slides ? ft.z * inv_kt : s.z};
  }

  if constexpr (kLedger) {
    const Vec3L<V> damper = less(ft, kt_now, h.s), damper_before = load3<V, R>(past->tangential, at);
    const Vec3L<V> slip = less(s, zero + 1, h.s);
    e->tangential_spring += sum_of(half * kt_now * dot(h.s, h.s));
    e->tangential_damping += sum_of(half * (dot(damper, ut) + dot(damper_before, ut)) * w.dt);
    e->sliding += sum_of(half * (kt_before * dot(turned, slip) + kt_now * dot(h.s, slip)));
    e->tangential_change += sum_of(
        half * (kt_before * (dot(old.s, old.s) - dot(turned, turned)) + (kt_before - kt_now) * dot(turned, h.s)));
    store3(past->tangential, at, damper);
  }

  // Rolling.
  V mu = ch3 ? zero : c.mur;
  Vec3L<V> roll;
  const Vec3L<V> wr = less(g.spin, dot(g.spin, g.n), g.n);
  if (ch3) {
    const V size2 = dot(wr, wr);
    const V m = (c.mur * g.reff) * ((active ? kn : zero) * overlap) * inverse_root(larger(size2, smallest));
    roll = scaled(-m, wr);
    if constexpr (kLedger) {
      const Vec3L<V> before = load3<V, R>(past->rolling, at);
      e->rolling_slip -= sum_of(half * (dot(roll, wr) + dot(before, wr)) * w.dt);
      store3(past->rolling, at, roll);
    }
  } else {
    if (w.rate) {
      V v2;
      if (without_spin) {
        const Vec3L<V> d = less(g.drift, g.un, g.n);
        v2 = dot(d, d);
      } else {
        v2 = dot(ut, ut);
      }
      mu = smaller(mu * v2, zero + 1);
    }
    const V arm = mu * g.reff, kr = (R(2.25) * kn) * (arm * arm);
    V gr = (3 * arm) * root(kn * g.ieff);  // 2 sqrt(kr I) with kr = 2.25 kn arm^2
    gr = gr * inverse(1 + (w.implicit * gr) * g.mobility_r);
    Vec3L<V> t = less(h.t, dot(h.t, g.n), g.n);
    [[maybe_unused]] const Vec3L<V> before = t;
    const V step = kr * w.dt;
    t = {t.x - step * wr.x, t.y - step * wr.y, t.z - step * wr.z};
    const V most = arm * absolute(fn);
    const V spring2 = dot(t, t), most2 = most * most;
    const auto yields = spring2 > most2;
    const V m = yields ? most * inverse_root(larger(spring2, smallest)) : zero + 1;
    h.t = scaled(m, t);
    if (spring_cap) {
      gr = yields ? zero : gr;
      gr = active ? gr : zero;
      roll = less(h.t, gr, wr);
    } else {
      roll = less(h.t, gr, wr);
      const V sum2 = dot(roll, roll);
      const V l = sum2 > most2 ? most * inverse_root(larger(sum2, smallest)) : zero + 1;
      roll = scaled(l, roll);
    }
    if constexpr (kLedger) {
      // A spring that is softened, or cut to a lower limit, gives nothing back: what it holds less is lost.
      const Vec3L<V> damper = less(roll, zero + 1, h.t), damper_before = load3<V, R>(past->rolling, at);
      const V held = load_as<V>(past->rolling_spring + at);
      const V holds = active ? half * inverse(larger(kr, smallest)) * dot(h.t, h.t) : zero;
      const V lost = held - holds - half * (dot(before, wr) + dot(h.t, wr)) * w.dt;
      e->rolling_spring += sum_of(holds);
      e->rolling_damping -= sum_of(half * (dot(damper, wr) + dot(damper_before, wr)) * w.dt);
      e->rolling_slip += sum_of(yields ? lost : zero);
      e->rolling_change += sum_of(yields ? zero : lost);
      store_as(past->rolling_spring + at, holds);
      store3(past->rolling, at, damper);
    }
  }
  // Cohesion holds the grains together without counting in the limits of friction and rolling.
  if (cohesive) {
    const V pull = active ? c.kc * g.area : zero;
    fn = fn - pull;
    if constexpr (kLedger) {
      e->cohesion -= sum_of(half * (load_as<V>(past->cohesion + at) + pull) * g.un * w.dt);
      store_as(past->cohesion + at, pull);
    }
  }
  return {fn, ft, roll, active ? (R(1.5) + R(1.4) * (mu * mu)) * kn : zero};
}

}  // namespace grouser::dem::inline GROUSER_DEM_ISA
