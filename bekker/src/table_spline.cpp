#include "table_spline.h"

#include <Eigen/Dense>

namespace grouser::bekker {

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Interpolation at the n points, and no jump of the third derivative at the second and the last but one.
Eigen::PartialPivLU<Eigen::MatrixXd> factorised(int n) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + 2, n + 2);
  for (int i = 0; i < n; ++i) a.block<1, 3>(i, i) << 1.0 / 6, 4.0 / 6, 1.0 / 6;
  for (int end = 0; end < 2; ++end) a.block<1, 5>(n + end, end ? n - 3 : 0) << 1, -4, 6, -4, 1;
  return a.partialPivLu();
}

/// Along the middle axis of [outer][n][inner].
std::vector<double> along(const std::vector<double>& values, int outer, int n, int inner) {
  std::vector<double> out(static_cast<std::size_t>(outer) * (n + 2) * inner);
  const auto lu = n > 1 ? factorised(n) : Eigen::PartialPivLU<Eigen::MatrixXd>();
  for (int o = 0; o < outer; ++o) {
    const Eigen::Map<const Rows> from(&values[static_cast<std::size_t>(o) * n * inner], n, inner);
    Eigen::Map<Rows> to(&out[static_cast<std::size_t>(o) * (n + 2) * inner], n + 2, inner);
    if (n == 1) {
      to = from.replicate(n + 2, 1);
      continue;
    }
    Rows right = Rows::Zero(n + 2, inner);
    right.topRows(n) = from;
    to = lu.solve(right);
  }
  return out;
}

}  // namespace

std::vector<float> spline_coefficients(const std::vector<double>& values, std::array<int, 3> n, int channels) {
  std::vector<double> c = along(values, n[0] * n[1], n[2], channels);
  c = along(c, n[0], n[1], (n[2] + 2) * channels);
  c = along(c, 1, n[0], (n[1] + 2) * (n[2] + 2) * channels);
  std::vector<float> out(c.begin(), c.end());
  // An axis of one point has three coefficients where a query reads four, the last with weight zero: let it find a zero there.
  out.resize(out.size() + static_cast<std::size_t>(n[1] + 4) * (n[2] + 2) * channels, 0.0f);
  return out;
}

}  // namespace grouser::bekker
