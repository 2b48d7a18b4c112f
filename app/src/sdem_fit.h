#pragma once
#include <filesystem>

namespace grouser::app {

struct SdemFitArguments {
  std::filesystem::path plan_file, runs, out, windows;
  bool overwrite = false, quiet = false, partly = false, without_memory = false, without_pile = false;
};
/// Fits the law of sdem.v2 to the runs of a training plan; returns the exit code.
int sdem_fit(SdemFitArguments a);

}  // namespace grouser::app
