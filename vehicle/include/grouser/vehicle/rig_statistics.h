#pragma once
#include <span>

namespace grouser::vehicle {

/// Mean, spread and trend of one channel over the averaging window.
struct Series {
  double mean = 0, sd = 0;  ///< sd with n - 1
  double drift = 0;         ///< [unit] slope of the least-squares line times the window: change over the window
  double z = 0;  ///< [-] reverse-arrangements statistic of 20 block means, standard normal without a trend; + = falling
  bool stationary = true;
};

/// Stationarity: the window is cut into 20 equal blocks; their means are tested for a trend by reverse arrangements
/// (Kendall 1938; Bendat & Piersol 2010, Random Data, 4.5.2): A = number of i < j with m_i > m_j, z = (A - n(n-1)/4) / sqrt(n(2n+5)(n-1)/72).
/// Not stationary when the trend is significant (|z| > 1.96, 5 %) and matters (|drift| > tolerance * max(|mean|, scale)): a smooth
/// simulation has a significant trend however small, a noisy one drifts by chance.
/// @param scale [unit] of the channel below which relative drift is not asked for, > 0; @param tolerance [-], 0.01 by default
/// Fewer than 40 samples: stationary = false, for nothing can be said.
Series series(std::span<const double> x, double scale, double tolerance = 0.01);

}  // namespace grouser::vehicle
