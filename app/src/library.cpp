#include <cstdlib>

#include "commands.h"
#include "grouser/terrain/config.h"

namespace grouser::app {

std::filesystem::path library_folder() {
  namespace fs = std::filesystem;
  if (const char* named = std::getenv("GROUSER_LIBRARY")) {
    if (fs::is_directory(named)) return named;
    throw ConfigError(named, 0, 0,
                      "GROUSER_LIBRARY is not a folder; it should hold soils/, wheels/, vehicles/, grounds/");
  }
  for (const char* folder : {GROUSER_INSTALLED_LIBRARY, GROUSER_SOURCE_LIBRARY})
    if (fs::is_directory(fs::path(folder) / "soils")) return folder;
  throw ConfigError("library", 0, 0,
                    "soils, wheels and vehicles not found; set GROUSER_LIBRARY to the examples folder");
}

}  // namespace grouser::app
