#pragma once
// The ways that surrogate and grains go (examples/17_surrogate_by_direction/validation.yaml), and what means are taken over.
#include <algorithm>
#include <cmath>

namespace track {

constexpr double kFlat = 0.25, kRough = 0.3;  ///< [m]
constexpr double kFrom = 0.35;                ///< share of the way after which means are taken
constexpr double kEnd = 0.2;                  ///< share of the way that is its end
constexpr double kAheadFrom = 0.03, kAheadTo = 0.056,
                 kBehind = 0.03;  ///< of the hub, where the soil's level is read [m]
constexpr double kColumn = 2e-3;  ///< [m]

/// Ground of section 5.4.2 at the way s, run in over 50 mm from 30 mm on [m].
inline double sinusoid(double s) {
  constexpr double start = 0.03, run_in = 0.05, amplitude = 9.75e-3, wavenumber = 32.2;
  if (s <= start) return 0;
  const double u = std::min(1.0, (s - start) / run_in);
  return amplitude * u * u * (3 - 2 * u) * std::sin(wavenumber * (s - start));
}

/// Mean and standard deviation of what is finite.
struct Moments {
  double sum = 0, square = 0, n = 0;
  void add(double x) {
    if (std::isfinite(x)) sum += x, square += x * x, n += 1;
  }
  double mean() const { return sum / n; }
  double sd() const { return std::sqrt(std::max(0.0, square / n - mean() * mean())); }
};

}  // namespace track
