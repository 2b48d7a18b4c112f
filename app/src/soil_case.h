#pragma once
// Cases of a soil test on grains, from YAML: variants x pressures x rates x packings.
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "grouser/dem/soil_test.h"
#include "grouser/terrain/config.h"

namespace grouser::app {

using SoilTestSettings = std::variant<dem::ShearSettings, dem::SinkageSettings, dem::ReposeSettings,
                                      dem::OedometerSettings, dem::TriaxialSettings>;

struct SoilCase {
  std::string name;   ///< file name of its results, without ending
  std::string group;  ///< cases that differ in their packing only
  std::string curve;  ///< of the group: "5330 Pa, 0.66 mm/s"
  std::string variant;
  std::size_t packing = 0;         ///< number among the seeds
  dem::SoilSettings soil, poured;  ///< while tested, while poured
  SoilTestSettings test;
  std::string inputs;  ///< every one, as text
  std::string hash;    ///< of the inputs
  dem::PourSettings pouring() const;
  std::unique_ptr<dem::SoilTest> make(const dem::Packing& bed) const;
};

/// Published curves to draw next to the results (Table 4.1).
struct SoilReference {
  std::string source;
  bool shear = false, sinkage = false;
  double c = 0, phi = 0, K = 0;       ///< tau = (c + sigma tan phi)(1 - exp(-j/K))
  double k = 0, n = 1, width = 0.05;  ///< sigma = k (z/b)^n
  double shear_stress(double sigma, double j) const;
  double pressure(double z) const;  ///< 0 above the surface
};

struct SoilFile {
  std::string title, kind;  ///< one of soil_test_kinds()
  std::filesystem::path file;
  std::vector<SoilCase> cases;  ///< first packing of every variant, then the second, ...
  SoilReference reference;
};

/// Several files, worked off packing by packing: campaign: TITLE, runs: [{test: direct-shear, file: a.yaml, later: 0}, ...].
/// The first packing of every file comes first, then the second; `later` moves a file back by so many.
struct SoilCampaign {
  struct Run {
    SoilFile file;
    std::size_t later = 0;
  };
  std::string title;
  std::vector<Run> runs;
};
SoilCampaign read_campaign(const std::filesystem::path& file);

/// soil_test: TITLE
/// soil: ..., solver: ...                       see grouser/dem/soil_config.h
/// seeds: [1, 2, 3]
/// direct_shear: {side, height, displacement, samples, pressures: [...], rates: [...]}       or
/// pressure_sinkage: {bin: [x, y], depth, plate: [x, y, z], rates, sinkage, brick, samples}       or
/// angle_of_repose: {base: [x, y], height, lift, duration, samples}       or
/// oedometer: {side, height, pressures: [...], hold, rest_speed}       or
/// triaxial: {side, height, pressures: [...], strain_rate, strain, wall_speed, rest, rest_speed, samples}
/// packing: {...}                               optional: the soil while it is poured, where it differs from `soil`
/// variants: [{name, soil: {...}, packing: {...}, solver: {...}, seeds: [...], direct_shear: {...}}]   optional: each changes what it
///                                              names
/// reference: {source, cohesion, friction_angle, K} or {source, k, n, width}                     optional
/// `change` is done to the soil of every variant before the packing's own keys are read.
/// @throws ConfigError with every error of the file.
SoilFile read_soil_file(const std::filesystem::path& file, const std::string& kind,
                        const std::function<void(dem::SoilSettings&)>& change = {});
/// The same for a file of any test.
void check_soil_file(const std::filesystem::path& file);
/// Names of the tests, as the commands are called.
const std::vector<std::string>& soil_test_kinds();

}  // namespace grouser::app
