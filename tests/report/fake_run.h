#pragma once
// Invented results in the form that `grouser run` and `grouser rig` leave behind: plausible to look at, made of
// formulas, no physics.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace grouser::test {

struct FakeRun {
  std::string terrain = "bekker.steady";
  double duration = 10;    ///< [s]
  double rate = 200;       ///< [Hz]
  double sinkage = 0.014;  ///< [m] mean
  std::string status = "finished";
  std::optional<double> slip = {};         ///< of every wheel at every time, in place of an invented one
  std::vector<std::string> warnings = {};  ///< of the run
};

/// Four-wheel robot over rough ground.
void write_fake_run(const std::filesystem::path& folder, const FakeRun& f);
/// Sweep of nine slips with measured.csv and errors.csv.
void write_fake_rig(const std::filesystem::path& folder);

/// Speed that the fake run records at time t [m/s].
double fake_speed(double t);

}  // namespace grouser::test
