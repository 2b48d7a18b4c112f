#pragma once
#include <filesystem>

namespace grouser::app {

struct SdemFitArguments {
  std::filesystem::path plan_file, runs, out, start;
  bool overwrite = false, quiet = false, partly = false, keep_coefficients = false;
  bool without_memory = false, without_pile = false;
};
/// Fits the law of sdem.v2 to the runs of a training plan; returns the exit code.
int sdem_fit(SdemFitArguments a);

struct SdemCompareArguments {
  std::filesystem::path law, plan_file, runs;
  double share = 0.65;
  bool quiet_grains = false, without_memory = false, without_pile = false;
};
/// CSV on standard output: one row for each run of a plan that is there, grains and law.
int sdem_compare(const SdemCompareArguments& a);

}  // namespace grouser::app
