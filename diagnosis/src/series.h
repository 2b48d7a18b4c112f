#pragma once
// Fits of the nominal model and of candidate causes to one series of runs under the soil's priors.
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "noise.h"

namespace grouser::diagnosis {

/// One amplitude of a candidate: input `entry` of each run changes by amplitude * shape(run).
struct Term {
  int input = 0;                           ///< index into Inputs
  Eigen::VectorXd shape;                   ///< one per run; empty = 1
  double lower = 0, upper = 0, start = 0;  ///< of the amplitude; start: a size that shows
  double at(std::size_t run) const { return shape.size() ? shape[static_cast<Eigen::Index>(run)] : 1; }
};

/// An amplitude that is not fitted.
struct Held {
  int input = 0;
  double value = 0;
};

/// A cause that could explain the misfit: one named effect, two of them, or a soil parameter or channel that drifts with a variable.
struct Candidate {
  std::string id;
  std::vector<Term> terms;
  std::vector<int> effects;            ///< entries of effect_entries() for named ones
  std::string variable, acts_through;  ///< of a drift
  std::vector<Held> held = {};
  bool named() const { return !effects.empty(); }
};

/// Entries of effect_entries() that its terms move.
std::vector<int> touched(const Candidate& c);

/// Parameters: soil coordinates that have a prior, then amplitudes.
struct Fit {
  bool ok = false;
  Eigen::VectorXd x;
  double chi2 = 0;     ///< whitened residuals
  double penalty = 0;  ///< of the soil's priors
  double objective() const { return chi2 + penalty; }
  Eigen::VectorXd residual;   ///< measured - model, unwhitened, in the layout's order
  Eigen::MatrixXd jacobian;   ///< d model/d x, unwhitened
  std::vector<double> theta;  ///< entry angle of each run
};

class Series {
 public:
  Series(const DiagnosisCase& c, std::vector<Run> runs, const std::vector<std::array<double, channel_count>>& sd);

  const DataLayout& layout() const { return layout_; }
  const std::vector<Run>& runs() const { return runs_; }
  const DiagnosisCase& given() const { return case_; }
  const std::vector<int>& free_soil() const { return free_; }
  int soil_parameters() const { return static_cast<int>(free_.size()); }

  Eigen::VectorXd prior_mean() const;
  std::array<double, soil_count> soil_of(const Eigen::VectorXd& x) const;
  Inputs inputs_of(const Candidate& c, const Eigen::VectorXd& x, std::size_t run) const;
  std::vector<Inputs> inputs(const Candidate& c, const Eigen::VectorXd& x) const;  ///< of every run

  /// Outputs of every run in the layout's order. False: no answer for some run.
  bool predict(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta, Eigen::VectorXd& y) const;
  /// Slopes of the layout's values by all inputs at x.
  bool all_slopes(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta,
                  Eigen::MatrixXd& slopes) const;
  /// Ceres, Levenberg-Marquardt with exact derivatives, from `start`, under bounds and priors.
  Fit fit(const Candidate& c, const Whitener& whitener, const Eigen::VectorXd& start, const std::vector<double>& theta,
          int iterations) const;
  /// Recomputes chi2 for other noise.
  void reweigh(Fit& f, const Whitener& w) const;
  Eigen::VectorXd measured() const { return y_; }
  /// Soil columns of `scattered` at a fit without terms or with.
  Eigen::MatrixXd scatter_slopes(const Candidate& c, const Fit& f) const;

 private:
  friend class SeriesCost;
  bool evaluate(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta, Eigen::VectorXd& y,
                Eigen::MatrixXd* J) const;
  double prior_penalty(const Eigen::VectorXd& x) const;
  const DiagnosisCase& case_;
  std::vector<Run> runs_;
  DataLayout layout_;
  std::vector<int> free_;
  Eigen::VectorXd y_;
};

}  // namespace grouser::diagnosis
