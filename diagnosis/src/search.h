#pragma once
// The search for the cause: refit, noise, ranking. What is done with the ranking is in verdict.cpp.
#include <memory>

#include "candidates.h"
#include "grouser/diagnosis/diagnose.h"
#include "shares.h"

namespace grouser::diagnosis {

inline constexpr int few = 150;  ///< values: more starts cost little, and many accounts follow them

/// A candidate with what is known of it.
struct Rival {
  Candidate candidate;
  double gain = 0;        ///< ln likelihood over the nominal model, both at their best under the same noise
  double evidence = 0;    ///< gain less the price of the amplitudes, corrected by importance sampling for finalists
  double correction = 0;  ///< that correction
  double weight = 0;      ///< ln prior share
  double posterior = 0;
  bool refitted = false;
  bool base = false;  ///< a pair estimated beside one of its effects
  Fit fit;
  Eigen::VectorXd guess;  ///< start of the refit
};

class Search {
 public:
  Search(const DiagnosisCase& c, const RunTable& t, std::vector<Run> runs);
  /// Steps (i) to (iv). @throws ConfigError: the model has no answer for a run at the prior means.
  void run();

  const Series& series() const { return *series_; }
  const Noise& noise() const { return noise_; }
  const Fit& nominal() const { return none_; }
  const std::vector<Rival>& rivals() const { return rivals_; }  ///< best posterior first
  double posterior_none() const { return posterior_none_; }
  double posterior_unknown() const { return posterior_unknown_; }
  double mixture_bayes_factor() const { return mixture_; }
  double refit_seconds() const { return seconds_; }
  bool disowned() const {
    return disowned_;
  }  ///< more rows looked like outliers than outliers are: none was taken for one
  bool noise_in_repeats() const {
    return repeats_show_;
  }  ///< there are repeats, and they scatter as much as the scales say
  const Whitener& whitener() const { return *whitener_; }
  const Eigen::MatrixXd& scatter() const { return scatter_; }
  const ScoreTable& scores() const { return *scores_; }
  const std::vector<Candidate>& candidates() const { return all_; }
  std::size_t named_count() const { return named_; }

  /// Refits a candidate from a guess, with a second start where the first does not beat the nominal model (nesting).
  Fit refit(const Candidate& c, const Eigen::VectorXd& guess, const Fit& base) const;
  /// Largest structured remainder after `f`: p value of the best score among all named effects and drifts, times their number.
  struct Remainder {
    double p = 1;
    std::string id;
    double gain = 0;
  };
  Remainder remainder(const Candidate& c, const Fit& f) const;
  /// Soil value whose change does to these runs what this term of the candidate does, were all soil values free and unknown: what sets them apart
  /// is then what the case says of the soil alone. Empty: none (more than 1 % of the fingerprint, or more than one noise sd, is its own).
  std::string soil_in_disguise(const Candidate& c, const Fit& f, std::size_t term) const;
  /// Laplace standard deviations of the parameters of a fit.
  Eigen::MatrixXd covariance(const Fit& f) const;
  std::vector<std::array<double, channel_count>> stated_sd() const { return sd_; }
  std::array<double, channel_count> usual_sd() const;  ///< median over the rows that were measured
  /// What the rows' own errors are multiplied by where no model is asked: 1 for a stated sd, unless repeats alone say more; else the
  /// scale found. A scale that grew because no model follows the rows is no error of a row.
  std::array<double, channel_count> statics_scale() const;
  /// Other effects that do exactly the same to these runs.
  const std::vector<std::string>& aliases(int entry) const;
  /// Degrees of freedom behind the sensors' scales.
  double noise_dof(double parameters) const;

 private:
  void fit_nominal();
  /// A fit that stands on wheels rolled where it ends (Series::settle); the steady law is exact everywhere.
  Fit settled(const Candidate& c, Fit f) const;
  void settle_leading();
  /// first: account that the noise is settled on at first; where it is the nominal model, the best by score.
  void settle_noise(std::pair<Candidate, Fit> first);
  double cost_of_noise(const Candidate& c, Fit f) const;
  void weigh_runs(const Fit& f);
  void add_second(Candidate& best, Fit& f) const;
  Noise noise_of(const Fit& f, bool& from_repeats, bool& repeats_show) const;
  double memory_of(const Fit& f, Noise noise) const;
  void set_whitener();
  /// False: a better nominal model was found, and the rest is left undone unless this is the last try.
  bool rank(bool last);
  void weigh();
  void correct_finalists();
  void rank_pairs();
  bool singles_from_pairs();
  bool singles_from_afar();
  bool take_if_better(std::size_t single, Fit f);
  const Rival* leader() const;
  bool other_noise_wins() const;
  void take(Rival& r, Fit f) const;
  void join_aliases();
  Candidate pair_of(const Candidate& a, const Candidate& b) const;
  double price(const Candidate& c, double gain, const Eigen::VectorXd& x) const;
  /// In ln likelihood: by the noise that suits this fit best, over the noise that all accounts share.
  double own_noise_gain(const Fit& fit) const;

  DiagnosisCase case_;
  std::array<bool, channel_count> stated_{};
  bool ordered_ = false;  ///< the order of the runs is known
  std::vector<std::array<double, channel_count>> sd_;
  std::unique_ptr<Series> series_;
  std::vector<Candidate> all_;  ///< named effects, then drifts
  std::size_t named_ = 0;
  std::vector<Eigen::VectorXd> elsewhere_;  ///< of each named candidate: where it ended lower than from its score
  bool looked_afar_ = false;
  bool disowned_ = false;
  bool from_repeats_ = false;  ///< the scales are those of the repeats alone
  bool repeats_show_ = false;
  std::vector<std::vector<std::string>> aliases_;  ///< of each named candidate
  Noise noise_;
  Eigen::MatrixXd scatter_;
  std::unique_ptr<Whitener> whitener_;
  std::unique_ptr<ScoreTable> scores_;
  Fit none_;
  double none_own_ = 0;
  std::vector<Rival> rivals_;
  double posterior_none_ = 1, posterior_unknown_ = 0, mixture_ = 0, seconds_ = 0, none_correction_ = 0;
};

}  // namespace grouser::diagnosis
