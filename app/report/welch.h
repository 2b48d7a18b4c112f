#pragma once
#include <span>
#include <vector>

namespace grouser::report {

/// Power spectral density by Welch's method (Welch 1967): segments of n samples, half overlapping, mean of each
/// removed, periodic Hann window w, one-sided:
///   G(k df) = 2 / (fs sum w^2) * mean over segments of |FFT(w (x - mean))_k|^2,   df = fs / n
/// (not doubled at 0 and at fs/2), so that the sum of G df is the variance. Unit: [x]^2/Hz.
struct Spectrum {
  double resolution = 0;  ///< df [Hz]
  int segments = 0;
  std::vector<double> density;  ///< at k df, k = 0 .. n/2
};

/// n is the greatest power of two that fits into `seconds` of signal and at most half of the samples (all of them when
/// they are fewer than 256). Empty when there are fewer than 16 samples or one is not finite.
/// @param rate fs [Hz] > 0
Spectrum welch(std::span<const double> x, double rate, double seconds = 5.0);

}  // namespace grouser::report
