#pragma once
// Soils, running gear and grounds from YAML. Each returns a value even when it notes errors; call the document's check() before use.
#include <filesystem>

#include "grouser/terrain/config.h"
#include "grouser/terrain/ground.h"
#include "grouser/terrain/running_gear.h"
#include "grouser/terrain/soil.h"

namespace grouser {

/// Soil file (`soil:`, `source:`, `bekker:`, `rigid:`, `bulk_density:`); schema in examples/soils/README.md.
Soil load_soil(const ConfigNode& root);
Soil load_soil_file(const std::filesystem::path& file);  ///< @throws ConfigError

/// Wheel file (`wheel:`, `source:`, `shape: smooth | lugged | mesh`, ...); schema in examples/wheels/README.md.
RunningGear load_running_gear(const ConfigNode& root);
RunningGear load_running_gear_file(const std::filesystem::path& file);  ///< @throws ConfigError

/// Ground: one shape map or a list of shapes whose heights add up; schema in examples/grounds/README.md.
/// `seed` is the scenario's seed, used by random shapes that do not set their own.
/// An absent node is level ground at z = 0. A shape {include: file.yaml} takes over the `ground:` of another file.
GroundPtr load_ground(const ConfigNode& node, std::uint64_t seed);
GroundPtr load_ground_file(const std::filesystem::path& file,
                           std::uint64_t seed);  ///< `ground:`, `source:`. @throws ConfigError

}  // namespace grouser
