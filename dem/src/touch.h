#pragma once
// Nearest points of surfaces, for one number (double) or several at once.
#include "facet.h"
#include "lanes.h"

namespace grouser::dem::inline GROUSER_DEM_ISA {

template <class V>
struct Near {
  Vec3L<V> point;   ///< nearest point of the surface
  Vec3L<V> normal;  ///< unit, from the sphere's centre to it
  V distance;       ///< centre to surface, negative when the centre is inside
};

template <class V>
GROUSER_INLINE V between_0_and_1(V x) {
  return smaller(larger(x, V{}), V{} + 1);
}

/// Way r from the nearest point to the centre x, its size known; up where it is zero.
template <class V>
GROUSER_INLINE Near<V> outside(const Vec3L<V>& x, const Vec3L<V>& r, V size) {
  const V none{}, one = none + 1, away = size > none ? -one / size : none;
  Near<V> t;
  t.point = {x.x - r.x, x.y - r.y, x.z - r.z};
  t.normal = {away * r.x, away * r.y, size > none ? away * r.z : one};
  t.distance = size;
  return t;
}

/// Triangle: the foot of the perpendicular where it lies inside, the nearest point of the three sides elsewhere.
/// `f(k)`: field k of the facet.
template <class V, class F>
GROUSER_INLINE Near<V> near_triangle(const Vec3L<V>& x, F&& f) {
  using N = FacetField;
  const auto vector = [&](int k) { return Vec3L<V>{f(k), f(k + 1), f(k + 2)}; };
  const Vec3L<V> d = minus(x, vector(N::corner)), u = vector(N::u), v = vector(N::v), n = vector(N::normal);
  const V uu = f(N::uu), uv = f(N::uv), vv = f(N::vv), inv_det = f(N::inv_det);
  const V du = dot(d, u), dv = dot(d, v), dn = dot(d, n);
  const V s = (vv * du - uv * dv) * inv_det, t = (uu * dv - uv * du) * inv_det;
  const Vec3L<V> along_u = less(d, between_0_and_1(du * f(N::inv_uu)), u);
  const Vec3L<V> along_v = less(d, between_0_and_1(dv * f(N::inv_vv)), v);
  const V c = between_0_and_1((dv - du - uv + uu) * f(N::inv_ww));
  const Vec3L<V> along_w = less(minus(d, u), c, minus(v, u));
  const V u2 = dot(along_u, along_u), v2 = dot(along_v, along_v), w2 = dot(along_w, along_w);
  const auto pick = [](auto which, const Vec3L<V>& a, const Vec3L<V>& b) {
    return Vec3L<V>{which ? a.x : b.x, which ? a.y : b.y, which ? a.z : b.z};
  };
  const auto on_v = v2 < u2;
  const V least = on_v ? v2 : u2;
  const auto on_w = w2 < least;
  const Vec3L<V> side = pick(on_w, along_w, pick(on_v, along_v, along_u));
  const auto inside = (s >= V{}) & (t >= V{}) & (s + t <= V{} + 1);
  const V size = inside ? absolute(dn) : root(smaller(w2, least));
  return outside(x, pick(inside, scaled(dn, n), side), size);
}

template <class V, class F>
GROUSER_INLINE Near<V> near_sphere(const Vec3L<V>& x, F&& f) {
  const Vec3L<V> d = {f(FacetField::corner) - x.x, f(FacetField::corner + 1) - x.y, f(FacetField::corner + 2) - x.z};
  const V length = root(dot(d, d)), inv = (V{} + 1) / larger(length, V{} + 1e-30);
  Near<V> t;
  t.normal = scaled(inv, d);
  t.distance = length - f(FacetField::radius);
  t.point = plus(x, t.distance, t.normal);
  return t;
}

/// Cylinder about y, discs at +-half (which may be infinite).
template <class V>
GROUSER_INLINE Near<V> near_cylinder(const Vec3L<V>& x, double radius, double half) {
  const V none{}, one = none + 1, r = none + radius, h = none + half;
  const V rho = root(x.x * x.x + x.z * x.z), inv = one / larger(rho, none + 1e-30), aside = absolute(x.y);
  const V out_x = rho > none ? x.x * inv : one, out_z = x.z * inv;
  const V sign = x.y < none ? -one : one;
  const auto rim = (aside <= h) & ((rho >= r) | (r - rho <= h - aside));
  const auto disc = rho <= r;  // where it is not the rim
  // Off the edge.
  const V away = rho - r, beyond = aside - h, edge = root(away * away + beyond * beyond),
          inv_edge = one / larger(edge, none + 1e-30);
  const V into = rim ? one : disc ? none : away * inv_edge, along = rim ? none : disc ? one : beyond * inv_edge;
  Near<V> t;
  t.distance = rim ? away : disc ? beyond : edge;
  t.normal = {-into * out_x, -along * sign, -into * out_z};
  t.point = {rim ? r * out_x : disc ? x.x : r * out_x, rim ? x.y : sign * h, rim ? r * out_z : disc ? x.z : r * out_z};
  return t;
}

}  // namespace grouser::dem::inline GROUSER_DEM_ISA
