#pragma once
// Synthetic soil tests with known parameters: Table 4.1 of the dissertation, formulas written out here on their own.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "grouser/diagnosis/soil_tests.h"

namespace grouser::test {

constexpr double mms_c = 139.28, mms_phi = 0.606, mms_K = 5.151e-4, mms_k = 2.541e5, mms_n = 1.387;

struct Noise {
  std::mt19937_64 engine;
  std::normal_distribution<double> normal;
  explicit Noise(unsigned seed) : engine(seed) {}
  double operator()(double sd) { return sd * normal(engine); }
};

/// The three loads and the 6.5 mm of section 4.2.1. sd [Pa] of independent noise.
inline std::vector<diagnosis::ShearCurve> janosi_curves(double sd, unsigned seed, int points = 65, double K = mms_K) {
  Noise noise(seed);
  std::vector<diagnosis::ShearCurve> out;
  for (const double sigma : {2080.0, 5330.0, 17830.0}) {
    diagnosis::ShearCurve c;
    c.test = std::to_string(static_cast<int>(sigma)) + " Pa";
    c.normal_stress = sigma;
    for (int i = 1; i <= points; ++i) {
      const double j = 6.5e-3 * i / points;
      c.displacement.push_back(j);
      c.stress.push_back((mms_c + sigma * std::tan(mms_phi)) * (1 - std::exp(-j / K)) + noise(sd));
    }
    out.push_back(c);
  }
  return out;
}

/// Plate tests p = k_i (z/b)^n to 20 mm, k_i = k (1 + scatter N(0,1)): the soil differs from test to test.
inline std::vector<diagnosis::SinkageCurve> plate_tests(int tests, double scatter, double noise_share, unsigned seed,
                                                        double b = 0.05) {
  Noise noise(seed);
  std::vector<diagnosis::SinkageCurve> out;
  for (int t = 0; t < tests; ++t) {
    diagnosis::SinkageCurve c;
    c.test = std::to_string(t + 1);
    c.width = b;
    const double k = mms_k * (1 + noise(scatter)), top = mms_k * std::pow(0.02 / b, mms_n);
    for (int i = 1; i <= 40; ++i) {
      const double z = 0.02 * i / 40;
      c.sinkage.push_back(z);
      c.pressure.push_back(k * std::pow(z / b, mms_n) + noise(noise_share * top));
    }
    out.push_back(c);
  }
  return out;
}

}  // namespace grouser::test
