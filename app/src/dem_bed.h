#pragma once
// Beds of grains from YAML.
#include <filesystem>
#include <functional>
#include <string>

#include "grouser/dem/packing.h"
#include "grouser/terrain/ground.h"

namespace grouser::app {

struct DemBedCase {
  std::string title;
  dem::SoilSettings soil;
  dem::PourSettings pouring;
  int nx = 1, ny = 1;
  GroundPtr surface;  ///< cut there; null: as poured
  double border = 0, bottom = 0, relax = 0;
  std::string inputs;  ///< every one, as text
};

/// bed: TITLE
/// soil: ..., solver: ...                                      see grouser/dem/soil_config.h
/// seed: 1
/// pour: {base: [50 mm, 50 mm], height: 160 mm, walls: false, slab: false, compaction: 5 kPa}      the last three optional
/// tiles: [8, 3]                                               optional
/// surface: {...}                                              optional: a ground (examples/grounds); grains above it are taken away
/// frozen: {border: 10 mm, bottom: 10 mm}                      optional
/// relax: 0.3 s                                                optional: come to rest after tiling and cutting, at most so long
/// @throws ConfigError with every error of the file.
DemBedCase read_dem_bed(const std::filesystem::path& file);

/// Pouring is saved in `checkpoint` every `every` seconds of the clock and continued from there.
dem::Packing make_bed(const DemBedCase& c, const std::filesystem::path& checkpoint, double every,
                      const std::function<void(const std::string& stage, double done)>& progress);

}  // namespace grouser::app
