#pragma once
// Scenario = vehicle + terrain + ground + driver + duration, from one YAML file and those that it names.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grouser/terrain/registry.h"
#include "grouser/vehicle/driver.h"
#include "grouser/vehicle/vehicle_spec.h"

namespace grouser::vehicle {

/// What the command line may change without touching the file.
struct ScenarioOverrides {
  std::optional<std::string> terrain;  ///< replaces terrain.model only
  std::optional<double> duration;      ///< [s] > 0
};

/// Keys, units and defaults: examples/02_robot_rough_ground/README.md.
struct Scenario {
  std::filesystem::path file;
  std::string title;
  std::string model;    ///< terrain model id in force
  std::string effects;  ///< what is switched on in it, as text
  VehicleSpec vehicle;
  GroundPtr ground;
  double duration = 0, time_step = 1e-3, gravity = 9.81;  ///< [s], [s], [m/s^2]
  long seed = 1;
  double output_rate = 200;      ///< [Hz]
  double checkpoint_every = 1;   ///< [s]
  std::optional<double> settle;  ///< [s] of standing still before t = 0; none: until at rest (simulation.h)
  Pose start;                    ///< vehicle frame: x, y and yaw; z = height of the ground there
  std::vector<Assumption> assumptions;
  std::vector<std::string> notices;  ///< the assumptions that only the vehicle on this terrain shows, as lines to print
  ScenarioOverrides overrides;
  const Registry* registry = nullptr;
  ConfigDocument document;

  std::unique_ptr<Terrain> make_terrain() const;
  std::unique_ptr<Driver> make_driver() const;
  long steps_per_frame() const;
  long steps_per_checkpoint() const;
  long steps() const;
};

/// @throws ConfigError with every error of every file.
Scenario load_scenario(const std::filesystem::path& file, const Registry& registry,
                       const ScenarioOverrides& overrides = {});

/// An absolute file name inside a YAML file.
struct AbsoluteName {
  int line = 0, column = 0;
  std::string written;
  std::filesystem::path file;
};
/// A file that a scenario needs, and its place relative to the common folder of all of them.
struct InputFile {
  std::filesystem::path source;
  std::filesystem::path relative;
  std::vector<AbsoluteName> absolute;  ///< names in it that would lead out of a copy
};
/// The scenario file first, then every existing file that it names, directly or through other YAML files.
std::vector<InputFile> collect_inputs(const std::filesystem::path& scenario);
/// Copies them into `folder`, emptied first; absolute names become relative ones, so that the copies need nothing else.
/// @throws ResultsError when a file cannot be written, ConfigError for an absolute name that escapes hide.
void copy_inputs(const std::vector<InputFile>& inputs, const std::filesystem::path& folder);
/// Text of all YAML and URDF inputs one after the other with their relative names, the hash of every other one, and the
/// overrides: two runs with equal text are the same run. Free of absolute paths.
std::string resolved_text(const std::vector<InputFile>& inputs, const ScenarioOverrides& overrides);

}  // namespace grouser::vehicle
