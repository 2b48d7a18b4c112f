#pragma once
// Vehicles from YAML and URDF. All errors of all files are collected and reported in one go.
#include <filesystem>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/vehicle/vehicle_spec.h"

namespace grouser::vehicle {

/// Errors and assumptions of every file of one input.
struct InputLog {
  std::vector<Diagnostic> errors;
  std::vector<Assumption> assumptions;
  void take(const ConfigDocument& d);
  void error(std::string file, int line, int column, std::string message);
  /// @throws ConfigError with all errors by file, line and column, when there are any.
  void check();
};

/// Vehicle from `file` (.yaml, .yml, .urdf); schema in examples/vehicles/README.md.
///
/// URDF says nothing of tyres, motors, steering or a battery: these are read from `extras` (the scenario), keys
/// `wheels` (link name -> {wheel: file, motor: ...}), `motors`, `steering`, `differential`, `battery`. A YAML vehicle
/// has them itself and `extras` must not have them.
///
/// Errors go to `log`: unknown parent or child, two parents, a loop, no or two roots, mass not positive, an inertia
/// that no body has (principal moments positive, each at most the sum of the others), missing wheel file, wheel joint
/// that is not revolute, ... The returned value is only good when log.check() passes.
VehicleSpec load_vehicle(const std::filesystem::path& file, const ConfigNode& extras, InputLog& log);

/// The bodies and joints of a URDF file alone, checked as above; which links are wheels only a scenario says.
VehicleSpec load_urdf_alone(const std::filesystem::path& file, InputLog& log);

}  // namespace grouser::vehicle
