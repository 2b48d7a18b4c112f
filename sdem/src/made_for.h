#pragma once
// A file of a surrogate is made for one soil and one wheel; anything else is refused by name.
#include <filesystem>
#include <string>

#include "grouser/terrain/config.h"
#include "grouser/terrain/soil.h"
#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

/// How messages speak of it.
struct FileKind {
  const char *model, *key, *noun;  ///< sdem.v1, table, tables
  const char *verb, *content;      ///< are, "holds tables of grains"
  const char* how_to_see;          ///< " (grouser sdem info FILE lists it)", or nothing
};

/// File named under the kind's key; empty where there is none or 'none'. A name without a file is noted as an error.
std::filesystem::path named_file(const ConfigNode& options, const FileKind& kind);
/// Notes an error unless the grains of `soil` are those that the file is of (`grains`: soil_text).
void check_soil(const ConfigNode& options, const FileKind& kind, const std::string& grains, const Soil& soil);
/// @throws TerrainError unless the body's outer radius is `radius`, to a thousandth [m].
void check_wheel(const FileKind& kind, const BodySpec& body, double radius, const std::string& wheel);

}  // namespace grouser::sdem
