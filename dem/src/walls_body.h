#pragma once
// Contacts of grains with surfaces: nearest points, then the law.
#include "gather_lanes.h"
#include "touch.h"

namespace grouser::dem {
namespace {

/// Normal, overlap and place of contacts with triangles, spheres or a cylinder, in double: what touches is
/// the difference of large numbers.
template <class R, ShapeKind kKind>
GROUSER_INLINE void touch_loop(const SurfaceWork<R>& w, WallBlock<R>* first, WallBlock<R>* last, FacetBlock* facets) {
  typedef LanesOf<double>::V D;
  constexpr int n = LanesOf<double>::count, wide = LanesOf<R>::count;
  typedef Int<R> Whole __attribute__((vector_size(n * sizeof(R))));
  typedef R Narrow __attribute__((vector_size(n * sizeof(R))));
  typedef typename LanesOf<R>::I I;
  const auto& m = w.turn;
  const auto turned = [&m](const Vec3L<D>& a) {
    return Vec3L<D>{m[0][0] * a.x + m[0][1] * a.y + m[0][2] * a.z, m[1][0] * a.x + m[1][1] * a.y + m[1][2] * a.z,
                    m[2][0] * a.x + m[2][1] * a.y + m[2][2] * a.z};
  };
  for (WallBlock<R>* b = first; b != last; ++b) {
    alignas(64) Int<R> place[3][kBlock];
    alignas(64) R radius[kBlock];
    for (int at = 0; at < kBlock; at += wide) {
      I p[3];
      V<R> r;
      gather_place<R, true>(w.grains, b->i + at, p, r);
      for (int k = 0; k < 3; ++k) store_as(place[k] + at, p[k] - w.origin[k]);
      store_as(radius + at, r);
    }
    for (int at = 0; at < kBlock; at += n) {
      const auto metre = [&](int k) {
        return __builtin_convertvector(load_as<Whole>(place[k] + at), D) * w.unit[k] - w.from[k];
      };
      const Vec3L<D> d = {metre(0), metre(1), metre(2)};
      const Vec3L<D> x = {m[0][0] * d.x + m[1][0] * d.y + m[2][0] * d.z, m[0][1] * d.x + m[1][1] * d.y + m[2][1] * d.z,
                          m[0][2] * d.x + m[1][2] * d.y + m[2][2] * d.z};
      const auto field = [&](int k) { return load_as<D>(facets->field[k] + at); };
      Near<D> t;
      if constexpr (kKind == ShapeKind::mesh) {
        t = near_triangle<D>(x, field);
        store3<D, double>(facets->point, at, t.point);
        store_as(facets->distance + at, t.distance);
      } else if constexpr (kKind == ShapeKind::spheres) {
        t = near_sphere<D>(x, field);
      } else {
        t = near_cylinder<D>(x, w.radius, w.half_width);
      }
      const D delta = __builtin_convertvector(load_as<Narrow>(radius + at), D) - t.distance;
      const Vec3L<D> normal = turned(t.normal), arm = turned(plus(t.point, 0.5 * delta, t.normal));
      const auto put = [at](R* to, D a) { store_as(to + at, __builtin_convertvector(a, Narrow)); };
      const auto put3 = [&put](R(&to)[3][kBlock], const Vec3L<D>& a) {
        put(to[0], a.x);
        put(to[1], a.y);
        put(to[2], a.z);
      };
      put(b->delta, delta);
      put3(b->n, normal);
      put3(b->at, arm);
    }
    if constexpr (kKind != ShapeKind::cylinder) ++facets;
  }
}

template <class R>
void touch(const SurfaceWork<R>& w, WallBlock<R>* first, WallBlock<R>* last, FacetBlock* facets) {
  if (w.kind == ShapeKind::mesh)
    touch_loop<R, ShapeKind::mesh>(w, first, last, facets);
  else if (w.kind == ShapeKind::spheres)
    touch_loop<R, ShapeKind::spheres>(w, first, last, facets);
  else
    touch_loop<R, ShapeKind::cylinder>(w, first, last, facets);
}

/// Grain against surface: R* = r, m* = m; the surface's own motion is in the block.
template <class R, bool kLedger, bool kPlain>
void walls_loop(const StepWork<R>& w, const Motion<R>& body, WallBlock<R>* first, WallBlock<R>* last, WallSum& total,
                Energies* e) {
  constexpr int n = LanesOf<R>::count;
  constexpr std::uint32_t mask = ~(kUnit - 1);
  typedef typename LanesOf<R>::Wide Wide;
  Wide force[3] = {}, torque[3] = {}, contacts{};
  const V<R> none{};
  const Vec3L<V<R>> v0 = {none + body.v[0], none + body.v[1], none + body.v[2]},
                    ws = {none + body.w[0], none + body.w[1], none + body.w[2]};
  const auto add = [](Wide& to, V<R> x) { to += __builtin_convertvector(x, Wide); };
  for (WallBlock<R>* b = first; b != last; ++b) {
    for (int at = 0; at < kBlock; at += n) {
      const std::uint32_t* oi = b->i + at;
      const State<R> i = gather<R, true>(w.grains, oi);
      const auto get = [at](const R(&a)[3][kBlock]) { return load3<V<R>, R>(a, at); };
      Geometry<V<R>> g;
      g.n = get(b->n);
      g.delta = load_as<V<R>>(b->delta + at);
      const V<R> ci = i.r - R(0.5) * larger(g.delta, V<R>{});
      const Vec3L<V<R>> arm = get(b->at), vs = add_cross(v0, ws, arm);
      g.drift = {i.v.x - vs.x, i.v.y - vs.y, i.v.z - vs.z};
      g.un = dot(g.drift, g.n);
      g.u = add_cross(g.drift, scaled(ci, i.w), g.n);
      g.spin = {i.w.x - ws.x, i.w.y - ws.y, i.w.z - ws.z};
      g.reff = i.r * inverse(1 + i.r * load_as<V<R>>(b->curvature + at));
      g.inv_m = larger(i.im, V<R>{} + R(1e-30));
      const V<R> r2 = i.r * i.r;
      g.ieff = R(1.4) * r2 * inverse(g.inv_m);
      g.mobility_t = R(3.5) * i.count * i.im;
      g.mobility_r = R(2.5) * i.count * i.im * inverse(r2);
      g.area = R(3.141592653589793) * g.delta * (2 * g.reff - g.delta);
      History<V<R>> h = {get(b->s), get(b->t)};
      Past<R>* past = kLedger ? &b->past : nullptr;
      const Result<V<R>> r = contact_law<R, kLedger, kPlain>(w, coefficients<R, true>(*w.law, oi), g, h, past, at, e);
      store3(b->s, at, h.s);
      store3(b->t, at, h.t);
      const Vec3L<V<R>> f = plus(r.ft, r.fn, g.n), lever = cross(r.ft, g.n);
      const Vec3L<V<R>> t = {ci * lever.x + r.roll.x, ci * lever.y + r.roll.y, ci * lever.z + r.roll.z};
      const V<R> one = g.delta > 0 ? V<R>{} + 1 : V<R>{};
      // On the surface: f, and about the origin of the body. Without contact all of this is zero.
      const Vec3L<V<R>> moment = cross(arm, f);
      add(force[0], f.x);
      add(force[1], f.y);
      add(force[2], f.z);
      add(torque[0], moment.x - r.roll.x);
      add(torque[1], moment.y - r.roll.y);
      add(torque[2], moment.z - r.roll.z);
      add(contacts, one);
      scatter_one<R, mask>(w.loads, oi, f, r.k, t, one);
    }
  }
  for (int k = 0; k < 3; ++k) {
    total.force[k] = sum_of(force[k]);
    total.torque[k] = sum_of(torque[k]);
  }
  total.contacts = static_cast<int>(sum_of(contacts));
}

template <class R>
void walls(const StepWork<R>& w, const Motion<R>& body, WallBlock<R>* first, WallBlock<R>* last, WallSum& sum,
           Energies* e) {
  const bool plain = !(w.ch3 || w.spring_cap || w.cohesive || w.rate_without_spin);
  if (e)
    walls_loop<R, true, false>(w, body, first, last, sum, e);
  else if (plain)
    walls_loop<R, false, true>(w, body, first, last, sum, e);
  else
    walls_loop<R, false, false>(w, body, first, last, sum, e);
}

}  // namespace
}  // namespace grouser::dem
