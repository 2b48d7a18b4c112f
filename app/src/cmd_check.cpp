// grouser check: says of each file what it is and names every error in it.
#include <fmt/core.h>

#include <cstdio>

#include "commands.h"
#include "figure_file.h"
#ifdef GROUSER_BEKKER
#include "grouser/bekker/table.h"
#endif
#ifdef GROUSER_DIAGNOSIS
#include "grouser/diagnosis/fit_file.h"
#endif
#include "grouser/models.h"
#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"
#include "grouser/vehicle/rig.h"
#include "grouser/vehicle/simulation.h"
#include "grouser/vehicle/vehicle_loader.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

void check_vehicle(const fs::path& file) {
  vehicle::InputLog log;
  vehicle::load_vehicle(file, {}, log);
  log.check();
}

std::string check_yaml(const fs::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  doc.check();
  const ConfigNode root = doc.root();
  if (root.has("scenario")) return vehicle::check_scenario(file, all_models()), "scenario";
  if (root.has("rig")) return vehicle::check_rig(file, all_models()), "rig";
#ifdef GROUSER_DIAGNOSIS
  if (root.has("fit")) return diagnosis::run_fit(file), "fit";
#endif
  if (root.has("vehicle")) return check_vehicle(file), "vehicle";
#ifdef GROUSER_BEKKER
  if (root.has("table")) return bekker::load_table_spec(file), "table";
#endif
  if (root.has("wheel")) return load_running_gear_file(file), "wheel";
  if (root.has("terrain")) return load_terrain(file), "terrain";
  if (root.has("soil")) return load_soil_file(file), "soil";
  if (root.has("items")) return report::read_figures(file), "figures";
  if (root.has("shape") || root.is_list() || root.has("ground")) {
    load_ground(root.has("ground") ? root.node("ground") : root, 0);
    doc.check();
    return "ground";
  }
  throw ConfigError(
      file.string(), root.line(), root.column(),
      "cannot tell what this file is; it should begin with one of the keys scenario, rig, vehicle, wheel, "
      "soil, terrain, ground, table, items, fit");
}

std::string check_hdf5(const fs::path& file) {
  if (file.filename().string().find("checkpoint") != std::string::npos) {
    const Checkpoint c = read_checkpoint(file);
    return fmt::format("checkpoint at {:.3f} s, state {}", c.time, c.state.hash_text());
  }
  const RunFile r(file);
  if (r.attributes().kind == "table") return fmt::format("lookup table '{}'", r.attributes().title);
  return fmt::format("{} '{}' on {}, {} frames, {}", r.attributes().kind, r.attributes().title, r.attributes().terrain,
                     r.frames(), r.attribute("status"));
}

std::string check_one(const fs::path& file) {
  const std::string ext = file.extension().string();
  if (ext == ".h5") return check_hdf5(file);
  if (ext == ".urdf")
    throw ConfigError(
        file.string(), 0, 0,
        "a URDF says nothing of wheels and motors; check the scenario that names this file and its wheels");
  return check_yaml(file);
}

}  // namespace

int check(const std::vector<fs::path>& files) {
  int code = 0;
  for (const fs::path& file : files) {
    try {
      fmt::print("{}: {}, no errors\n", file.string(), check_one(file));
    } catch (const ConfigError& e) {
      fmt::print(stderr, "{}\n", e.what());
      code = 2;
    } catch (const ResultsError& e) {
      fmt::print(stderr, "{}\n", e.what());
      code = 2;
    }
  }
  return code;
}

}  // namespace grouser::app
