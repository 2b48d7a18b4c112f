#pragma once
// Runs the diagnosis command on every set; a set with a diagnosis.json is not run again.
#include <string>

namespace blind {

struct DriveOptions {
  std::string sets, command, results;
  int jobs = 0;       ///< 0: as many as cores
  int limit = 0;      ///< > 0: only the first so many sets
  int timeout = 120;  ///< seconds for a set
};

/// Command line for one set: COMMAND diagnose case.yaml --data data.csv --out DIR [--withhold ...], quoted for the
/// shell, at most
/// `timeout` seconds, output to log.txt in the result folder.
std::string command_line(const DriveOptions& options, const std::string& set);

/// Writes run.json (seconds, exit code) beside each result and progress to stderr. Returns 1 when a set gave no
/// diagnosis.json.
int drive(const DriveOptions& options);

}  // namespace blind
