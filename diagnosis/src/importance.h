#pragma once
#include <Eigen/Core>
#include <functional>

namespace grouser::diagnosis {

/// ln of the integral of exp(ln_density) over all x by importance sampling: x = mode + L t, covariance = L L', t multivariate Student with
/// five degrees of freedom (heavier tails than the integrand's), antithetic in pairs, fixed seed.
struct Integral {
  double ln = 0;         ///< importance sampling
  double ln_normal = 0;  ///< Laplace: a normal of this covariance with the integrand's height at the mode
  double effective = 0;  ///< (sum w)^2/sum w^2: draws that count
};
/// ln_density may be -inf. Cost: `draws` calls. Source: Geweke (1989), Econometrica 57, 1317.
Integral importance_integral(const Eigen::VectorXd& mode, const Eigen::MatrixXd& covariance,
                             const std::function<double(const Eigen::VectorXd&)>& ln_density, int draws);

}  // namespace grouser::diagnosis
