#include "folders.h"

#include "grouser/models.h"
#include "grouser/terrain/config.h"

namespace grouser::app {

namespace fs = std::filesystem;

fs::path default_folder(const fs::path& file, const std::optional<std::string>& terrain) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  std::string model = terrain.value_or(doc.root().optional_map("terrain").text_or("model", "default"));
  return fs::path("runs") / (file.stem().string() + "-" + model);
}

void check_folder(const fs::path& folder, bool overwrite) {
  const bool used = fs::exists(folder / "run.h5") || fs::exists(folder / "sweep.csv");
  if (used && !overwrite)
    throw ConfigError(folder.string(), 0, 0,
                      "holds the results of an earlier run; use --overwrite, or another folder with --out");
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw ConfigError(folder.string(), 0, 0, "is a file; name a folder with --out");
}

void check_terrain_id(const std::optional<std::string>& id) {
  if (!id || all_models().has(*id)) return;
  try {
    all_models().get(*id);
  } catch (const std::out_of_range& e) {
    throw ConfigError("--terrain", 0, 0, e.what());
  }
}

}  // namespace grouser::app
