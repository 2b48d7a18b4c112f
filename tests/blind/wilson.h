#pragma once
// Interval of a rate, and of a median.
#include <utility>
#include <vector>

namespace blind {

struct Tally {
  int yes = 0, n = 0;
  void add(bool hit) {
    yes += hit ? 1 : 0;
    ++n;
  }
  double rate() const { return n > 0 ? static_cast<double>(yes) / n : 0.0; }
};

/// Wilson (1927) score interval of a rate, without continuity correction; confidence of both sides together. [0, 1]
/// for n = 0.
std::pair<double, double> wilson(const Tally& tally, double confidence = 0.90);

struct Median {
  double value, low, high;
};

/// Median with the order-statistic interval (Thompson 1936) of the stated confidence; NaN for an empty list.
Median median(std::vector<double> values, double confidence = 0.90);

}  // namespace blind
