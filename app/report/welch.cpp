#include "welch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace grouser::report {

Spectrum welch(std::span<const double> x, double rate, double seconds) {
  Spectrum s;
  if (x.size() < 16 || !(rate > 0)) return s;
  for (double v : x)
    if (!std::isfinite(v)) return s;
  const std::size_t most = x.size() < 256 ? x.size() : x.size() / 2;
  const auto wished = static_cast<std::size_t>(std::max(16.0, seconds * rate));
  const std::size_t n = std::bit_floor(std::min(most, wished));

  std::vector<double> window(n);
  double power = 0;
  for (std::size_t i = 0; i < n; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
    power += window[i] * window[i];
  }

  Eigen::FFT<double> fft;
  std::vector<double> part(n);
  std::vector<std::complex<double>> bins;
  s.density.assign(n / 2 + 1, 0.0);
  for (std::size_t at = 0; at + n <= x.size(); at += n / 2) {
    double mean = 0;
    for (std::size_t i = 0; i < n; ++i) mean += x[at + i] / static_cast<double>(n);
    for (std::size_t i = 0; i < n; ++i) part[i] = window[i] * (x[at + i] - mean);
    fft.fwd(bins, part);
    for (std::size_t k = 0; k <= n / 2; ++k) s.density[k] += std::norm(bins[k]);
    ++s.segments;
  }
  for (std::size_t k = 0; k <= n / 2; ++k)
    s.density[k] *= (k == 0 || k == n / 2 ? 1.0 : 2.0) / (rate * power * s.segments);
  s.resolution = rate / static_cast<double>(n);
  return s;
}

}  // namespace grouser::report
