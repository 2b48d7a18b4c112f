#pragma once
// Several doubles at once: a vector as wide as the translation unit's instruction set, and the functions the stress law
// needs. Everything is always inlined and lives in a namespace of its own per instruction set, so that units compiled
// for different ones can be linked together. The same functions exist for double, so that a law can be written once for
// both.
//
// Accuracy, over all doubles in range (tests/analytic/lanes_test.cpp): exp, log 2 ulp; sin 3 ulp; cos 1.5 ulp of 1; pow
// |n log x| + 2 ulp.
#include <cmath>
#include <cstdint>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#if defined(__AVX512F__)
#define GROUSER_LANES 8
#define GROUSER_LANES_NAMESPACE lanes_avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define GROUSER_LANES 4
#define GROUSER_LANES_NAMESPACE lanes_avx2
#else
#define GROUSER_LANES 2
#define GROUSER_LANES_NAMESPACE lanes_base
#endif
#define GROUSER_INLINE [[gnu::always_inline]] inline

namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE {

inline constexpr int kLanes = GROUSER_LANES;
typedef double Lanes __attribute__((vector_size(8 * GROUSER_LANES)));
typedef std::int64_t Bits
    __attribute__((vector_size(8 * GROUSER_LANES)));  ///< also the type of a comparison: -1 true, 0 false
typedef std::uint64_t Words __attribute__((vector_size(8 * GROUSER_LANES)));

GROUSER_INLINE Lanes splat(double x) { return x - Lanes{}; }
GROUSER_INLINE Lanes load(const double* p) {
  Lanes v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
GROUSER_INLINE void store(double* p, Lanes v) { __builtin_memcpy(p, &v, sizeof v); }
GROUSER_INLINE Lanes select(Bits m, Lanes a, Lanes b) { return m ? a : b; }
GROUSER_INLINE double select(bool m, double a, double b) { return m ? a : b; }
GROUSER_INLINE Lanes max_of(Lanes a, Lanes b) { return a > b ? a : b; }
GROUSER_INLINE double max_of(double a, double b) { return a > b ? a : b; }
GROUSER_INLINE Lanes abs_of(Lanes x) { return x < 0 ? -x : x; }
GROUSER_INLINE double abs_of(double x) { return std::fabs(x); }
/// x of the size of s.
GROUSER_INLINE Lanes with_sign(Lanes x, Lanes s) { return s < 0 ? -x : x; }
GROUSER_INLINE double with_sign(double x, double s) { return s < 0 ? -x : x; }

GROUSER_INLINE Lanes sqrt_of(Lanes x) {
#if GROUSER_LANES == 8
  return _mm512_maskz_sqrt_pd(0xff, x);  // the plain form warns of its undefined operand (GCC 12)
#elif GROUSER_LANES == 4
  return _mm256_sqrt_pd(x);
#elif defined(__SSE2__)
  return _mm_sqrt_pd(x);
#else
  for (int i = 0; i < kLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}
GROUSER_INLINE double sqrt_of(double x) { return std::sqrt(x); }

/// What a function is good for: all digits of a double, or ten of them (relative error 2e-10, sine 3e-11, cosine 4e-10
/// of 1), for sums that are wanted to 1e-6.
enum class Digits { all, ten };

/// 1/sqrt(x) for x > 0. AVX-512's estimate of 14 bits and one step of fourth order keep the divider free.
template <Digits kDigits = Digits::all>
GROUSER_INLINE Lanes inverse_sqrt_of(Lanes x) {
#if GROUSER_LANES == 8
  const Lanes y = _mm512_maskz_rsqrt14_pd(0xff, x), e = 1 - (x * y) * y;
  if constexpr (kDigits == Digits::ten) return y + (y * e) * (0.5 + e * 0.375);
  return y + (y * e) * (0.5 + e * (0.375 + e * 0.3125));
#else
  return 1 / sqrt_of(x);
#endif
}
template <Digits = Digits::all>
GROUSER_INLINE double inverse_sqrt_of(double x) {
  return 1 / std::sqrt(x);
}
/// a/b, b of moderate size.
template <Digits kDigits = Digits::all>
GROUSER_INLINE Lanes ratio_of(Lanes a, Lanes b) {
#if GROUSER_LANES == 8
  const Lanes y = _mm512_maskz_rcp14_pd(0xff, b), e = 1 - b * y;
  if constexpr (kDigits == Digits::ten) return a * (y + y * e);
  return a * (y + (y * e) * (1 + e * (1 + e)));
#else
  return a / b;
#endif
}

GROUSER_INLINE double sum_of(Lanes x) {
#if GROUSER_LANES == 8
  x += __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3);
  x += __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5);
#elif GROUSER_LANES == 4
  x += __builtin_shufflevector(x, x, 2, 3, 0, 1);
#endif
  return x[0] + x[1];
}

/// exp(x) for |x| <= 708; beyond that the value at the limit. Taylor-like polynomial over |r| <= ln 2/2 after x = k ln
/// 2 + r.
template <Digits kDigits = Digits::all>
GROUSER_INLINE Lanes exp_of(Lanes x) {
  x = x < -708 ? splat(-708) : x;
  x = x > 708 ? splat(708) : x;
  const double magic = 0x1.8p52;
  const Lanes t = x * 1.4426950408889634 + magic, k = t - magic;
  if constexpr (kDigits == Digits::ten) {
    const Lanes s = x - k * 0.6931471805599453, s2 = s * s;
    const Lanes c01 = 0.5000000077904413 + s * 0.16666666860701096;
    const Lanes c23 = 0.04166626993826554 + s * 0.008333264353876331;
    const Lanes c45 = 0.0013946073568668503 + s * 0.00019918386000125995;
    const Lanes y = 1 + (s + s2 * (c01 + s2 * (c23 + s2 * c45)));
    return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(y) + (reinterpret_cast<Bits>(t) << 52));
  }
  const Lanes r = (x - k * 0x1.62e42fefa38p-1) - k * 0x1.ef35793c7673p-45;
  const Lanes r2 = r * r, r4 = r2 * r2;
  const Lanes q01 = 0.5000000000000001 + r * 0.16666666666666669, q23 = 0.04166666666662416 + r * 0.008333333333330063;
  const Lanes q45 = 0.0013888888917199863 + r * 0.00019841269863042963;
  const Lanes q67 = 2.4801521317484083e-05 + r * 2.7557268476553695e-06;
  const Lanes q89 = 2.7620078203806394e-07 + r * 2.5100377619606372e-08;
  const Lanes q = (q01 + r2 * q23) + r4 * ((q45 + r2 * q67) + r4 * q89);
  const Lanes p = 1 + (r + r2 * q);
  return reinterpret_cast<Lanes>(reinterpret_cast<Bits>(p) + (reinterpret_cast<Bits>(t) << 52));
}
template <Digits = Digits::all>
GROUSER_INLINE double exp_of(double x) {
  return std::exp(x);
}

/// log(x) of normal x > 0. x = 2^k m, m in 0.7..1.42; log m = 2 s + s^3 R(s^2), s = (m - 1)/(m + 1).
template <Digits kDigits = Digits::all>
GROUSER_INLINE Lanes log_of(Lanes x) {
  const std::uint64_t half_root = 0x3fe6a09e667f3bcdULL, bias = 1024ULL << 52, exponent = 0x7ffULL << 52;
  const Words u = reinterpret_cast<Words>(x), v = u - half_root + bias;
  const Words m_bits = u - (v & (exponent | (1ULL << 63))) + bias;
  const Lanes k = reinterpret_cast<Lanes>((v >> 52) | 0x4330000000000000ULL) - (0x1p52 + 1024);
  const Lanes f = reinterpret_cast<Lanes>(m_bits) - 1, s = ratio_of<kDigits>(f, 2 + f), z = s * s, z2 = z * z;
  if constexpr (kDigits == Digits::ten) {
    const Lanes tail = 0.6666681716191258 + z * (0.3997354937304797 + z * 0.2996270536991203);
    return k * 0.6931471805599453 + (f - s * (f - z * tail));
  }
  const Lanes r01 = 0.666666666666667 + z * 0.3999999999989949, r23 = 0.2857142862598255 + z * 0.22222211133642084;
  const Lanes r45 = 0.18182889209266595 + z * 0.1533171880828007;
  const Lanes R = (r01 + z2 * r23) + (z2 * z2) * (r45 + z2 * 0.14616484198366603);
  // log(1 + f) = f - s (f - z R): the leading term carries no rounding of the division.
  return k * 0x1.62e42fefa38p-1 + (f - (s * (f - z * R) - k * 0x1.ef35793c7673p-45));
}
template <Digits = Digits::all>
GROUSER_INLINE double log_of(double x) {
  return std::log(x);
}

/// x^n of normal x > 0.
template <Digits kDigits = Digits::all, class N>
GROUSER_INLINE Lanes pow_of(Lanes x, N n) {
  return exp_of<kDigits>(n * log_of<kDigits>(x));
}
template <Digits = Digits::all>
GROUSER_INLINE double pow_of(double x, double n) {
  return std::pow(x, n);
}

/// sin x and cos x for |x| <= pi/2.
template <class V>
struct SinCos {
  V sin, cos;
};
template <Digits kDigits = Digits::all, class V>
GROUSER_INLINE SinCos<V> sin_cos_polynomial(V x) {
  const V z = x * x, z2 = z * z, z4 = z2 * z2;
  if constexpr (kDigits == Digits::ten) {
    const V a01 = -0.1666666663179239 + z * 0.00833333132596819;
    const V a23 = -0.00019840894404054882 + z * 2.752663326673758e-06;
    const V b01 = 0.041666655768851237 + z * -0.0013888569067157515;
    const V b23 = 2.4769297892112578e-05 + z * -2.6193682202684183e-07;
    const V a = a01 + z2 * (a23 + z2 * -2.3909485862504472e-08);
    return {x + x * (z * a), 1 - (z * 0.5 - z2 * (b01 + z2 * b23))};
  }
  const V s01 = -0.16666666666666666 + z * 0.008333333333333316;
  const V s23 = -0.00019841269841254966 + z * 2.7557319219160833e-06;
  const V s45 = -2.505210761669045e-08 + z * 1.6058977292642743e-10;
  const V s67 = -7.643969663988074e-13 + z * 2.7314368769379893e-15;
  const V s = (s01 + z2 * s23) + z4 * (s45 + z2 * s67);
  const V c01 = 0.041666666666666664 + z * -0.001388888888888888;
  const V c23 = 2.4801587301579848e-05 + z * -2.755731922156836e-07;
  const V c45 = 2.0876756602722215e-09 + z * -1.1470712262813793e-11;
  const V c67 = 4.77787760803859e-14 + z * -1.5218598818596388e-16;
  const V c = (c01 + z2 * c23) + z4 * (c45 + z2 * c67);
  return {x + x * (z * s), 1 - (z * 0.5 - z2 * c)};
}
template <Digits kDigits = Digits::all>
GROUSER_INLINE SinCos<Lanes> sin_cos_half(Lanes x) {
  return sin_cos_polynomial<kDigits>(x);
}
template <Digits = Digits::all>
GROUSER_INLINE SinCos<double> sin_cos_half(double x) {
  return {std::sin(x), std::cos(x)};
}

}  // namespace grouser::bekker::inline GROUSER_LANES_NAMESPACE
