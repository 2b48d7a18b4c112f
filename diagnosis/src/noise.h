#pragma once
// Noise of a series of runs: sensors, and soil that scatters from one preparation to the next.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "run_model.h"

namespace grouser::diagnosis {

/// What scatters between preparations: ln k and phi (soil_coordinates 0 and 3).
constexpr std::array<int, 2> scattered{0, 3};

/// Covariance of one preparation: diag(scale_c^2 sd^2 / w_run) + J Omega J', Omega = diag(omega^2), J d(outputs)/d(scattered).
/// Along the order of the runs whitened errors are AR(1) with rho: exact where omega is 0.
struct Noise {
  std::array<double, channel_count> scale{1, 1, 1};  ///< of the sensors' stated sd
  std::array<double, 2> omega{0, 0};                 ///< sd of ln k and of phi [rad]
  double rho = 0;                                    ///< of the last run's error that is left in the next one's
  std::vector<double> weight;  ///< of each run: 1 good, towards 0.01 when it looks like an outlier
};

/// Measured values in the order in which they are whitened: preparation by preparation.
class DataLayout {
 public:
  DataLayout(const std::vector<Run>& runs, const std::vector<std::array<double, channel_count>>& sd);
  struct Item {
    int run, channel;
    double sd;
  };
  int size() const { return static_cast<int>(items_.size()); }
  const Item& operator[](int i) const { return items_[static_cast<std::size_t>(i)]; }
  struct Group {
    int first, count;
  };
  const std::vector<Group>& groups() const { return groups_; }
  int runs() const { return runs_; }
  /// Items along the order of the runs, each channel after the other: {item, the one before it or -1}. Runs that are in no file (line 0)
  /// are in no order.
  const std::vector<std::array<int, 2>>& chain() const { return chain_; }

 private:
  std::vector<std::array<int, 2>> chain_;
  std::vector<Item> items_;
  std::vector<Group> groups_;
  int runs_;
};

/// Cholesky factors of every preparation's covariance, then (u_t - rho u_(t-1))/sqrt(1 - rho^2) along the order.
class Whitener {
 public:
  /// soil_slopes: rows by items, a column for each of `scattered`.
  Whitener(const DataLayout& layout, const Noise& noise, const Eigen::MatrixXd& soil_slopes);
  void apply(Eigen::Ref<Eigen::MatrixXd> columns) const;  ///< in place, L^-1 x
  double log_determinant() const { return log_determinant_; }

 private:
  const DataLayout& layout_;
  std::vector<double> factor_;  ///< of one preparation after the other, by rows, diagonal inverted
  double log_determinant_ = 0, rho_ = 0;
};

/// Correlation of each run's error with the last run's, from first differences d of residuals whitened without it: r_d(1) = -(1 - rho)/2,
/// which slow changes hardly touch; all channels together. 0 where it is within two standard errors or below 0.1; 0.7 at most.
double run_to_run(const DataLayout& layout, const Eigen::VectorXd& whitened);

/// Least -2 ln likelihood of residuals over scales and omega, with priors ln scale ~ N(0, 0.3) where the sd was stated (flat from
/// 0.2 to 33 times 3 % of the range where not) and omega ~ half-normal (0.1, 0.03 rad). NLopt BOBYQA; deterministic.
/// `free_parameters` of the fit that left these residuals widens the scales by N/(N - p).
Noise fit_noise(const DataLayout& layout, const Eigen::VectorXd& residual, const Eigen::MatrixXd& soil_slopes,
                const Noise& start, const std::array<bool, channel_count>& stated, bool scatter, int free_parameters);

/// Prior part of the above, -2 ln.
double noise_penalty(const Noise& noise, const std::array<bool, channel_count>& stated);

/// Weights of runs by a mixture: a share of 1 % has ten times the noise. Returns the added -2 ln likelihood.
double update_weights(const DataLayout& layout, const Eigen::VectorXd& residual, const Eigen::MatrixXd& soil_slopes,
                      Noise& noise);

}  // namespace grouser::diagnosis
