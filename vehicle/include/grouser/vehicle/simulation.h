#pragma once
// Runs a scenario: trims and settles the vehicle, steps Bullet and the terrain, records run.h5, writes checkpoints,
// resumes.
//
// Run folder: run.h5, run.xdmf, checkpoint.h5 and inputs/ (copies of every file the scenario is made of; the run reads
// these, so that a resumed run sees the same input whatever happened to the originals).
//
// Same bits: at every checkpoint the Bullet world, the terrain and the driver are built anew from the saved state, in
// the run that saves as in the run that resumes. Bullet's hidden state (solver seeds, caches) thus never matters, and
// an uninterrupted run, a killed and resumed one and any number of threads end in the same state hash.
// Before t = 0 the vehicle stands still with its motors held at zero: for start.settle, or, when the scenario does not say, until no body
// has moved faster than 0.1 mm/s for 0.5 s, at most 30 s. How long, and the fastest body after it, are attributes of run.h5.
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/terrain/registry.h"

namespace grouser::vehicle {

/// Not a number, runaway energy, a lost wheel, or the terrain gave up: names time, body, reason and the last good
/// checkpoint. What was recorded is kept; the attribute `status` of run.h5 says "stopped: ...".
struct SimulationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Progress {
  double time = 0, duration = 0;  ///< [s] simulated
  double wall_s = 0;              ///< [s]
};

struct RunOptions {
  std::filesystem::path out;  ///< folder, made when it is not there
  int threads = 1;
  std::optional<std::string> terrain;             ///< replaces the scenario's terrain.model
  std::optional<double> duration;                 ///< [s] replaces the scenario's
  std::function<void(const Progress&)> progress;  ///< called about ten times per second
};

struct RunSummary {
  std::filesystem::path folder;
  double simulated_s = 0, wall_s = 0, bullet_s = 0, terrain_s = 0, output_s = 0;
  std::string end_state_hash;
  double energy_residual_ratio = 0;  ///< [-] |what does not close| at the end over energy_yardstick_J
  double energy_yardstick_J = 0;     ///< [J] VehicleEnergy::yardstick()
  double energy_step_J = 0;  ///< [J] what the time step itself put in; < 0: took (implicit_correction + integration)
  std::string energy_yardstick;  ///< what it is: "positive motor work" or "height energy given up"
  double joint_drift_m = 0;      ///< [m] largest of the run
  double total_mass = 0;         ///< [kg]
  std::vector<std::string>
      warnings;  ///< what the results must be read with: a wheel left the ground's data, no rest at the start
  std::vector<std::string> notices;  ///< how the terrain simplifies the wheels
};

/// @throws ConfigError (input), ResultsError (folder cannot be written), SimulationError.
RunSummary run_scenario(const std::filesystem::path& yaml, const Registry& registry, const RunOptions& options);

/// Continue a run that was killed or stopped, from its last checkpoint. Frames after it are cut off and computed again.
/// @throws ResultsError: no run there, damaged, or the checkpoint belongs to another scenario; SimulationError.
RunSummary resume_run(const std::filesystem::path& folder, const Registry& registry, int threads,
                      const std::function<void(const Progress&)>& progress = {});

/// Everything that run_scenario checks before it starts. Returns the notices that its summary would have. @throws ConfigError
std::vector<std::string> check_scenario(const std::filesystem::path& yaml, const Registry& registry);

}  // namespace grouser::vehicle
