#pragma once
// Every terrain model of this build, and the shortest way from a YAML file to a terrain.
#include <filesystem>
#include <memory>
#include <string>

#include "grouser/terrain/registry.h"

namespace grouser {

/// The registry of this build: one line per model in app/models/models.cpp.
const Registry& all_models();

/// A terrain from a file with `terrain:` (model id), `soil:` (soil file), `ground:` (shapes, flat when absent), `options:`,
/// `effects:` (id: amplitude), `gravity:`.
/// @throws ConfigError with every error of the file and of those that it names.
std::shared_ptr<Terrain> load_terrain(const std::filesystem::path& yaml);

}  // namespace grouser
