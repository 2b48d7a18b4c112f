// grouser list: models with their annotated defaults and effects, and the library of soils, wheels, vehicles, grounds.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "commands.h"
#include "grouser/models.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"
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
  const fs::path folder = library_folder() / what;
  if (!fs::is_directory(folder))
    throw ConfigError(folder.string(), 0, 0, "the library has no such folder; set GROUSER_LIBRARY to one that has it");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ext = entry.path().extension().string();
    if (ext == ".yaml" || ext == ".urdf") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// One line on a library file: its title, or what the ground says of itself.
std::string description(const fs::path& file, const std::string& what) {
  if (file.extension() == ".urdf") return "URDF; the scenario names its wheels and motors";
  if (what == "grounds") return load_ground_file(file, 1)->describe();
  const ConfigNode root = ConfigDocument::from_file(file).root();
  return root.is_map() ? root.text_or(what.substr(0, what.size() - 1), "") : "";  // soils -> soil
}

int list_files(const std::string& what, const std::string& id) {
  const std::vector<fs::path> files = library_files(what);
  std::size_t width = 0;
  for (const fs::path& file : files) width = std::max(width, file.filename().string().size());
  if (id.empty()) {
    fmt::print("# {}\n", (library_folder() / what).string());
    for (const fs::path& file : files)
      fmt::print("{:<{}}  {}\n", file.filename().string(), width, description(file, what));
    return 0;
  }
  std::vector<std::string> names;
  for (const fs::path& file : files) {
    names.push_back(file.stem().string());
    if (id != names.back() && id != file.filename().string()) continue;
    const bool xml = file.extension() == ".urdf";
    fmt::print("{}", xml ? "" : "# " + file.string() + "\n");
    fmt::print("{}", read_text_file(file));
    return 0;
  }
  const auto near = did_you_mean(id, names);
  throw ConfigError("list " + what, 0, 0,
                    "no '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ".") + " 'grouser list " + what +
                        "' shows all " + std::to_string(names.size()));
}

constexpr std::array<std::array<const char*, 2>, 6> listed{{{"models", "terrain models: what each can and cannot"},
                                                            {"effects", "optional physics of the models"},
                                                            {"soils", "soil files of the library"},
                                                            {"wheels", "wheel files of the library"},
                                                            {"vehicles", "vehicle files of the library"},
                                                            {"grounds", "ground files of the library"}}};

}  // namespace

int list(const std::string& what, const std::string& id, bool yaml) {
  if (what.empty()) {
    fmt::print("grouser list WHAT [NAME], where WHAT is\n");
    for (const auto& [name, text] : listed) fmt::print("  {:<9} {}\n", name, text);
    return 0;
  }
  if (yaml && what != "models")
    throw ConfigError("--yaml", 0, 0, "goes with 'list models'; 'list " + what + " NAME' shows a whole file");
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
  std::vector<std::string> known;
  for (const auto& entry : listed) known.emplace_back(entry[0]);
  if (std::find(known.begin(), known.end(), what) != known.end()) return list_files(what, id);
  const auto near = did_you_mean(what, known);
  throw ConfigError("list", 0, 0,
                    fmt::format("cannot list '{}'{} Known: {}", what, near ? "; did you mean '" + *near + "'?" : ".",
                                fmt::join(known, ", ")));
}

}  // namespace grouser::app
