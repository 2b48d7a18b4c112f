#pragma once
#include <filesystem>

namespace grouser::app {

struct SdemBuildArguments {
  std::filesystem::path campaign, out, runs, beds;
  int threads = 1;
  bool plan = false, overwrite = false, quiet = false;
};
/// Runs what is missing of a campaign and makes its tables; returns the exit code.
int sdem_build(SdemBuildArguments a);

}  // namespace grouser::app
