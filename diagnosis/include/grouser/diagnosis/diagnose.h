#pragma once
// From measured runs to the cause of the misfit: what `grouser diagnose` does.
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "grouser/diagnosis/runs.h"

namespace grouser::diagnosis {

struct Interval {
  double value = 0, sd = 0, low = 0, high = 0;  ///< 90 %, in `unit`
  std::string unit;
  bool at_bound = false;
  double times_typical = 0;  ///< size of the amplitude over its ordinary size
};

/// A candidate as the ranking shows it.
struct Ranked {
  std::string id;             ///< effect, "a+b" or "n drifts with slip"
  double log_likelihood = 0;  ///< gain over the refitted nominal model, natural logarithm
  double log_evidence = 0;    ///< the same after the price of its freedom
  double posterior = 0;
  double cross_validation = 0;  ///< gain in chi2 on blocks left out; NaN = not computed
  bool refitted = false;        ///< by the full model; otherwise from one Jacobian
  std::vector<Interval> amplitudes;
};

struct FittedValue {
  double value = 0, sd = 0, prior_z = 0;
  std::string unit;
  double sd_over_prior = 1;  ///< 1: these runs say nothing of it
};

/// A test of what a fit leaves over.
struct FitTest {
  std::string test, about;  ///< replicates, structure, runs, Ljung-Box; channel or the rival that shows most
  double statistic = 0, p = 1;
  double holm = 1;  ///< p after Holm's correction for all tests of this fit
};

/// One model on the data.
struct FittedModel {
  std::array<double, channel_count> rmse{};
  double chi2 = 0, dof = 0;
  std::map<std::string, FittedValue> parameters;
  std::vector<std::array<double, channel_count>> predicted;  ///< of each run
  std::vector<FitTest> tests;
};

struct NextExperiment {
  std::map<std::string, double> condition;  ///< load_N, slip, omega_rad_s, pass
  std::string bench_check, bench_effect;    ///< or this, without soil; it measures the amplitude of bench_effect
  std::vector<std::string> decides;
  double chance = 0;                ///< that one member gets odds of 10 over all others, whichever is true
  std::optional<double> simulated;  ///< the same with refits of old and new runs, a few draws; the first choice only
  double cost = 0;  ///< in runs: repeats, and 2 for each load or speed that the rig has not had; a bench check is 1
  int runs = 0;
};

struct Gain {
  std::vector<std::string> withheld;
  double rmse_ratio = 1, low = 1, high = 1;  ///< extended over nominal on the withheld runs; 95 %
  bool has_interval = true;                  ///< low and high mean something: five conditions at least
  std::vector<double> of_conditions;         ///< the same ratio on each condition alone (rig runs)
  /// false: what was found has no value where it was not seen, and the extended model is the nominal one.
  bool carried = true;
  std::array<double, channel_count> nominal_rmse{}, extended_rmse{};
  int runs = 0;
};

/// What a refit needed: the rise of its objective when one soil value is held at its prior mean and the others are refitted.
struct Needed {
  std::vector<std::string> held;
  double rise = 0;
  double prior_z = 0;  ///< of the first, where it is free
  std::array<double, channel_count> rmse{};
};

/// A soil value from elsewhere under the priors of the case.
struct JudgedValue {
  std::string name, unit;
  double value = 0, prior = 0, z = 0;
};

/// One row against statics, whatever the soil: S = T/r acts at theta = asin(S/hypot(W, F)) - atan2(F, W) on the arc of contact, which begins
/// at theta_f = acos(1 - z/r); N = W cos theta - F sin theta; friction = S/N. Torque about the axle without bearing friction, theta_r small.
struct RowStatics {
  int line = 0;
  double slip = 0, load = 0, theta = 0, theta_f = 0, friction = 0;
  double theta_sd = 0, friction_sd = 0;  ///< of theta - theta_f and of friction, by the errors found
  bool outside = false;                  ///< pushed from outside its contact, by 3 sd
  bool slides = false;                   ///< more friction than the soil has (phi and c at 2 prior sd), by 3 sd
};

struct Diagnosis {
  std::string verdict;  ///< adequate | parameter | named | class | unknown | undecidable
  std::string cause;
  std::vector<std::string> members;
  std::map<std::string, double> posterior;  ///< includes none and unknown
  std::map<std::string, Interval> parameters;
  std::string unknown_variable, unknown_through;
  std::vector<std::array<double, 2>> unknown_curve;  ///< variable, change of the parameter
  std::optional<FittedModel> stated;  ///< as the case has it, nothing refitted; nothing where it carries no wheel
  FittedModel nominal, extended;
  std::vector<Needed> needed;  ///< largest rise first
  std::vector<JudgedValue> judged;
  std::vector<RowStatics> statics;
  std::optional<Gain> gain;
  std::vector<NextExperiment> next;
  std::vector<int> suspect_lines;
  std::vector<double> weights;                        ///< of each run, 1 or towards 0.01 for a suspect
  std::vector<std::array<double, channel_count>> sd;  ///< of each run, as found
  std::vector<Ranked> ranking;
  std::array<double, channel_count> noise_scale{};
  double scatter_ln_k = 0, scatter_phi = 0;
  std::vector<std::string> notes;
  std::string sentence;                        ///< for a person
  std::vector<Run> runs;                       ///< that were fitted
  double rank_seconds = 0, total_seconds = 0;  ///< processor time of one core
};

/// `withhold`: texts "load_N=225" or "slip=0.3..0.7": runs that are not fitted and on which the gain is measured.
/// Deterministic. @throws ConfigError for the options and for data that no parameter set of the model can follow.
Diagnosis diagnose(const DiagnosisCase& c, const RunTable& data, const std::vector<std::string>& withhold);

/// extended_case.yaml: the case with the values found, soil held, amplitudes of model and rig under `known_effects`. It is read as a case.
std::string extended_case_text(const Diagnosis& d, const DiagnosisCase& c);

}  // namespace grouser::diagnosis
