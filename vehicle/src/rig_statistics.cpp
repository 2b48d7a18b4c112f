#include "grouser/vehicle/rig_statistics.h"

#include <array>
#include <cmath>

namespace grouser::vehicle {

Series series(std::span<const double> x, double scale, double tolerance) {
  constexpr std::size_t blocks = 20;
  Series s;
  const auto n = static_cast<double>(x.size());
  if (x.empty()) {
    s.stationary = false;
    return s;
  }
  double sum = 0;
  for (double v : x) sum += v;
  s.mean = sum / n;
  double squares = 0, moment = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double d = x[i] - s.mean;
    squares += d * d;
    moment += d * (static_cast<double>(i) - 0.5 * (n - 1));
  }
  if (x.size() < 2 * blocks) {
    s.stationary = false;
    return s;
  }
  s.sd = std::sqrt(squares / (n - 1));
  s.drift = moment / (n * (n * n - 1) / 12) * n;

  std::array<double, blocks> mean{};
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t from = b * x.size() / blocks, to = (b + 1) * x.size() / blocks;
    for (std::size_t i = from; i < to; ++i) mean[b] += x[i];
    mean[b] /= static_cast<double>(to - from);
  }
  // Ties count half, so that a constant series has no trend.
  double reversed = 0;
  for (std::size_t i = 0; i < blocks; ++i)
    for (std::size_t j = i + 1; j < blocks; ++j) reversed += mean[i] > mean[j] ? 1.0 : mean[i] == mean[j] ? 0.5 : 0.0;
  constexpr double m = blocks;
  s.z = (reversed - m * (m - 1) / 4) / std::sqrt(m * (2 * m + 5) * (m - 1) / 72);
  s.stationary = !(std::abs(s.z) > 1.96 && std::abs(s.drift) > tolerance * std::max(std::abs(s.mean), scale));
  return s;
}

}  // namespace grouser::vehicle
