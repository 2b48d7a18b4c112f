#pragma once
// The brick that dem.sphere tiles the world with.
#include <filesystem>
#include <memory>

#include "grouser/dem/packing.h"

namespace grouser::dem {

struct SphereBrick {
  std::vector<GrainState> grains;  ///< at rest, none frozen, x in (0, lx), y in (0, ly)
  double lx = 0, ly = 0, height = 0;
  double largest = 0;  ///< diameter [m]
  double top = 0;      ///< of the highest grain [m]
  /// Grains with their centres up to the cut plus this have their surface (mean of the highest tops) at the cut [m].
  double lift = 0;
  std::string hash;  ///< of how it was made
};

struct BrickSettings {
  double side = 0.06;           ///< [m]
  double height = 0.1;          ///< [m] of soil wanted
  double level = 0.06;          ///< [m] where `lift` is measured
  std::filesystem::path bed;    ///< a periodic bed to use instead of pouring; empty: pour
  std::filesystem::path cache;  ///< folder of poured bricks
};

/// Poured and relaxed three times, or read from the cache or the bed. One per process and input.
/// @throws DemError: narrower than four of the largest grains, not periodic, not as high as wanted.
std::shared_ptr<const SphereBrick> sphere_brick(const SoilSettings& soil, const BrickSettings& s);

}  // namespace grouser::dem
