#pragma once
#include <filesystem>

namespace grouser::app {

struct SdemTrainArguments {
  std::filesystem::path plan_file, runs;
  bool plan = false, quiet = false;
};
/// Runs what is missing of a training plan; returns the exit code.
int sdem_train(SdemTrainArguments a);

}  // namespace grouser::app
