#pragma once
// The brick that dem.sphere tiles the world with.
#include <filesystem>
#include <memory>

#include "grouser/dem/packing.h"

namespace grouser::dem {

/// A periodic packing of nx x ny bricks, each lx x ly: brick (i, j) of the world is that of (i mod nx, j mod ny). Between walls ny = 1.
struct SphereBrick {
  /// Grains of each brick at rest, none frozen, x in (0, lx), y in (0, ly); brick (a, b) is parts[a ny + b].
  std::vector<std::vector<GrainState>> parts;
  int nx = 1, ny = 1;
  double lx = 0, ly = 0, height = 0;
  double largest = 0;  ///< diameter [m]
  double top = 0;      ///< of the highest grain [m]
  /// Grains with their centres up to the cut plus this have their surface (mean of the highest tops) at the cut [m].
  double lift = 0;
  std::string hash;  ///< of how it was made
  const std::vector<GrainState>& of(std::int64_t i, std::int64_t j) const {
    return parts[static_cast<std::size_t>(((i % nx) + nx) % nx) * static_cast<std::size_t>(ny) +
                 static_cast<std::size_t>(((j % ny) + ny) % ny)];
  }
};

struct BrickSettings {
  double side = 0.06;     ///< [m] of a brick
  double across = 0;      ///< [m] of a brick along y; 0: square
  bool walls = false;     ///< poured between walls square to y, `across` apart; periodic along x only
  int nx = 1, ny = 1;     ///< bricks along x and y before the packing repeats
  double compaction = 0;  ///< [Pa] pressed by a lid and let go again
  double height = 0.1;    ///< [m] of soil wanted
  double level = 0.06;    ///< [m] where `lift` is measured
  std::filesystem::path
      bed;  ///< a periodic bed to use instead of pouring, cut into bricks of about `side`; empty: pour
  std::filesystem::path cache;  ///< folder of poured bricks
};

/// Poured as one packing and relaxed three times, or read from the cache or the bed. One per process and input.
/// @throws DemError: narrower than four of the largest grains (between walls: shorter), other sides than wanted, not as high.
std::shared_ptr<const SphereBrick> sphere_brick(const SoilSettings& soil, const BrickSettings& s);

}  // namespace grouser::dem
