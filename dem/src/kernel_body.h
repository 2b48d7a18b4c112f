// Body of the inner loop; a translation unit per instruction set names GROUSER_KERNEL and includes it.
#include <limits>

#include "contact_law.h"
#include "gather_lanes.h"
#include "walls_body.h"

namespace grouser::dem {
namespace {

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
  const Vec3L<V<R>> d = {metres<R>(j.p[0] - i.p[0], w.unit[0]), metres<R>(j.p[1] - i.p[1], w.unit[1]),
                         metres<R>(j.p[2] - i.p[2], w.unit[2])};
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
                               {pairs<float>, walls<float>, touch<float>, integrate<float>},
                               {pairs<double>, walls<double>, touch<double>, integrate<double>}};

}  // namespace grouser::dem
