#pragma once
// Every cause that one Jacobian can score, and its fingerprint beside the refitted soil.
#include "series.h"

namespace grouser::diagnosis {

Candidate nominal_candidate();
Candidate effect_candidate(int entry);
Candidate pair_candidate(int a, int b);
/// The same with what the case says of ordinary sizes.
Candidate with_priors(Candidate c, const DiagnosisCase& given);
/// Rivals outside the list: one of k, n, c, phi, K, theta_m, theta_r, drawbar, torque, sinkage drifts with slip, load, omega, pass,
/// order, slope or time as a polynomial of up to four terms. Those that are a named effect exactly are left out.
std::vector<Candidate> drift_candidates(const std::vector<Run>& runs, bool order_known);
/// Named effects of the case that these runs can show at all (a second pass, an order, more than one load ...).
std::vector<int> visible_effects(const DiagnosisCase& c, const RunTable& t, const std::vector<Run>& runs);

/// Scores of many columns at once: with S the columns' Gram matrix after the base parameters were refitted under their priors and t
/// their gradient, the least chi2 falls by t' S^-1 t (Rao's score test).
class ScoreTable {
 public:
  /// base: whose parameters are refitted. others: their terms become columns.
  ScoreTable(const Series& s, const Candidate& base, const Fit& fit, const Whitener& w,
             const std::vector<Candidate>& others);
  bool ok() const { return ok_; }
  struct Score {
    double gain = 0;  ///< in ln likelihood, 0 where the best amplitude has the wrong sign
    Eigen::VectorXd amplitude;
  };
  Score of(std::size_t candidate) const;
  Score of_pair(std::size_t a, std::size_t b) const;
  /// Length of the candidate's first column at its `start`, in noise sd after the refit: d.
  double visible(std::size_t candidate) const;
  /// |cosine| of two candidates' first columns after the refit.
  double likeness(std::size_t a, std::size_t b) const;
  /// Base parameters for these amplitudes.
  Eigen::VectorXd base_step(const std::vector<std::size_t>& candidates, const Eigen::VectorXd& amplitude) const;

 private:
  Score solve(Eigen::MatrixXd S, const Eigen::VectorXd& t, const std::vector<const Term*>& terms) const;
  bool ok_ = false;
  std::vector<Candidate> others_;
  std::vector<std::vector<Eigen::Index>> columns_;
  Eigen::Index singles_ = 0;          ///< columns of named effects, which stand first
  Eigen::MatrixXd S_, turn_;          ///< S between named effects; turn: d base/d amplitude
  std::vector<Eigen::MatrixXd> own_;  ///< S of each candidate's own columns
  Eigen::VectorXd t_;
};

}  // namespace grouser::diagnosis
