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
  double sd = 0;                           ///< of a normal prior about 0; 0 = none
  double at(std::size_t run) const { return shape.size() ? shape[static_cast<Eigen::Index>(run)] : 1; }
};

/// What is refitted with every candidate: soil coordinates, then known effects, each under its prior.
struct Parameter {
  std::string name, unit;
  bool logarithmic;
  double lower, upper, mean, sd;
  int input;  ///< index into Inputs
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

/// Parameters: soil coordinates and known effects that have a prior, then amplitudes.
struct Fit {
  bool ok = false;
  Eigen::VectorXd x;
  double chi2 = 0;     ///< whitened residuals
  double penalty = 0;  ///< of the priors
  double objective() const { return chi2 + penalty; }
  Eigen::VectorXd residual;   ///< measured - model, unwhitened, in the layout's order
  Eigen::MatrixXd jacobian;   ///< d model/d x, unwhitened
  std::vector<double> theta;  ///< entry angle of each run
  Eigen::VectorXd precision;  ///< 1/sd^2 of each parameter's prior; 0 = none
};

class Series {
 public:
  Series(const DiagnosisCase& c, std::vector<Run> runs, const std::vector<std::array<double, channel_count>>& sd);

  const DataLayout& layout() const { return layout_; }
  const std::vector<Run>& runs() const { return runs_; }
  const DiagnosisCase& given() const { return case_; }
  const std::vector<Parameter>& parameters() const { return free_; }
  const Parameter& parameter(Eigen::Index i) const { return free_[static_cast<std::size_t>(i)]; }
  int soil_parameters() const { return static_cast<int>(free_.size()); }  ///< with the known effects that are refitted

  Eigen::VectorXd prior_mean() const;
  Inputs inputs_of(const Candidate& c, const Eigen::VectorXd& x, std::size_t run) const;
  std::vector<Inputs> inputs(const Candidate& c, const Eigen::VectorXd& x) const;  ///< of every run

  /// Entries of effect_entries() that its terms and the known effects move.
  std::vector<int> touched(const Candidate& c) const;

  /// Outputs of every run in the layout's order. False: no answer for some run.
  bool predict(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta, Eigen::VectorXd& y) const;
  /// A model in the rig is rolled at x, and answers from there on (settle_runs). False: no wheel there.
  bool settle(const Candidate& c, const Eigen::VectorXd& x) const;
  /// Slopes of the layout's values by all inputs at x.
  bool all_slopes(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta,
                  Eigen::MatrixXd& slopes) const;
  /// Ceres, Levenberg-Marquardt with exact derivatives, under bounds and priors, from `start` moved inside the bounds.
  Fit fit(const Candidate& c, const Whitener& whitener, const Eigen::VectorXd& start, const std::vector<double>& theta,
          int iterations) const;
  /// Sum of ((x - mean)/sd)^2 over all priors.
  double prior_penalty(const Candidate& c, const Eigen::VectorXd& x) const;
  /// Recomputes chi2 for other noise.
  void reweigh(Fit& f, const Whitener& w) const;
  Eigen::VectorXd measured() const { return y_; }
  /// Soil columns of `scattered` at a fit without terms or with.
  Eigen::MatrixXd scatter_slopes(const Candidate& c, const Fit& f) const;

 private:
  friend class SeriesCost;
  Inputs inputs_of_all(const Candidate& c, const Eigen::VectorXd& x) const;  ///< without the terms
  void add_terms(const Candidate& c, const Eigen::VectorXd& x, std::size_t run, Inputs& in) const;
  bool evaluate(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta, Eigen::VectorXd& y,
                Eigen::MatrixXd* J) const;
  const DiagnosisCase& case_;
  std::vector<Run> runs_;
  DataLayout layout_;
  std::vector<Parameter> free_;
  Eigen::VectorXd y_;
};

}  // namespace grouser::diagnosis
