#pragma once
// Records of grains into lanes, sums of contacts back to grains.
#include "contact_law.h"

namespace grouser::dem {
namespace {

template <class R>
using V = typename LanesOf<R>::V;

#if GROUSER_DEM_BYTES == 64
/// Quadruples at base + scale * offset of 16 grains, turned into four vectors.
template <std::uint32_t kMask>
GROUSER_INLINE void quads(const char* base, const std::uint32_t* o, VF& a, VF& b, VF& c, VF& d) {
  const auto at = [&](int k) {
    return _mm_load_ps(reinterpret_cast<const float*>(base + 2 * std::size_t(o[k] & kMask)));
  };
  VF z[4];
  for (int m = 0; m < 4; ++m) {
    VF r = _mm512_castps128_ps512(at(m));
    r = _mm512_mask_broadcast_f32x4(r, 0x00f0, at(m + 4));
    r = _mm512_mask_broadcast_f32x4(r, 0x0f00, at(m + 8));
    z[m] = _mm512_mask_broadcast_f32x4(r, 0xf000, at(m + 12));
  }
  const VF t0 = __builtin_shufflevector(z[0], z[1], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  const VF t1 = __builtin_shufflevector(z[0], z[1], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  const VF t2 = __builtin_shufflevector(z[2], z[3], 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  const VF t3 = __builtin_shufflevector(z[2], z[3], 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  a = __builtin_shufflevector(t0, t2, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
  b = __builtin_shufflevector(t0, t2, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
  c = __builtin_shufflevector(t1, t3, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
  d = __builtin_shufflevector(t1, t3, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
}
/// The reverse within each 128-bit lane: r[m] holds the quadruples of grains m, m + 4, m + 8, m + 12.
GROUSER_INLINE void rows(VF a, VF b, VF c, VF d, VF* r) {
  const VF t0 = __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  const VF t1 = __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  const VF t2 = __builtin_shufflevector(c, d, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  const VF t3 = __builtin_shufflevector(c, d, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  // t0 = a0 b0 a1 b1, t2 = c0 d0 c1 d1 per lane (each lane holds four grains' values of one component).
  r[0] = __builtin_shufflevector(t0, t2, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
  r[1] = __builtin_shufflevector(t0, t2, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
  r[2] = __builtin_shufflevector(t1, t3, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29);
  r[3] = __builtin_shufflevector(t1, t3, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
}
#elif GROUSER_DEM_BYTES == 32
template <std::uint32_t kMask>
GROUSER_INLINE void quads(const char* base, const std::uint32_t* o, VF& a, VF& b, VF& c, VF& d) {
  const auto at = [&](int k) {
    return _mm_load_ps(reinterpret_cast<const float*>(base + 2 * std::size_t(o[k] & kMask)));
  };
  VF z[4];
  for (int m = 0; m < 4; ++m) z[m] = _mm256_insertf128_ps(_mm256_castps128_ps256(at(m)), at(m + 4), 1);
  const VF t0 = _mm256_unpacklo_ps(z[0], z[1]), t1 = _mm256_unpackhi_ps(z[0], z[1]);
  const VF t2 = _mm256_unpacklo_ps(z[2], z[3]), t3 = _mm256_unpackhi_ps(z[2], z[3]);
  a = __builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13);
  b = __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15);
  c = __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13);
  d = __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15);
}
/// r[m] holds the quadruples of grains m and m + 4.
GROUSER_INLINE void rows(VF a, VF b, VF c, VF d, VF* r) {
  const VF t0 = _mm256_unpacklo_ps(a, b), t1 = _mm256_unpackhi_ps(a, b);
  const VF t2 = _mm256_unpacklo_ps(c, d), t3 = _mm256_unpackhi_ps(c, d);
  r[0] = __builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13);
  r[1] = __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15);
  r[2] = __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13);
  r[3] = __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15);
}
#endif

template <class R>
GROUSER_INLINE void quads_any(const char* base, const std::uint32_t* o, std::uint32_t mask, V<R>& a, V<R>& b, V<R>& c,
                              V<R>& d) {
  constexpr int n = LanesOf<R>::count;
  for (int k = 0; k < n; ++k) {
    R q[4];
    __builtin_memcpy(q, base + (sizeof(R) / 2) * std::size_t(o[k] & mask), sizeof q);
    a[k] = q[0];
    b[k] = q[1];
    c[k] = q[2];
    d[k] = q[3];
  }
}

template <class R>
struct State {
  typename LanesOf<R>::I p[3];
  V<R> r, im, count;
  Vec3L<V<R>> v, w;
};

/// Positions of grains in units, and radii.
template <class R, bool kMany>
GROUSER_INLINE void gather_place(const Grain<R>* grains, const std::uint32_t* o, typename LanesOf<R>::I (&p)[3],
                                 V<R>& r) {
  V<R> x{}, y{}, z{};
  const char* base = reinterpret_cast<const char*>(grains);
  constexpr std::uint32_t mask = kMany ? ~(kUnit - 1) : ~0u;
#if GROUSER_DEM_BYTES >= 32
  if constexpr (sizeof(R) == 4)
    quads<mask>(base, o, x, y, z, r);
  else
#endif
    quads_any<R>(base, o, mask, x, y, z, r);
  typedef typename LanesOf<R>::I I;
  p[0] = reinterpret_cast<I>(x);
  p[1] = reinterpret_cast<I>(y);
  p[2] = reinterpret_cast<I>(z);
}

template <class R, bool kMany>
GROUSER_INLINE State<R> gather(const Grain<R>* grains, const std::uint32_t* o) {
  State<R> s;
  const char* base = reinterpret_cast<const char*>(grains);
  constexpr std::uint32_t mask = kMany ? ~(kUnit - 1) : ~0u;
  constexpr std::size_t q = 4 * sizeof(R);
  gather_place<R, kMany>(grains, o, s.p, s.r);
#if GROUSER_DEM_BYTES >= 32
  if constexpr (sizeof(R) == 4) {
    quads<mask>(base + q, o, s.v.x, s.v.y, s.v.z, s.im);
    quads<mask>(base + 2 * q, o, s.w.x, s.w.y, s.w.z, s.count);
  } else
#endif
  {
    quads_any<R>(base + q, o, mask, s.v.x, s.v.y, s.v.z, s.im);
    quads_any<R>(base + 2 * q, o, mask, s.w.x, s.w.y, s.w.z, s.count);
  }
  return s;
}

template <class R>
GROUSER_INLINE V<R> look_up(const R* table, const std::uint32_t* o) {
  V<R> v;
#if GROUSER_DEM_BYTES == 64
  if constexpr (sizeof(R) == 4)
    return _mm512_maskz_permutexvar_ps(0xffff, _mm512_loadu_si512(o), _mm512_load_ps(table));  // low four bits count
#endif
  for (int k = 0; k < LanesOf<R>::count; ++k) v[k] = table[o[k] & (kTypes - 1)];
  return v;
}

template <class R, bool kMany>
GROUSER_INLINE Coefficients<V<R>> coefficients(const LawTable<R>& t, const std::uint32_t* o) {
  if constexpr (kMany)
    return {look_up(t.kn, o), look_up(t.kt, o),  look_up(t.cn, o), look_up(t.ct, o),
            look_up(t.mu, o), look_up(t.mur, o), look_up(t.kc, o)};
  const V<R> z{};
  return {z + t.kn[0], z + t.kt[0], z + t.cn[0], z + t.ct[0], z + t.mu[0], z + t.mur[0], z + t.kc[0]};
}

template <class R>
GROUSER_INLINE V<R> metres(typename LanesOf<R>::I d, R unit) {
  return __builtin_convertvector(d, V<R>) * unit;
}

#if GROUSER_DEM_BYTES >= 32
typedef float Eight __attribute__((vector_size(32)));
/// Rows of force and torque of contacts, joined: the eight values of each contact, in order.
GROUSER_INLINE void join(const VF (&f)[4], const VF (&t)[4], Eight* to) {
  for (int m = 0; m < 4; ++m) {
#if GROUSER_DEM_BYTES == 64
    const VF x = __builtin_shufflevector(f[m], t[m], 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
    const VF y = __builtin_shufflevector(f[m], t[m], 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
    to[m] = __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7);
    to[m + 4] = __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15);
    to[m + 8] = __builtin_shufflevector(y, y, 0, 1, 2, 3, 4, 5, 6, 7);
    to[m + 12] = __builtin_shufflevector(y, y, 8, 9, 10, 11, 12, 13, 14, 15);
#else
    to[m] = _mm256_permute2f128_ps(f[m], t[m], 0x20);
    to[m + 4] = _mm256_permute2f128_ps(f[m], t[m], 0x31);
#endif
  }
}
/// The first three of every four change sign.
GROUSER_INLINE VF opposite(VF x) {
  typedef LanesOf<float>::I I;
  I flip{};
  for (int k = 0; k < LanesOf<float>::count; ++k) flip[k] = k % 4 < 3 ? static_cast<int>(0x80000000u) : 0;
  return reinterpret_cast<VF>(reinterpret_cast<I>(x) ^ flip);
}
GROUSER_INLINE void add_eight(char* to, Eight x) { store_as(to, load_as<Eight>(to) + x); }
#endif

/// Add lane c to the sums of one grain, with `sign` times the force.
template <class R>
GROUSER_INLINE void add_lane(Load<R>& to, int c, R sign, const Vec3L<V<R>>& f, V<R> k, const Vec3L<V<R>>& t, V<R> one) {
  to.f[0] += sign * f.x[c];
  to.f[1] += sign * f.y[c];
  to.f[2] += sign * f.z[c];
  to.k += k[c];
  to.t[0] += t.x[c];
  to.t[1] += t.y[c];
  to.t[2] += t.z[c];
  to.n += one[c];
}

/// Add the eight values of each contact to its two grains, in the order of the list; f is the force on j.
template <class R, std::uint32_t kMask>
GROUSER_INLINE void scatter(Load<R>* loads, const std::uint32_t* oi, const std::uint32_t* oj, const Vec3L<V<R>>& f,
                            V<R> k, const Vec3L<V<R>>& ti, const Vec3L<V<R>>& tj, V<R> one) {
  constexpr int n = LanesOf<R>::count;
  char* base = reinterpret_cast<char*>(loads);
#if GROUSER_DEM_BYTES >= 32
  if constexpr (sizeof(R) == 4) {
    VF rf[4], ri[4], rj[4], back[4];
    rows(f.x, f.y, f.z, k, rf);
    rows(ti.x, ti.y, ti.z, one, ri);
    rows(tj.x, tj.y, tj.z, one, rj);
    for (int m = 0; m < 4; ++m) back[m] = opposite(rf[m]);
    Eight at_i[n], at_j[n];
    join(back, ri, at_i);
    join(rf, rj, at_j);
    for (int c = 0; c < n; ++c) {
      add_eight(base + (oi[c] & kMask), at_i[c]);
      add_eight(base + (oj[c] & kMask), at_j[c]);
    }
    return;
  }
#endif
  constexpr std::size_t scale = sizeof(R) / 4;
  for (int c = 0; c < n; ++c) {
    add_lane(*reinterpret_cast<Load<R>*>(base + scale * (oi[c] & kMask)), c, R(-1), f, k, ti, one);
    add_lane(*reinterpret_cast<Load<R>*>(base + scale * (oj[c] & kMask)), c, R(1), f, k, tj, one);
  }
}
/// The same for one grain of each contact; f is the force on the other side.
template <class R, std::uint32_t kMask>
GROUSER_INLINE void scatter_one(Load<R>* loads, const std::uint32_t* oi, const Vec3L<V<R>>& f, V<R> k,
                                const Vec3L<V<R>>& t, V<R> one) {
  constexpr int n = LanesOf<R>::count;
  char* base = reinterpret_cast<char*>(loads);
#if GROUSER_DEM_BYTES >= 32
  if constexpr (sizeof(R) == 4) {
    VF rf[4], rt[4];
    rows(-f.x, -f.y, -f.z, k, rf);
    rows(t.x, t.y, t.z, one, rt);
    Eight at[n];
    join(rf, rt, at);
    for (int c = 0; c < n; ++c) add_eight(base + (oi[c] & kMask), at[c]);
    return;
  }
#endif
  constexpr std::size_t scale = sizeof(R) / 4;
  for (int c = 0; c < n; ++c) {
    add_lane(*reinterpret_cast<Load<R>*>(base + scale * (oi[c] & kMask)), c, R(-1), f, k, t, one);
  }
}

}  // namespace
}  // namespace grouser::dem
