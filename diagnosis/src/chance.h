#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

namespace grouser::diagnosis {

/// Least share, over the members taken as true in turn, of 400 draws of new data y ~ N(mean, covariance) in which the true member gets
/// `odds` times the probability of every other one (D15). `excused(m, truth)`: m needs not to be beaten, as it is in the true one.
/// N: values in y, fixed or dynamic. The draws are the same for the same input. Cost: draws x members^2 solves of N.
template <int N, class Excused>
double chance_to_decide(const std::vector<Eigen::Matrix<double, N, 1>>& mean,
                        const std::vector<Eigen::Matrix<double, N, N>>& covariance, const std::vector<double>& ln_prior,
                        double odds, Excused&& excused) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  constexpr int draws = 400;
  const std::size_t count = mean.size();
  std::vector<Matrix> L(count);
  std::vector<double> ln_det(count);
  for (std::size_t m = 0; m < count; ++m) {
    L[m] = Eigen::LLT<Matrix>(covariance[m]).matrixL();
    ln_det[m] = 2 * L[m].diagonal().array().log().sum();
  }
  double least = 1;
  for (std::size_t truth = 0; truth < count; ++truth) {
    std::mt19937_64 random(92210 + truth);
    std::normal_distribution<double> normal;
    int decided = 0;
    for (int k = 0; k < draws; ++k) {
      Vector e(mean[truth].size());
      for (Eigen::Index i = 0; i < e.size(); ++i) e[i] = normal(random);
      const Vector y = mean[truth] + L[truth] * e;
      const auto score = [&](std::size_t m) {
        return ln_prior[m] -
               0.5 * (ln_det[m] + L[m].template triangularView<Eigen::Lower>().solve(y - mean[m]).squaredNorm());
      };
      const double own = score(truth);
      bool best = true;
      for (std::size_t m = 0; m < count && best; ++m) best = excused(m, truth) || own - score(m) > std::log(odds);
      decided += best ? 1 : 0;
    }
    least = std::min(least, static_cast<double>(decided) / draws);
  }
  return least;
}

}  // namespace grouser::diagnosis
