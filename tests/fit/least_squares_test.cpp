// The engine against certified and closed-form results.
#include "grouser/diagnosis/least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace grouser::diagnosis {
namespace {

// NIST StRD nonlinear regression, Misra1a: y = b1 (1 - exp(-b2 x)), certified values and standard deviations.
TEST(LeastSquares, ReproducesTheCertifiedValuesAndErrorsOfNistMisra1a) {
  const std::vector<double> y{10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                              44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78};
  const std::vector<double> x{77.6,  114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                              378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0};
  LeastSquaresProblem p;
  p.variables = {{"b1", 500, -INFINITY, INFINITY, 100, false, {}, -1}, {"b2", 1e-4, 0, INFINITY, 1e-4, false, {}, -1}};
  p.residuals = x.size();
  p.model = [&](std::span<const double> b, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = b[0] * (1 - std::exp(-b[1] * x[i])) - y[i];
    return true;
  };
  const LeastSquaresResult f = solve_least_squares(p);
  ASSERT_TRUE(f.converged) << f.message;
  // Certified to 11 digits; the minimiser stops where the sum of squares no longer changes, errors come from differences.
  EXPECT_NEAR(f.at("b1").value, 2.3894212918e2, 1e-4);
  EXPECT_NEAR(f.at("b2").value, 5.5015643181e-4, 1e-9);
  EXPECT_NEAR(f.at("b1").standard_error, 2.7070075241, 1e-3);
  EXPECT_NEAR(f.at("b2").standard_error, 7.2668688436e-6, 3e-9);
  EXPECT_NEAR(f.scale, 1.0187876330e-1, 1e-8);
  EXPECT_EQ(f.dof, 12);
}

struct Clustered {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
  std::vector<int> group;
};

Clustered grouped_line(int groups, int rows) {
  std::mt19937_64 e(5);
  std::normal_distribution<double> normal;
  Clustered d{Eigen::MatrixXd(groups * rows, 2), Eigen::VectorXd(groups * rows), {}};
  for (int g = 0; g < groups; ++g) {
    const double shift = normal(e);
    for (int i = 0; i < rows; ++i) {
      const int k = g * rows + i;
      const double x = i + 0.3 * g;
      d.X.row(k) << 1, x;
      d.y[k] = 2 + 0.5 * x + shift + 0.2 * normal(e);
      d.group.push_back(g);
    }
  }
  return d;
}

// On a straight line the linearised jackknife is the jackknife itself: leave each group out and solve the normal equations.
TEST(LeastSquares, ClusteredErrorsEqualTheJackknifeOfRefits) {
  const int G = 7;
  const Clustered d = grouped_line(G, 9);
  LeastSquaresProblem p;
  p.variables = {{"a", 0, -INFINITY, INFINITY, 1, false, {}, -1}, {"b", 0, -INFINITY, INFINITY, 1, false, {}, -1}};
  p.residuals = static_cast<std::size_t>(d.y.size());
  p.cluster = d.group;
  p.errors = ErrorModel::clustered;
  p.model = [&](std::span<const double> v, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = v[0] * d.X(static_cast<int>(i), 0) + v[1] * d.X(static_cast<int>(i), 1) - d.y[static_cast<int>(i)];
    return true;
  };
  const LeastSquaresResult f = solve_least_squares(p);
  const Eigen::VectorXd all = d.X.colPivHouseholderQr().solve(d.y);
  Eigen::Matrix2d V = Eigen::Matrix2d::Zero();
  for (int g = 0; g < G; ++g) {
    std::vector<int> keep;
    for (int i = 0; i < d.y.size(); ++i)
      if (d.group[static_cast<std::size_t>(i)] != g) keep.push_back(i);
    const Eigen::MatrixXd X = d.X(keep, Eigen::all);
    const Eigen::VectorXd y = d.y(keep);
    const Eigen::VectorXd delta = X.colPivHouseholderQr().solve(y) - all;
    V += delta * delta.transpose() * (G - 1.0) / G;
  }
  EXPECT_NEAR(f.at("a").value, all[0], 1e-6);  // the minimiser stops at a relative change of 1e-10 of r'r
  EXPECT_NEAR(f.at("a").standard_error, std::sqrt(V(0, 0)), 1e-6 * std::sqrt(V(0, 0)));
  EXPECT_NEAR(f.at("b").standard_error, std::sqrt(V(1, 1)), 1e-6 * std::sqrt(V(1, 1)));
  EXPECT_NEAR(f.correlation(0, 1), V(0, 1) / std::sqrt(V(0, 0) * V(1, 1)), 1e-6);
}

TEST(LeastSquares, NamesTheDirectionThatTheDataCannotSee) {
  // y = (a + b) x: only the sum is known.
  LeastSquaresProblem p;
  p.variables = {{"a", 1, -INFINITY, INFINITY, 1, false, {}, -1},
                 {"b", 0, -INFINITY, INFINITY, 1, false, {}, -1},
                 {"c", 0, -INFINITY, INFINITY, 1, false, {}, -1}};
  p.residuals = 6;
  p.model = [](std::span<const double> v, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i) {
      const auto x = static_cast<double>(i);
      r[i] = (v[0] + v[1]) * x + v[2] * x * x - 3 * x - 0.5 * x * x + (i % 2 ? 0.01 : -0.01);
    }
    return true;
  };
  const LeastSquaresResult f = solve_least_squares(p);
  EXPECT_TRUE(f.singular);
  ASSERT_FALSE(f.weak.empty());
  EXPECT_EQ(f.weak.back().text, "0.71 a - 0.71 b");
  EXPECT_TRUE(std::isnan(f.at("a").standard_error));
}

TEST(LeastSquares, HoldsAVariableAtItsBoundAndSaysSo) {
  LeastSquaresProblem p;
  p.variables = {{"a", 1, 0, INFINITY, 1, false, {}, -1}, {"b", 0, -INFINITY, INFINITY, 1, false, {}, -1}};
  p.residuals = 5;
  p.model = [](std::span<const double> v, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = v[0] + v[1] * static_cast<double>(i) - (-1 + 2.0 * static_cast<double>(i));
    return true;
  };
  const LeastSquaresResult f = solve_least_squares(p);
  EXPECT_TRUE(f.at("a").at_bound);
  EXPECT_EQ(f.at("a").value, 0);
  // Through the origin: b = sum x y / sum x^2 = (1 + 6 + 15 + 28)/30.
  EXPECT_NEAR(f.at("b").value, 50.0 / 30, 1e-6);
}

TEST(LeastSquares, APriorActsAsOneMoreMeasurement) {
  LeastSquaresProblem p;
  p.variables = {{"a", 0, -INFINITY, INFINITY, 1, false, Prior{10, 0.5}, -1}};
  p.residuals = 1;
  p.errors = ErrorModel::stated;
  p.model = [](std::span<const double> v, std::span<double> r) { return r[0] = (v[0] - 4) / 0.5, true; };
  const LeastSquaresResult f = solve_least_squares(p);
  EXPECT_NEAR(f.at("a").value, 7, 1e-6);
  EXPECT_NEAR(f.at("a").standard_error, 0.5 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(f.at("a").prior_z, -6, 1e-6);
}

TEST(LeastSquares, RefusesMoreUnknownsThanResiduals) {
  LeastSquaresProblem p;
  p.variables = {{"a", 0, -1, 1, 1, false, {}, -1}, {"b", 0, -1, 1, 1, false, {}, -1}};
  p.residuals = 1;
  p.model = [](auto, auto) { return true; };
  EXPECT_THROW(solve_least_squares(p), std::invalid_argument);
}

}  // namespace
}  // namespace grouser::diagnosis
