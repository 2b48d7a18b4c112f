// grouser list: models with their annotated defaults and effects, and the library of soils, wheels, vehicles, grounds.
#include <fmt/core.h>

#include <algorithm>

#include "commands.h"
#include "grouser/models.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/loaders.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

const ModelInfo& model_or_error(const std::string& id) {
  try {
    return all_models().get(id);
  } catch (const std::out_of_range& e) {
    throw ConfigError("list", 0, 0, e.what());
  }
}

void print_model(const ModelInfo& m) {
  fmt::print("{}\n  {}\n  can:    {}\n  cannot: {}\n", m.id, m.summary, m.can, m.cannot);
}

/// A soil of the library that any model can be made from, to ask the model for its effects.
std::unique_ptr<Terrain> sample(const ModelInfo& m) {
  static const Soil soil = load_soil_file(library_folder() / "soils" / "mojave_martian_simulant.yaml");
  return m.make({soil, flat_ground(), {}, 9.81});
}

void print_effects(const ModelInfo& m) {
  fmt::print("{}\n", m.id);
  const auto terrain = sample(m);
  for (const Effect& e : terrain->effects())
    fmt::print("  {}  [{}]  {} .. {}\n      {}\n      {}\n", e.id, e.unit, e.lower, e.upper, e.description, e.citation);
  if (terrain->effects().empty()) fmt::print("  no optional effects\n");
}

std::vector<fs::path> library_files(const std::string& what) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(library_folder() / what)) {
    const std::string ext = entry.path().extension().string();
    if (ext == ".yaml" || ext == ".urdf") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

int list_files(const std::string& what, const std::string& id) {
  const std::string key = what.substr(0, what.size() - 1);  // soils -> soil
  std::vector<std::string> names;
  for (const fs::path& file : library_files(what)) {
    names.push_back(file.stem().string());
    const bool wanted = id.empty() || id == names.back() || id == file.filename().string();
    if (!wanted) continue;
    const ConfigDocument doc = ConfigDocument::from_file(file);
    if (!id.empty()) {
      fmt::print("# {}\n{}", file.string(), doc.text());
      return 0;
    }
    const ConfigNode root = doc.root();
    fmt::print("{:<34} {}\n", file.filename().string(), root.is_map() ? root.text_or(key, "") : "");
  }
  if (id.empty()) return 0;
  const auto near = did_you_mean(id, names);
  throw ConfigError("list " + what, 0, 0, "no '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
}

}  // namespace

int list(const std::string& what, const std::string& id, bool yaml) {
  const std::vector<std::string> known = {"models", "effects", "soils", "wheels", "vehicles", "grounds"};
  if (what == "models" || what == "effects") {
    for (const ModelInfo& m : all_models().models()) {
      if (!id.empty() && m.id != model_or_error(id).id) continue;
      if (what == "effects")
        print_effects(m);
      else if (yaml)
        fmt::print("# {}\n{}\n", m.id, m.annotated_defaults);
      else
        print_model(m);
    }
    return 0;
  }
  if (std::find(known.begin(), known.end(), what) != known.end()) return list_files(what, id);
  const auto near = did_you_mean(what, known);
  throw ConfigError("list", 0, 0,
                    "cannot list '" + what + "'" + (near ? "; did you mean '" + *near + "'?" : "") +
                        " Known: models, effects, soils, wheels, vehicles, grounds");
}

}  // namespace grouser::app
