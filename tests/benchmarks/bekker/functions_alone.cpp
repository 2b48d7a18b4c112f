#include "functions_alone.h"

#include "lanes.h"

namespace {

using namespace grouser::bekker;

template <bool kRear>
double evaluate(int vectors) {
  alignas(64) double at[kLanes];
  for (int i = 0; i < kLanes; ++i) at[i] = 0.05 + 0.04 * i;
  const Lanes base = load(at);
  Lanes sum{};
  for (int k = 0; k < vectors; ++k) {
    const Lanes x = base + 1e-3 * k;  // no vector waits for the one before
    const auto u = sin_cos_half(x);
    sum += u.sin * u.cos;
    if (kRear) {
      const auto e = sin_cos_half(0.7 * x);
      sum += e.sin * e.cos;
    }
    sum += pow_of(x, 1.1) + exp_of(-3.0 * x) + inverse_sqrt_of(x) + inverse_sqrt_of(1.1 * x);
  }
  return sum_of(sum);
}

}  // namespace

FunctionsAlone functions_alone() {
  return {kLanes, kLanes == 8 ? "avx512" : (kLanes == 4 ? "avx2" : "base"), evaluate<false>, evaluate<true>};
}
