// Body of the inner loop; a translation unit per instruction set names GROUSER_KERNEL and includes it.
#include <limits>

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
  typename LanesOf<R>::I px, py, pz;
  V<R> r, im, count;
  Vec3L<V<R>> v, w;
};

template <class R, bool kMany>
GROUSER_INLINE State<R> gather(const Grain<R>* grains, const std::uint32_t* o) {
  State<R> s;
  V<R> x{}, y{}, z{};
  const char* base = reinterpret_cast<const char*>(grains);
  constexpr std::uint32_t mask = kMany ? ~(kUnit - 1) : ~0u;
  constexpr std::size_t q = 4 * sizeof(R);
#if GROUSER_DEM_BYTES >= 32
  if constexpr (sizeof(R) == 4) {
    quads<mask>(base, o, x, y, z, s.r);
    quads<mask>(base + q, o, s.v.x, s.v.y, s.v.z, s.im);
    quads<mask>(base + 2 * q, o, s.w.x, s.w.y, s.w.z, s.count);
  } else
#endif
  {
    quads_any<R>(base, o, mask, x, y, z, s.r);
    quads_any<R>(base + q, o, mask, s.v.x, s.v.y, s.v.z, s.im);
    quads_any<R>(base + 2 * q, o, mask, s.w.x, s.w.y, s.w.z, s.count);
  }
  typedef typename LanesOf<R>::I I;
  s.px = reinterpret_cast<I>(x);
  s.py = reinterpret_cast<I>(y);
  s.pz = reinterpret_cast<I>(z);
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

/// Add the eight values of each contact to its two grains, in the order of the list; f is the force on j.
template <class R, std::uint32_t kMask>
GROUSER_INLINE void scatter(Load<R>* loads, const std::uint32_t* oi, const std::uint32_t* oj, const Vec3L<V<R>>& f,
                            V<R> k, const Vec3L<V<R>>& ti, const Vec3L<V<R>>& tj, V<R> one) {
  char* base = reinterpret_cast<char*>(loads);
#if GROUSER_DEM_BYTES == 64
  if constexpr (sizeof(R) == 4) {
    VF rf[4], ri[4], rj[4];
    rows(f.x, f.y, f.z, k, rf);
    rows(ti.x, ti.y, ti.z, one, ri);
    rows(tj.x, tj.y, tj.z, one, rj);
    typedef std::int32_t I16 __attribute__((vector_size(64)));
    const int neg = static_cast<int>(0x80000000u);
    const I16 flip = {neg, neg, neg, 0, neg, neg, neg, 0, neg, neg, neg, 0, neg, neg, neg, 0};
    typedef float V8 __attribute__((vector_size(32)));
    V8 at_i[16], at_j[16];
    for (int m = 0; m < 4; ++m) {
      const VF g = reinterpret_cast<VF>(reinterpret_cast<I16>(rf[m]) ^ flip);
      const auto pair = [](VF a, VF b, V8& lo, V8& hi, V8& lo2, V8& hi2) {
        const VF x = __builtin_shufflevector(a, b, 0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23);
        const VF y = __builtin_shufflevector(a, b, 8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31);
        lo = __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7);
        hi = __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15);
        lo2 = __builtin_shufflevector(y, y, 0, 1, 2, 3, 4, 5, 6, 7);
        hi2 = __builtin_shufflevector(y, y, 8, 9, 10, 11, 12, 13, 14, 15);
      };
      pair(g, ri[m], at_i[m], at_i[m + 4], at_i[m + 8], at_i[m + 12]);
      pair(rf[m], rj[m], at_j[m], at_j[m + 4], at_j[m + 8], at_j[m + 12]);
    }
    for (int c = 0; c < 16; ++c) {
      char* a = base + (oi[c] & kMask);
      store_as(a, load_as<V8>(a) + at_i[c]);
      char* b = base + (oj[c] & kMask);
      store_as(b, load_as<V8>(b) + at_j[c]);
    }
    return;
  }
#elif GROUSER_DEM_BYTES == 32
  if constexpr (sizeof(R) == 4) {
    VF rf[4], ri[4], rj[4];
    rows(f.x, f.y, f.z, k, rf);
    rows(ti.x, ti.y, ti.z, one, ri);
    rows(tj.x, tj.y, tj.z, one, rj);
    typedef std::int32_t I8 __attribute__((vector_size(32)));
    const int neg = static_cast<int>(0x80000000u);
    const I8 flip = {neg, neg, neg, 0, neg, neg, neg, 0};
    VF at_i[8], at_j[8];
    for (int m = 0; m < 4; ++m) {
      const VF g = reinterpret_cast<VF>(reinterpret_cast<I8>(rf[m]) ^ flip);
      at_i[m] = _mm256_permute2f128_ps(g, ri[m], 0x20);
      at_i[m + 4] = _mm256_permute2f128_ps(g, ri[m], 0x31);
      at_j[m] = _mm256_permute2f128_ps(rf[m], rj[m], 0x20);
      at_j[m + 4] = _mm256_permute2f128_ps(rf[m], rj[m], 0x31);
    }
    for (int c = 0; c < 8; ++c) {
      char* a = base + (oi[c] & kMask);
      store_as(a, load_as<VF>(a) + at_i[c]);
      char* b = base + (oj[c] & kMask);
      store_as(b, load_as<VF>(b) + at_j[c]);
    }
    return;
  }
#endif
  constexpr std::size_t scale = sizeof(R) / 4;
  for (int c = 0; c < LanesOf<R>::count; ++c) {
    Load<R>& a = *reinterpret_cast<Load<R>*>(base + scale * (oi[c] & kMask));
    a.f[0] -= f.x[c];
    a.f[1] -= f.y[c];
    a.f[2] -= f.z[c];
    a.k += k[c];
    a.t[0] += ti.x[c];
    a.t[1] += ti.y[c];
    a.t[2] += ti.z[c];
    a.n += one[c];
    Load<R>& b = *reinterpret_cast<Load<R>*>(base + scale * (oj[c] & kMask));
    b.f[0] += f.x[c];
    b.f[1] += f.y[c];
    b.f[2] += f.z[c];
    b.k += k[c];
    b.t[0] += tj.x[c];
    b.t[1] += tj.y[c];
    b.t[2] += tj.z[c];
    b.n += one[c];
  }
}

constexpr std::ptrdiff_t kAhead = 12;  ///< blocks
constexpr std::ptrdiff_t kBatch = 3;   ///< vectors of contacts that go through a stage together

/// What one stage of the pair loop leaves to the next.
template <class R>
struct Stage {
  Geometry<V<R>> g;
  V<R> ci, cj;         ///< arms
  Vec3L<V<R>> f;       ///< force on j
  Vec3L<V<R>> ti, tj;  ///< torques
  V<R> k, one;         ///< stiffness, 1 for a contact
};

template <class R, bool kMany, bool kPlain>
GROUSER_INLINE void pair_geometry(const StepWork<R>& w, const std::uint32_t* oi, const std::uint32_t* oj,
                                  Stage<R>& to) {
  const V<R> half = V<R>{} + R(0.5);
  const State<R> i = gather<R, kMany>(w.grains, oi), j = gather<R, kMany>(w.grains, oj);
  const Vec3L<V<R>> d = {metres<R>(j.px - i.px, w.unit[0]), metres<R>(j.py - i.py, w.unit[1]),
                         metres<R>(j.pz - i.pz, w.unit[2])};
  const V<R> d2 = dot(d, d), sum = i.r + j.r, inv_d = inverse_root(d2);
  Geometry<V<R>>& g = to.g;
  const V<R> delta = sum - root(d2);
  const Vec3L<V<R>> n = scaled(inv_d, d);
  const V<R> cut = half * larger(delta, V<R>{}), ci = i.r - cut, cj = j.r - cut;
  const Vec3L<V<R>> drift = {i.v.x - j.v.x, i.v.y - j.v.y, i.v.z - j.v.z};
  const Vec3L<V<R>> turn = {ci * i.w.x + cj * j.w.x, ci * i.w.y + cj * j.w.y, ci * i.w.z + cj * j.w.z};
  g.n = n;
  g.delta = delta;
  g.un = dot(drift, n);
  g.u = add_cross(drift, turn, n);
  g.spin = {i.w.x - j.w.x, i.w.y - j.w.y, i.w.z - j.w.z};
  const V<R> prod = i.r * j.r, inv = inverse(prod * sum);
  g.reff = (prod * prod) * inv;  // ri rj / (ri + rj)
  g.inv_m = i.im + j.im;
  const V<R> inv_prod = sum * inv;
  const V<R> pi = i.im * (j.r * j.r), pj = j.im * (i.r * i.r);
  const V<R> prod2 = prod * prod, inv_prod2 = inv_prod * inv_prod;
  g.ieff = R(1.4) * prod2 * inverse(pi + pj);
  g.mobility_t = R(3.5) * (i.count * i.im + j.count * j.im);
  g.mobility_r = R(2.5) * (i.count * pi + j.count * pj) * inv_prod2;
  if (!kPlain && w.rate_without_spin) g.drift = drift;
  if (!kPlain && w.cohesive) {
    // pi/4 delta (d + s)(d^2 - (ri - rj)^2)/d^2 with s = ri + rj
    const V<R> wide = delta * (delta > 0 ? sum + sum - delta : V<R>{});
    g.area = R(0.7853981633974483) * wide * (4 * prod - wide) * (inv_d * inv_d);
  }
  to.ci = ci;
  to.cj = cj;
}

template <class R, bool kMany, bool kLedger, bool kPlain>
GROUSER_INLINE void pair_law(const StepWork<R>& w, Block<R>& b, int at, Past<R>* past, Energies* e, Stage<R>& s) {
  History<V<R>> h = {load3<V<R>, R>(b.s, at), load3<V<R>, R>(b.t, at)};
  const Result<V<R>> r =
      contact_law<R, kLedger, kPlain>(w, coefficients<R, kMany>(*w.law, b.i + at), s.g, h, past, at, e);
  store3(b.s, at, h.s);
  store3(b.t, at, h.t);
  const Vec3L<V<R>> arm = cross(r.ft, s.g.n);
  s.f = plus(r.ft, r.fn, s.g.n);
  s.ti = {s.ci * arm.x + r.roll.x, s.ci * arm.y + r.roll.y, s.ci * arm.z + r.roll.z};
  s.tj = {s.cj * arm.x - r.roll.x, s.cj * arm.y - r.roll.y, s.cj * arm.z - r.roll.z};
  s.k = r.k;
  s.one = s.g.delta > 0 ? V<R>{} + 1 : V<R>{};
}

/// Three stages, a few blocks at a time: the whole chain of a contact is longer than what a processor looks ahead, so
/// that one loop over all of it waits for results most of the time.
template <class R, bool kMany, bool kLedger, bool kPlain>
void pairs_loop(const StepWork<R>& w, Block<R>* first, Block<R>* last, [[maybe_unused]] Past<R>* past, Energies* e) {
  constexpr int n = LanesOf<R>::count;
  constexpr std::ptrdiff_t parts = kBlock / n;
  constexpr std::uint32_t mask = kMany ? ~(kUnit - 1) : ~0u;
  Stage<R> stage[kBatch];
  const std::ptrdiff_t all = (last - first) * parts;
  for (std::ptrdiff_t begin = 0; begin < all; begin += kBatch) {
    const std::ptrdiff_t end = begin + kBatch < all ? begin + kBatch : all;
    for (std::ptrdiff_t p = begin; p < end; ++p) {
      const Block<R>* b = first + p / parts;
      const int at = static_cast<int>(p % parts) * n;
      // The other grains of a later block: they lie in other rows of cells, where no hardware prefetcher looks.
      if (last - b > kAhead)
        for (int c = at; c < at + n; ++c) {
          const std::size_t o = b[kAhead].j[c] & mask;
          __builtin_prefetch(reinterpret_cast<const char*>(w.grains) + sizeof(R) / 2 * o);
          __builtin_prefetch(reinterpret_cast<const char*>(w.loads) + sizeof(R) / 4 * o, 1);
        }
      pair_geometry<R, kMany, kPlain>(w, b->i + at, b->j + at, stage[p - begin]);
    }
    for (std::ptrdiff_t p = begin; p < end; ++p)
      pair_law<R, kMany, kLedger, kPlain>(w, first[p / parts], static_cast<int>(p % parts) * n,
                                          kLedger ? past + p / parts : nullptr, e, stage[p - begin]);
    for (std::ptrdiff_t p = begin; p < end; ++p) {
      const Block<R>& b = first[p / parts];
      const int at = static_cast<int>(p % parts) * n;
      const Stage<R>& s = stage[p - begin];
      scatter<R, mask>(w.loads, b.i + at, b.j + at, s.f, s.k, s.ti, s.tj, s.one);
    }
  }
}

template <class R>
void pairs(const StepWork<R>& w, Block<R>* first, Block<R>* last, Past<R>* past, Energies* e) {
  const bool plain = !(w.ch3 || w.spring_cap || w.cohesive || w.rate_without_spin);
  if (e)
    pairs_loop<R, true, true, false>(w, first, last, past, e);
  else if (!plain)
    pairs_loop<R, true, false, false>(w, first, last, past, e);
  else if (w.many)
    pairs_loop<R, true, false, true>(w, first, last, past, e);
  else
    pairs_loop<R, false, false, true>(w, first, last, past, e);
}

/// Grain against surface: R* = r, m* = m; the surface's own motion is in the block.
template <class R, bool kLedger>
void walls_loop(const StepWork<R>& w, WallBlock<R>* first, WallBlock<R>* last, WallSum& total, Energies* e) {
  constexpr int n = LanesOf<R>::count;
  constexpr std::uint32_t mask = ~(kUnit - 1);
  typedef typename LanesOf<R>::Wide Wide;
  Wide force[3] = {}, torque[3] = {}, contacts{};
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
      const Vec3L<V<R>> vs = get(b->v), ws = get(b->w);
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
      const Result<V<R>> r = contact_law<R, kLedger, false>(w, coefficients<R, true>(*w.law, oi), g, h, past, at, e);
      store3(b->s, at, h.s);
      store3(b->t, at, h.t);
      const Vec3L<V<R>> f = plus(r.ft, r.fn, g.n), lever = cross(r.ft, g.n), arm = get(b->at);
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
      constexpr std::size_t scale = sizeof(R) / 4;
      for (int c = 0; c < n; ++c) {
        Load<R>& a = *reinterpret_cast<Load<R>*>(reinterpret_cast<char*>(w.loads) + scale * (oi[c] & mask));
        a.f[0] -= f.x[c];
        a.f[1] -= f.y[c];
        a.f[2] -= f.z[c];
        a.k += r.k[c];
        a.t[0] += t.x[c];
        a.t[1] += t.y[c];
        a.t[2] += t.z[c];
        a.n += one[c];
      }
    }
  }
  for (int k = 0; k < 3; ++k) {
    total.force[k] = sum_of(force[k]);
    total.torque[k] = sum_of(torque[k]);
  }
  total.contacts = static_cast<int>(sum_of(contacts));
}

template <class R>
void walls(const StepWork<R>& w, WallBlock<R>* first, WallBlock<R>* last, WallSum& sum, Energies* e) {
  if (e)
    walls_loop<R, true>(w, first, last, sum, e);
  else
    walls_loop<R, false>(w, first, last, sum, e);
}

/// Kick and drift; the sums are cleared for the next step.
template <class R, bool kDrag>
GROUSER_INLINE void integrate_loop(const StepWork<R>& w, std::size_t first, std::size_t last, StepLimits& limits) {
  typedef typename LanesOf<R>::V4 V4;
  typedef typename LanesOf<R>::I4 I4;
  typedef typename LanesOf<R>::V8 V8;
  typedef typename LanesOf<R>::I8 I8;
  const R h = w.dt, keep = 1 - w.drag * h;
  const V8 dt = {h, h, h, 0, h, h, h, 0}, zero{};
  const V8 kick = {w.gravity[0] * h, w.gravity[1] * h, w.gravity[2] * h, 0, 0, 0, 0, 0};
  const V8 decay = {keep, keep, keep, 1, keep, keep, keep, 1};
  const I8 translation = {-1, -1, -1, -1, 0, 0, 0, 0}, keep_sum = {0, 0, 0, 0, 0, 0, 0, -1};
  const I8 magnitude = I8{} + std::numeric_limits<typename LanesOf<R>::Int>::max();
  const V4 to_units = {h / w.unit[0], h / w.unit[1], h / w.unit[2], 0};
  const I4 three = {-1, -1, -1, 0};
  V8 stiffest{};
  I8 fastest{};  // sizes as whole numbers: not-a-number is larger than any number and stays
  for (std::size_t k = first; k < last; ++k) {
    Grain<R>& g = w.grains[k];
    Load<R>& l = w.loads[k];
    const V8 sum = load_as<V8>(l.f), inverse_inertia = translation ? zero + g.im : zero + g.ii;
    const V8 a = sum * inverse_inertia;
    store_as(l.f, zero);
    V8 v = load_as<V8>(g.v);
    v = v + (a * dt + (inverse_inertia > 0 ? kick : zero));
    if constexpr (kDrag) v = v * decay;
    v = keep_sum ? sum : v;  // the last value counts contacts
    store_as(g.v, v);
    const I8 size = reinterpret_cast<I8>(v) & magnitude;
    fastest = size > fastest ? size : fastest;
    stiffest = a > stiffest ? a : stiffest;
    const V4 move = load_as<V4>(g.v) * to_units + load_as<V4>(g.rest);
    const I4 whole = __builtin_convertvector(move, I4) & three;
    store_as(g.p, load_as<I4>(g.p) + whole);
    store_as(g.rest, move - __builtin_convertvector(whole, V4));
  }
  const V8 top = reinterpret_cast<V8>(fastest);
  const double x = double(top[0]), y = double(top[1]), z = double(top[2]);
  limits.speed2 = x * x + y * y + z * z;
  limits.stiffness = double(stiffest[3]);
}
template <class R>
void integrate(const StepWork<R>& w, std::size_t first, std::size_t last, StepLimits& limits) {
  if (w.drag > 0)
    integrate_loop<R, true>(w, first, last, limits);
  else
    integrate_loop<R, false>(w, first, last, limits);
}

}  // namespace

extern const Kernel GROUSER_KERNEL;
const Kernel GROUSER_KERNEL = {GROUSER_KERNEL_NAME,
                               {pairs<float>, walls<float>, integrate<float>},
                               {pairs<double>, walls<double>, integrate<double>}};

}  // namespace grouser::dem
