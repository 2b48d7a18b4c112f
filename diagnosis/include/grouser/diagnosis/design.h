#pragma once
// What a planned experiment could and could not tell apart, before anything is measured: `grouser diagnose --design`.
#include <string>
#include <vector>

#include "grouser/diagnosis/diagnose.h"

namespace grouser::diagnosis {

struct DesignEffect {
  std::string id, unit;
  double typical = 0;         ///< an ordinary size, as shown to a person
  double distance = 0;        ///< d of that size: its fingerprint after the refit of the soil, in noise sd
  double smallest = 0;        ///< size with d = 6, from which nine in ten are named; linear in the amplitude
  bool within_bounds = true;  ///< whether physics allows that size
};

struct DesignRun {
  std::map<std::string, double> condition;
  int repeats = 4;
  std::size_t alike_pairs = 0;  ///< pairs above the limit that are left with these runs
};

struct Design {
  int runs = 0;
  std::vector<DesignEffect> effects;
  std::vector<std::vector<double>> likeness;       ///< |cos| of two fingerprints after the refit
  std::vector<std::vector<std::string>> clusters;  ///< effects joined by |cos| above `limit`
  std::size_t alike_pairs = 0;
  std::vector<DesignRun> add;  ///< best runs to add, best first
  std::string sentence;
  std::vector<std::string> notes;
};
constexpr double alike_limit = 0.95;

/// At the prior means of the soil, every effect at the slope of amplitude 0, noise as the plan states it, soil refitted under its priors.
/// Cost: one Jacobian for the plan and one for each of some 80 runs that could be added; about 1 s for 216 runs.
/// @throws ConfigError: the wheel has no answer for a planned run.
Design judge_design(const DiagnosisCase& c, const RunTable& plan);

/// PLAN.csv: the columns of `read_runs` without measured values; channels are those with a column drawbar_sd_N, torque_sd_Nm, sinkage_sd_m.
RunTable read_plan(const std::filesystem::path& csv, const DiagnosisCase& c);
/// "slip=-0.5,0,0.5 load_N=60,225 omega_rad_s=0.3 pass=1,2 repeats=2 drawbar_sd_N=2 torque_sd_Nm=0.2 sinkage_sd_m=0.0015": every
/// combination. slip, load_N and one of the sd are required. @throws ConfigError.
RunTable grid_plan(const std::string& text);

}  // namespace grouser::diagnosis
