#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "grouser/terrain/config.h"

namespace grouser::app {

/// What a YAML file is, told by its first key of the list in the .cpp.
struct FileKind {
  const char* key;      ///< that it begins with
  const char* name;     ///< for a person
  const char* command;  ///< that takes it; nullptr: another file names it
};
std::optional<FileKind> kind_of(const ConfigNode& root);

/// Nothing when the file may be of the kind that begins with `key`; what is missing in it is told by its own reader.
/// @throws ConfigError: the file cannot be parsed, or it is clearly something else (names the command for that).
void expect_kind(const std::filesystem::path& file, const std::string& key);

/// "scenario, rig, ...": keys that kind_of knows.
std::string known_kinds();

}  // namespace grouser::app
