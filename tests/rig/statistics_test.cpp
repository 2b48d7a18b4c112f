#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "grouser/vehicle/rig_statistics.h"

using grouser::vehicle::series;

namespace {

std::vector<double> noise(int n, unsigned seed) {
  std::mt19937 g(seed);
  std::normal_distribution<double> d;
  std::vector<double> x(static_cast<std::size_t>(n));
  for (double& v : x) v = d(g);
  return x;
}

TEST(Stationarity, MeanAndDeviationOfAKnownSeries) {
  std::vector<double> x;
  for (int i = 0; i < 100; ++i) x.push_back(i % 2 == 0 ? 3 : 5);
  const auto s = series(x, 1);
  EXPECT_DOUBLE_EQ(s.mean, 4);
  EXPECT_NEAR(s.sd, std::sqrt(100.0 / 99), 1e-12);
  EXPECT_TRUE(s.stationary);
}

TEST(Stationarity, DriftOfALineIsItsRise) {
  std::vector<double> x;
  for (int i = 0; i < 1000; ++i) x.push_back(7 - 0.002 * i);
  const auto s = series(x, 1);
  EXPECT_NEAR(s.drift, -2.0, 1e-9);
  EXPECT_GT(s.z, 6);  // all 190 pairs of 20 blocks are reversed: (190 - 95)/sqrt(237.5) = 6.16
  EXPECT_FALSE(s.stationary);
}

TEST(Stationarity, ATrendThatDoesNotMatterIsNoFlag) {
  std::vector<double> x;
  for (int i = 0; i < 1000; ++i) x.push_back(100 + 1e-4 * i);
  const auto s = series(x, 1);
  EXPECT_LT(s.z, -6);
  EXPECT_TRUE(s.stationary) << "0.1 over a mean of 100 is a tenth of the tolerance";
}

// White noise is flagged about 1 time in 20 at most: chance alone, the drift condition can only make it rarer.
TEST(Stationarity, NoiseIsRarelyFlaggedAndDriftingNoiseNearlyAlways) {
  int flagged = 0, found = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto x = noise(400, seed);
    flagged += !series(x, 1).stationary;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += 2.0 * static_cast<double>(i) / 400.0;
    found += !series(x, 1).stationary;
  }
  EXPECT_LE(flagged, 20);  // expected 10, sd 3
  EXPECT_GE(found, 195);
}

TEST(Stationarity, TooFewSamplesSayNothing) {
  EXPECT_FALSE(series(noise(39, 1), 1).stationary);
  EXPECT_FALSE(series({}, 1).stationary);
}

}  // namespace
