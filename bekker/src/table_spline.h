#pragma once
// Cubic B-spline on uniform grids over the unit cube.
#include <array>
#include <cstddef>
#include <vector>

namespace grouser::bekker {

/// Four floats, and the sixteen of four coefficients with four channels each.
typedef float Four __attribute__((vector_size(16)));
typedef float Sixteen __attribute__((vector_size(64)));

// What a look-up runs through is always inlined and free of library calls: so it takes the instruction set of its
// caller.

/// Axis of n points over [0, 1].
struct SplineAxis {
  double cells = 0;  ///< n - 1
  int last = 0;      ///< cell
  SplineAxis() = default;
  explicit SplineAxis(int n) : cells(n - 1), last(n > 1 ? n - 2 : 0) {}
};

/// The four B-splines that are not zero at u in [0, 1].
struct SplineWeights {
  std::size_t first;  ///< of the four coefficients
  Four w;
  [[gnu::always_inline]] SplineWeights(double u, const SplineAxis& axis) {
    const double x = u * axis.cells;
    int cell = static_cast<int>(x);
    cell = cell < 0 ? 0 : cell > axis.last ? axis.last : cell;
    first = static_cast<std::size_t>(cell);
    const auto t = static_cast<float>(x - cell);
    constexpr float s = 1.0f / 6;
    constexpr Four c0{s, 4 * s, s, 0}, c1{-3 * s, 0, 3 * s, 0}, c2{3 * s, -6 * s, 3 * s, 0}, c3{-s, 3 * s, -3 * s, s};
    w = ((c3 * t + c2) * t + c1) * t + c0;
  }
};

/// Sum over 4 x 4 coefficients, `row` floats from one of the first axis to the next.
[[gnu::always_inline]] inline float spline_sum(const float* c, std::size_t row, const Four& a, const Four& b) {
  Four sum{};
  for (int i = 0; i < 4; ++i, c += row) {
    Four x;
    __builtin_memcpy(&x, c, sizeof x);
    sum += a[i] * x;
  }
  sum *= b;
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Four channels over 4 x 4 x 4 coefficients.
[[gnu::always_inline]] inline Four spline_sum(const float* c, std::size_t plane, std::size_t row, const Four& a,
                                              const Four& b, const Four& d) {
  Sixteen sum{};
  for (int i = 0; i < 4; ++i, c += plane) {
    Sixteen part{};
    for (int j = 0; j < 4; ++j) {
      Sixteen x;
      __builtin_memcpy(&x, c + static_cast<std::size_t>(j) * row, sizeof x);
      part += b[j] * x;
    }
    sum += a[i] * part;
  }
  Four k[4];
  __builtin_memcpy(k, &sum, sizeof k);
  return (d[0] * k[0] + d[1] * k[1]) + (d[2] * k[2] + d[3] * k[3]);
}

/// Coefficients [n0 + 2][n1 + 2][n2 + 2][channels] of the spline through values [n0][n1][n2][channels]; the ends are
/// not-a-knot. An axis of one point is constant; otherwise an axis has at least 4.
std::vector<float> spline_coefficients(const std::vector<double>& values, std::array<int, 3> n, int channels);

}  // namespace grouser::bekker
