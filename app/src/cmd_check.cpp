// grouser check: says of each file what it is and names every error in it.
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

#include "commands.h"
#include "figure_file.h"
#include "file_kind.h"
#ifdef GROUSER_SDEM
#include "grouser/sdem/campaign.h"
#include "grouser/sdem/training.h"
#endif
#ifdef GROUSER_BEKKER
#include "grouser/bekker/table.h"
#endif
#ifdef GROUSER_DEM
#include "dem_bed.h"
#include "dem_case.h"
#include "soil_calibration.h"
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

std::string check_urdf(const fs::path& file) {
  vehicle::InputLog log;
  const vehicle::VehicleSpec v = vehicle::load_urdf_alone(file, log);
  log.check();
  return fmt::format("URDF of {} bodies and {} joints (wheels and motors: check the scenario that names it)",
                     v.links.size(), v.joints.size());
}

std::string check_yaml(const fs::path& file, std::vector<std::string>& notices) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  doc.check();
  const ConfigNode root = doc.root();
  const auto kind = kind_of(root);
  const std::string key = kind ? kind->key : "";
  if (key == "scenario") return notices = vehicle::check_scenario(file, all_models()), "scenario";
  if (key == "rig") return vehicle::check_rig(file, all_models()), "rig";
#ifdef GROUSER_DIAGNOSIS
  if (key == "fit") return diagnosis::run_fit(file), "fit";
#endif
#ifdef GROUSER_DEM
  if (key == "soil_test") return check_soil_file(file), "soil test on grains";
  if (key == "campaign") return read_campaign(file), "campaign of soil tests";
  if (key == "calibration") return read_calibration(file), "calibration of grains";
  if (key == "dem") return read_dem_case(file), "discrete-element case";
  if (key == "bed") return read_dem_bed(file), "bed of grains";
#endif
#ifdef GROUSER_SDEM
  if (key == "surrogate") return sdem::load_campaign(file), "campaign of the surrogate";
  if (key == "training") {
    std::vector<sdem::TrainingRun> runs;
    sdem::load_training(file, runs);
    return fmt::format("training plan of the surrogate, {} runs", runs.size());
  }
#endif
#ifdef GROUSER_BEKKER
  if (key == "table") return bekker::load_table_spec(file), "table";
#endif
  if (key == "items") return report::read_figures(file), "figures";
  if (key == "vehicle") return check_vehicle(file), "vehicle";
  if (key == "wheel") return load_running_gear_file(file), "wheel";
  if (key == "terrain") return load_terrain(file), "terrain";
  if (key == "soil") return load_soil_file(file), "soil";
  const std::vector<ConfigNode> items = root.items();
  if (key == "ground" || key == "shape" ||
      std::any_of(items.begin(), items.end(), [](const ConfigNode& n) { return n.is_map(); })) {
    load_ground(key == "ground" ? root.node("ground") : root, 0);
    doc.check();
    return "ground";
  }
  throw ConfigError(file.string(), root.line(), root.column(),
                    "cannot tell what this file is; it should begin with one of the keys " + known_kinds());
}

std::string check_hdf5(const fs::path& file) {
  if (file.filename().string().find("checkpoint") != std::string::npos) {
    const Checkpoint c = read_checkpoint(file);
    return fmt::format("checkpoint at {:.3f} s, state {}", c.time, c.state.hash_text());
  }
  const RunFile r(file);
  if (r.attributes().kind == "bed") return fmt::format("bed of grains '{}'", r.attributes().title);
  if (r.attributes().kind == "table") return fmt::format("lookup table '{}'", r.attributes().title);
  return fmt::format("{} '{}' on {}, {} frames, {}", r.attributes().kind, r.attributes().title, r.attributes().terrain,
                     r.frames(), r.attribute("status"));
}

std::string check_one(const fs::path& file, std::vector<std::string>& notices) {
  const std::string ext = file.extension().string();
  if (ext == ".h5") return check_hdf5(file);
  if (!fs::exists(file)) throw ConfigError(file.string(), 0, 0, "the file does not exist");
  if (ext == ".csv")
    throw ConfigError(
        file.string(), 0, 0,
        "a table alone says nothing of its use; check the ground, rig, fit or figures file that names it");
  if (ext == ".obj" || ext == ".stl")
    throw ConfigError(file.string(), 0, 0, "a mesh alone says nothing of its use; check the wheel file that names it");
  if (ext == ".asc" || ext == ".png")
    throw ConfigError(file.string(), 0, 0,
                      "a height map alone says nothing of its use; check the ground file that names it");
  if (ext == ".urdf") return check_urdf(file);
  return check_yaml(file, notices);
}

}  // namespace

int check(const std::vector<fs::path>& files) {
  int code = 0;
  for (const fs::path& file : files) {
    try {
      std::vector<std::string> notices;
      const std::string kind = check_one(file, notices);
      fmt::print("{}: {}, no errors\n", file.string(), kind);
      for (const std::string& n : notices) fmt::print("note: {}\n", n);
    } catch (const ConfigError& e) {
      fmt::print(stderr, "{}\n", e.what());
      code = 2;
    } catch (const ResultsError& e) {
      fmt::print(stderr, "{}\n", printable(e.what()));
      code = 2;
    }
  }
  return code;
}

}  // namespace grouser::app
