#pragma once
// Shared by the YAML and the URDF reader.
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "grouser/vehicle/vehicle_loader.h"

namespace grouser::vehicle {

/// Where a thing was defined, for errors found after reading.
struct Place {
  std::string file;
  int line = 0, column = 0;
};

/// What a scenario says of a URDF vehicle.
inline constexpr std::array urdf_extras{"wheels", "motors", "steering", "differential", "battery"};

struct ReadVehicle {
  VehicleSpec spec;
  std::vector<Place> link_place, joint_place;
  std::vector<bool> fixed;        ///< per joint: merge the child into the parent
  bool wheels_elsewhere = false;  ///< a URDF alone: which links are wheels is said by a scenario
};

void read_yaml_vehicle(const ConfigNode& root, ReadVehicle& v, InputLog& log);
void read_urdf_vehicle(const std::filesystem::path& file, const ConfigNode& extras, ReadVehicle& v, InputLog& log);

/// `motors`, `battery`, `steering`, `differential` of `root`. Joints must be known; motors before wheels.
void read_motors(const ConfigNode& root, VehicleSpec& v);
void read_drive_train(const ConfigNode& root, VehicleSpec& v);
/// `motor:` of a wheel: a name from `motors` or a map of its own. -1 when absent.
int read_wheel_motor(const ConfigNode& wheel, VehicleSpec& v);
/// Running gear of `wheel:`; one reading per file.
RunningGear read_gear(const ConfigNode& wheel, std::map<std::string, RunningGear>& cache, InputLog& log);

/// "unknown <what> 'x'; did you mean 'y'? known: ..."
std::string unknown_name(const std::string& what, const std::string& name, const std::vector<std::string>& known);
int index_of(const std::string& name, const std::vector<std::string>& names);
std::vector<std::string> link_names(const VehicleSpec& v);
std::vector<std::string> joint_names(const VehicleSpec& v);

/// Tree, masses and inertias; merges fixed joints. Notes errors in `log`; leaves `v` alone when there are any.
void check_and_merge(ReadVehicle& v, InputLog& log);

}  // namespace grouser::vehicle
