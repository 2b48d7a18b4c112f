#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace grouser::app {

/// runs/<file>-<terrain>; the terrain is the file's own when none was asked for.
std::filesystem::path default_folder(const std::filesystem::path& file, const std::optional<std::string>& terrain);

/// @throws ConfigError when it holds the results of an earlier run and overwrite is false, or is no folder.
void check_folder(const std::filesystem::path& folder, bool overwrite);

/// @throws ConfigError for a --terrain that is not in the registry.
void check_terrain_id(const std::optional<std::string>& id);

}  // namespace grouser::app
