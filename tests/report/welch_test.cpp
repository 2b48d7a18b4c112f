#include "welch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>

namespace grouser::report {
namespace {

double area(const Spectrum& s, double from, double to) {
  double a = 0;
  for (std::size_t k = 0; k < s.density.size(); ++k) {
    const double f = static_cast<double>(k) * s.resolution;
    if (f >= from && f <= to) a += s.density[k] * s.resolution;
  }
  return a;
}

TEST(Welch, AreaUnderASinusoidIsHalfItsAmplitudeSquared) {
  const double rate = 200, amplitude = 3, f = 12.34;
  std::vector<double> x(8000);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = 5 + amplitude * std::sin(2 * std::numbers::pi * f * static_cast<double>(i) / rate);
  const Spectrum s = welch(x, rate);
  // The Hann line is four bins wide; 1 % covers its side lobes for a frequency between bins.
  EXPECT_NEAR(area(s, f - 5 * s.resolution, f + 5 * s.resolution), amplitude * amplitude / 2,
              0.01 * amplitude * amplitude / 2);
  // The mean, 5, would bring 25 near zero; what leaks from the line there is far below a thousandth of it.
  EXPECT_LT(area(s, 0, 1), 0.001 * amplitude * amplitude / 2);
  std::size_t top = 0;
  for (std::size_t k = 1; k < s.density.size(); ++k)
    if (s.density[k] > s.density[top]) top = k;
  EXPECT_NEAR(static_cast<double>(top) * s.resolution, f, s.resolution);
}

TEST(Welch, WhiteNoiseIsFlatAtTwiceTheVarianceOverTheRate) {
  const double rate = 500, sd = 0.7;
  std::mt19937_64 engine(5);
  std::vector<double> x(200000);
  for (double& v : x) {
    // Sum of twelve uniform numbers: variance 1 whatever the library's normal distribution does.
    double u = -6;
    for (int k = 0; k < 12; ++k) u += static_cast<double>(engine() >> 11) / 9007199254740992.0;
    v = sd * u;
  }
  const Spectrum s = welch(x, rate);
  const double level = 2 * sd * sd / rate;
  // 195 half-overlapping segments: a band of 50 bins scatters by about 1.2 %; three of these.
  for (double f : {20.0, 100.0, 200.0}) EXPECT_NEAR(area(s, f, f + 25) / 25, level, 0.05 * level) << f;
  EXPECT_NEAR(area(s, 0, rate), sd * sd, 0.03 * sd * sd);
}

TEST(Welch, RefusesWhatHasNoSpectrum) {
  EXPECT_TRUE(welch(std::vector<double>(15, 1.0), 100).density.empty());
  std::vector<double> hole(100, 1.0);
  hole[50] = NAN;
  EXPECT_TRUE(welch(hole, 100).density.empty());
}

}  // namespace
}  // namespace grouser::report
