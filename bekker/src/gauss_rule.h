#pragma once
#include <array>

namespace grouser::bekker {

/// Gauss-Legendre nodes and weights on [0, 1]. n in 1..96.
struct GaussRule {
  int n = 0;
  std::array<double, 96> x{}, w{};
};
const GaussRule& gauss_rule(int n);

}  // namespace grouser::bekker
