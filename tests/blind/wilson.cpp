#include "wilson.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>

namespace blind {

std::pair<double, double> wilson(const Tally& tally, double confidence) {
  if (tally.n == 0) return {0.0, 1.0};
  const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence), n = tally.n, p = tally.rate();
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(centre - half, 0.0), std::min(centre + half, 1.0)};
}

Median median(std::vector<double> values, double confidence) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (values.empty()) return {nan, nan, nan};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double middle = n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  // The j-th smallest is below the median unless fewer than j values are: P(Binomial(n, 1/2) < j) <= (1 -
  // confidence)/2.
  const boost::math::binomial half(static_cast<double>(n), 0.5);
  std::size_t j = 0;
  while (2 * (j + 1) <= n && boost::math::cdf(half, static_cast<double>(j)) <= 0.5 * (1.0 - confidence)) ++j;
  return {middle, values[j > 0 ? j - 1 : 0], values[j > 0 ? n - j : n - 1]};
}

}  // namespace blind
