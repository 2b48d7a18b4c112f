#include "functions_alone.h"

#include "lanes.h"

namespace {

using namespace grouser::bekker;

template <bool kRear, Digits kDigits>
double evaluate(int vectors) {
  alignas(64) double at[kLanes];
  for (int i = 0; i < kLanes; ++i) at[i] = 0.05 + 0.04 * i;
  const Lanes base = load(at);
  Lanes sum{};
  for (int k = 0; k < vectors; ++k) {
    const Lanes x = base + 1e-3 * k;  // no vector waits for the one before
    const auto u = sin_cos_half<kDigits>(x);
    sum += u.sin * u.cos;
    if (kRear) {
      const auto e = sin_cos_half<kDigits>(0.7 * x);
      sum += e.sin * e.cos;
    }
    sum += pow_of<kDigits>(x, 1.1) + exp_of<kDigits>(-3.0 * x) + inverse_sqrt_of<kDigits>(x) +
           inverse_sqrt_of<kDigits>(1.1 * x);
  }
  return sum_of(sum);
}

}  // namespace

FunctionsAlone functions_alone() {
  return {kLanes,
          kLanes == 8 ? "avx512" : (kLanes == 4 ? "avx2" : "base"),
          evaluate<false, Digits::all>,
          evaluate<true, Digits::all>,
          evaluate<false, Digits::ten>,
          evaluate<true, Digits::ten>};
}
