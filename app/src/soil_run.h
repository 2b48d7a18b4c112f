#pragma once
// Runs the cases of a soil test, several at a time; what is finished is on disk, what is under way continues after a kill.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "soil_case.h"

namespace grouser::app {

struct SoilJob {
  const SoilCase* spec = nullptr;
  std::filesystem::path folder;  ///< of its results
};

struct SoilRunOptions {
  std::filesystem::path beds;    ///< folder of packings, by the hash of their inputs
  int threads = 1;               ///< cases at the same time
  double checkpoint_every = 30;  ///< [s] of the clock
  bool quiet = false, overwrite = false;
  std::string head;  ///< of the line of progress
  double then = 0;   ///< work that follows, as a multiple of these cases: counts in the time left
};

struct SoilCaseResult {
  const SoilCase* spec = nullptr;
  bool done = false;
  std::string failure;  ///< why not
  dem::Table table{};
};

/// In the order of the jobs, as threads become free. `finished` is called after every case, one call at a time.
/// @throws ConfigError when a folder holds results of other inputs, ResultsError when it cannot be written.
std::vector<SoilCaseResult> run_soil_cases(const std::vector<SoilJob>& jobs, const SoilRunOptions& o,
                                           const std::function<void(const std::vector<SoilCaseResult>&)>& finished);

}  // namespace grouser::app
