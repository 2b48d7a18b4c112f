#pragma once
#include <filesystem>
#include <string>

namespace grouser::app {

struct SdemBuildArguments {
  std::filesystem::path campaign, out, runs, beds;
  std::string part;  ///< of the missing runs, see sdem_part.h; empty: all, and the tables
  int slurm = 0;     ///< > 0: print a script of so many jobs, nothing else
  int threads = 1;
  bool plan = false, overwrite = false, quiet = false;
};
/// Runs what is missing of a campaign and makes its tables; returns the exit code.
int sdem_build(SdemBuildArguments a);

}  // namespace grouser::app
