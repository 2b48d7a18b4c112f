#pragma once
// Accounts of soil tests and what the data leave of each: best fit, evidence, posterior draws.
#include <memory>

#include "soil_test_model.h"

namespace grouser::diagnosis {

/// One way to explain the curves.
struct SoilTestAccount {
  std::string id;
  bool named = false;
  RollingLaw law = RollingLaw::constant;
  int effect = -1;                              ///< index into soil_test_effects()
  std::vector<SoilTestCoordinate> coordinates;  ///< ln Y, ln friction, ln rolling, then the amount of a nested effect
  std::string variable, through;                ///< of a drift outside the list
  std::vector<Eigen::MatrixXd> drift;  ///< of each condition, outputs by terms; each term N(0, drift_sd^2) in ln stress
};
constexpr double drift_sd = 0.5;

struct SoilTestPosterior {
  bool ok = false;
  Eigen::VectorXd best;  ///< of most posterior density
  double ln_likelihood = 0, chi2 = 0, p = 1, ln_evidence = -INFINITY;
  Eigen::MatrixXd draws;  ///< one a column, equally likely
  double effective = 0;   ///< draws that the evidence rests on
};

/// Conditions as they enter the likelihood.
struct SoilTestValues {
  SoilTestCondition condition;
  std::vector<Eigen::VectorXd> repeats;
  Eigen::VectorXd mean;
};

/// Likelihood of the means y of all conditions, one normal (G2):
///   y ~ N(f(x), C),  C_ij = s(i, j) S_law + [i = j] (lambda S/n_i + max(0, 1 - lambda) S) + drift_sd^2 D_i D_j'
/// s: error of the emulator (G1), between conditions of one kind; S: scatter of single tests, pooled; n_i repeats.
/// What the repeats scatter less than the stored runs do about their polynomial (lambda < 1) is taken for error of the
/// polynomial, which repeats do not average out.
///   lambda = (sum of squares of the repeats about their means in units of S + 10)/(their degrees of freedom + 10)
class SoilTestFits {
 public:
  SoilTestFits(const SoilTestModel& model, const SoilTestCase& c, const std::vector<SoilTestCondition>& conditions,
               bool rise);

  const std::vector<SoilTestValues>& values() const { return values_; }
  int size() const { return size_; }
  double scale(SoilTestKind k) const { return lambda_[static_cast<std::size_t>(k)]; }
  double noise_dof() const { return dof_[0] + dof_[1]; }
  /// Scatter of one test, and what repeats do not average out.
  Eigen::MatrixXd repeat_scatter(SoilTestKind k) const { return scale(k) * model_.scatter(k); }
  Eigen::MatrixXd fixed_scatter(SoilTestKind k) const { return std::max(0.0, 1 - scale(k)) * model_.scatter(k); }

  /// nominal, every effect of the case, drifts of shear stress and plate pressure with what varies.
  std::vector<SoilTestAccount> accounts() const;
  /// Mean outputs of a condition. Empty: outside the stored runs.
  Eigen::VectorXd predict(const SoilTestAccount& a, const Eigen::VectorXd& x, const SoilTestCondition& c,
                          Eigen::MatrixXd* error = nullptr) const;
  /// Best fit by NLopt (Sbplx, six starts); evidence by importance sampling: Student-t (5) proposals about it, adapted
  /// three times.
  SoilTestPosterior posterior(const SoilTestAccount& a) const;
  /// Least of chi2 and priors that a refit of `a` leaves of data without noise.
  double best_objective(const SoilTestAccount& a, const Eigen::VectorXd& y) const;
  Eigen::VectorXd stacked_means() const { return y_; }
  /// All conditions at once. Empty: outside the stored runs.
  Eigen::VectorXd stacked(const SoilTestAccount& a, const Eigen::VectorXd& x) const;

 private:
  struct Said {
    bool ok = false;
    double ln_likelihood = -INFINITY, chi2 = 0;
  };
  Said likelihood(const SoilTestAccount& a, const Eigen::VectorXd& x, const Eigen::VectorXd& y) const;
  double ln_prior(const SoilTestAccount& a, const Eigen::VectorXd& x) const;
  Eigen::VectorXd maximum(const SoilTestAccount& a, const Eigen::VectorXd& y, bool with_determinant) const;
  Eigen::VectorXd full(const SoilTestAccount& a, const Eigen::VectorXd& x) const;

  const SoilTestModel& model_;
  SoilTestCase case_;
  std::vector<SoilTestValues> values_;
  Eigen::VectorXd y_;
  int size_ = 0;
  std::array<double, 2> lambda_{1, 1}, dof_{10, 10};
};

}  // namespace grouser::diagnosis
