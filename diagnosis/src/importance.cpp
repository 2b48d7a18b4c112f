#include "importance.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <vector>

namespace grouser::diagnosis {
namespace {

constexpr double tail = 5, ln_two_pi = 1.8378770664093453;

}  // namespace

Integral importance_integral(const Eigen::VectorXd& mode, const Eigen::MatrixXd& covariance,
                             const std::function<double(const Eigen::VectorXd&)>& ln_density, int draws) {
  Integral out;
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  const double p = static_cast<double>(mode.size());
  out.ln = out.ln_normal = -INFINITY;
  if (root.info() != Eigen::Success) return out;
  const Eigen::MatrixXd L = root.matrixL();
  const double ln_det = L.diagonal().array().log().sum();
  out.ln_normal = ln_density(mode) + 0.5 * p * ln_two_pi + ln_det;
  const double ln_q0 =
      std::lgamma(0.5 * (tail + p)) - std::lgamma(0.5 * tail) - 0.5 * p * std::log(tail * 3.141592653589793) - ln_det;
  std::mt19937_64 random(19890613);
  std::normal_distribution<double> normal;
  std::chi_squared_distribution<double> squares(tail);
  std::vector<double> ln_w;
  for (int k = 0; k < draws / 2; ++k) {
    Eigen::VectorXd z(mode.size());
    for (double& v : z) v = normal(random);
    z *= std::sqrt(tail / squares(random));
    const double ln_q = ln_q0 - 0.5 * (tail + p) * std::log1p(z.squaredNorm() / tail);
    const Eigen::VectorXd step = L * z;
    for (const double side : {1.0, -1.0}) ln_w.push_back(ln_density(mode + side * step) - ln_q);
  }
  double top = -INFINITY, sum = 0, square = 0;
  for (const double w : ln_w) top = std::max(top, w);
  if (!std::isfinite(top)) return out;
  for (const double w : ln_w) sum += std::exp(w - top), square += std::exp(2 * (w - top));
  out.ln = top + std::log(sum / static_cast<double>(ln_w.size()));
  out.effective = sum * sum / square;
  return out;
}

}  // namespace grouser::diagnosis
