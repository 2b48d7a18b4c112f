#pragma once
// Runs of grains that `sdem.v2` is fitted to: one wheel on a slab of grains (model dem.sphere, periodic across or between
// smooth walls), on stated ways.
//
// The wheel is lowered without spin; then it goes over `distance` with the rim slips s of `slips` in turn (equal shares of the way) at
//   max(|r w|, |vx|) = speed,   r w = vx/(1 - s) for s >= 0,   vx = r w (1 - s) for s < 0                      (N1)
// and its height is free under a load, mass m = load/g,                                                        `load`
//                  held, z = ground + r - depth - swing sin(2 pi x/length) - swing/2 sin(2 pi 2.7 x/length),    `depth`, `swing`
//                  or pressed without spin to each force of a list, let go to none of it in between.            `press`
// Kept: every `sample` the mean force and torque on the wheel, its place and velocity; every tenth sample the profile in columns:
// mean over the slab's width of the highest grain, on a raster of `column`.
// Every run is one file in a folder, named by the hash of its inputs.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/soil.h"

namespace grouser::sdem {

struct TrainingPlan {
  std::string title, source, wheel, soil_text;
  Soil soil;
  double radius = 0, width = 0;                                               ///< of the wheel [m]
  double slab = 0.06, depth = 0.08, relief = 0, reach = 0.04, period = 0.36;  ///< of dem.sphere [m]
  bool walls = false;                                                         ///< at the sides of the slab
  double speed = 0.06;                                                        ///< [m/s]
  double sample = 5e-3;                                                       ///< [s]
  double column = 2e-3;                                                       ///< [m]
};

struct TrainingRun {
  enum class Kind { load, held, press } kind = Kind::load;
  int seed = 1;
  double start = 0;                            ///< hub at the start [m]
  double load = 0;                             ///< [N]
  double depth = 0, swing = 0, length = 0.06;  ///< [m]
  std::vector<double> slips;                   ///< [1]
  std::vector<double> press;                   ///< [N]
  double distance = 0, rest = 0;               ///< way [m]; time at rest in the middle of the way [s]
  GroundPtr ground;
  std::string inputs, name;                     ///< everything it depends on, and its hash
  double seconds(const TrainingPlan& p) const;  ///< simulated, about
};

struct TrainingRecord {
  static constexpr int kColumns = 160;  ///< of a profile, the hub above the 60th
  static constexpr int kBehind = 60;
  std::vector<float> time, x, z, vx, vz, spin;  ///< end of the sample: hub [m], mean velocity over it [m/s], [rad/s]
  std::vector<float> fx, fz, torque;            ///< mean over the sample, soil on wheel [N], [N m] about the axle
  std::vector<float> free;                      ///< 1: the height is free
  std::vector<std::int64_t> profile_sample;     ///< sample after which the profile was taken
  std::vector<std::int64_t> profile_column;     ///< number of its first column; column k covers k c .. (k + 1) c
  std::vector<float> profile;                   ///< [m], profiles x kColumns, NaN where no soil was seen
  double processor = 0;                         ///< [s]
};

/// @throws ConfigError with every error. Keys: examples/17_surrogate_by_direction/README.md.
TrainingPlan load_training(const std::filesystem::path& file, std::vector<TrainingRun>& runs);
/// @throws TerrainError, dem::DemError.
TrainingRecord simulate(const TrainingPlan& p, const TrainingRun& r,
                        const std::function<void(double done)>& progress = {});
/// Written whole or not at all. @throws ResultsError.
void write_training(const TrainingRecord& record, const TrainingRun& r, const std::filesystem::path& file);
/// @throws ResultsError: missing, damaged, of other inputs.
TrainingRecord read_training(const TrainingRun& r, const std::filesystem::path& file);

}  // namespace grouser::sdem
