#pragma once
// Several numbers at once, single or double precision: a vector as wide as the translation unit's instruction set, and
// the few functions the contact law needs. All is inlined and lives in a namespace of its own per instruction set.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

// Wide vectors are only ever passed between inlined functions.
#pragma GCC diagnostic ignored "-Wpsabi"

#if defined(__AVX512F__)
#define GROUSER_DEM_BYTES 64
#define GROUSER_DEM_ISA isa_avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define GROUSER_DEM_BYTES 32
#define GROUSER_DEM_ISA isa_avx2
#else
#define GROUSER_DEM_BYTES 16
#define GROUSER_DEM_ISA isa_base
#endif
#define GROUSER_INLINE [[gnu::always_inline]] inline

namespace grouser::dem::inline GROUSER_DEM_ISA {

template <class R>
struct LanesOf;
template <>
struct LanesOf<float> {
  using Int = std::int32_t;
  static constexpr int count = GROUSER_DEM_BYTES / 4;
  typedef float V __attribute__((vector_size(GROUSER_DEM_BYTES)));
  typedef std::int32_t I __attribute__((vector_size(GROUSER_DEM_BYTES)));
  typedef float V4 __attribute__((vector_size(16)));
  typedef std::int32_t I4 __attribute__((vector_size(16)));
  typedef float V8 __attribute__((vector_size(32)));
  typedef std::int32_t I8 __attribute__((vector_size(32)));
  typedef double Wide __attribute__((vector_size(2 * GROUSER_DEM_BYTES)));
};
template <>
struct LanesOf<double> {
  using Int = std::int64_t;
  static constexpr int count = GROUSER_DEM_BYTES / 8;
  typedef double V __attribute__((vector_size(GROUSER_DEM_BYTES)));
  typedef std::int64_t I __attribute__((vector_size(GROUSER_DEM_BYTES)));
  typedef double V4 __attribute__((vector_size(32)));
  typedef std::int64_t I4 __attribute__((vector_size(32)));
  typedef double V8 __attribute__((vector_size(64)));
  typedef std::int64_t I8 __attribute__((vector_size(64)));
  typedef double Wide __attribute__((vector_size(GROUSER_DEM_BYTES)));
};
using VF = LanesOf<float>::V;
using VD = LanesOf<double>::V;

template <class V>
GROUSER_INLINE V load_as(const void* p) {
  V v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
template <class V>
GROUSER_INLINE void store_as(void* p, V v) {
  __builtin_memcpy(p, &v, sizeof v);
}
template <class V>
GROUSER_INLINE V larger(V a, V b) {
  return a > b ? a : b;
}
template <class V>
GROUSER_INLINE V smaller(V a, V b) {
  return a < b ? a : b;
}
GROUSER_INLINE VF absolute(VF x) {
  typedef LanesOf<float>::I I;
  return reinterpret_cast<VF>(reinterpret_cast<I>(x) & 0x7fffffff);
}
GROUSER_INLINE VD absolute(VD x) {
  typedef LanesOf<double>::I I;
  return reinterpret_cast<VD>(reinterpret_cast<I>(x) & 0x7fffffffffffffffLL);
}

GROUSER_INLINE double absolute(double x) { return std::fabs(x); }
GROUSER_INLINE double root(double x) { return std::sqrt(x); }
GROUSER_INLINE VF root(VF x) {
#if GROUSER_DEM_BYTES == 64
  return _mm512_maskz_sqrt_ps(0xffff, x);  // the plain form warns of its undefined operand (GCC 12)
#elif GROUSER_DEM_BYTES == 32
  return _mm256_sqrt_ps(x);
#elif defined(__SSE2__)
  return _mm_sqrt_ps(x);
#else
  for (int i = 0; i < LanesOf<float>::count; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}
GROUSER_INLINE VD root(VD x) {
#if GROUSER_DEM_BYTES == 64
  return _mm512_maskz_sqrt_pd(0xff, x);
#elif GROUSER_DEM_BYTES == 32
  return _mm256_sqrt_pd(x);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(x);
#else
  for (int i = 0; i < LanesOf<double>::count; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}
/// 1/sqrt(x), x > 0. AVX-512: estimate of 14 bits and one Newton step, 2^-23 relative.
GROUSER_INLINE VF inverse_root(VF x) {
#if GROUSER_DEM_BYTES == 64
  const VF y = _mm512_maskz_rsqrt14_ps(0xffff, x);
  return y * (1.5f - (0.5f * x) * (y * y));
#else
  return 1.0f / root(x);
#endif
}
GROUSER_INLINE VD inverse_root(VD x) { return 1.0 / root(x); }
/// 1/x, x of moderate size. AVX-512: estimate of 14 bits and one Newton step.
GROUSER_INLINE VF inverse(VF x) {
#if GROUSER_DEM_BYTES == 64
  const VF y = _mm512_maskz_rcp14_ps(0xffff, x);
  return y * (2.0f - x * y);
#else
  return 1.0f / x;
#endif
}
GROUSER_INLINE VD inverse(VD x) { return 1.0 / x; }

template <class V>
struct Vec3L {
  V x, y, z;
};
template <class V>
GROUSER_INLINE V dot(const Vec3L<V>& a, const Vec3L<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
GROUSER_INLINE Vec3L<V> cross(const Vec3L<V>& a, const Vec3L<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V>
GROUSER_INLINE Vec3L<V> minus(const Vec3L<V>& a, const Vec3L<V>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
/// a - c n
template <class V>
GROUSER_INLINE Vec3L<V> less(const Vec3L<V>& a, V c, const Vec3L<V>& n) {
  return {a.x - c * n.x, a.y - c * n.y, a.z - c * n.z};
}
template <class V>
GROUSER_INLINE Vec3L<V> scaled(V c, const Vec3L<V>& a) {
  return {c * a.x, c * a.y, c * a.z};
}

/// a + c n
template <class V>
GROUSER_INLINE Vec3L<V> plus(const Vec3L<V>& a, V c, const Vec3L<V>& n) {
  return {a.x + c * n.x, a.y + c * n.y, a.z + c * n.z};
}
/// a + b x c
template <class V>
GROUSER_INLINE Vec3L<V> add_cross(const Vec3L<V>& a, const Vec3L<V>& b, const Vec3L<V>& c) {
  return {(a.x + b.y * c.z) - b.z * c.y, (a.y + b.z * c.x) - b.x * c.z, (a.z + b.x * c.y) - b.y * c.x};
}

}  // namespace grouser::dem::inline GROUSER_DEM_ISA
