#pragma once
#include <optional>

#include "noise.h"

namespace grouser::diagnosis {

/// What repeats of one condition say of the noise, whatever model is right: Helmert contrasts
///   e_k = (r_1 + ... + r_k - k r_{k+1})/sqrt(k (k + 1))   of residuals: what a model does wrong it does to all repeats alike,
/// each with the covariance of a run. Only repeats with preparations of their own: those that share one say nothing of the soil's scatter.
struct Replicates {
  DataLayout layout;
  Eigen::VectorXd contrast;
  Eigen::MatrixXd slopes;  ///< of `scattered`
};

/// slopes: of each value of `layout` by `scattered`. Nothing with fewer than `least` values.
std::optional<Replicates> replicates(const std::vector<Run>& runs, const DataLayout& layout,
                                     const Eigen::MatrixXd& slopes, const Eigen::VectorXd& residual, int least);

}  // namespace grouser::diagnosis
