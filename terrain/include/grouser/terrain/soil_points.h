#pragma once
// Soil that is made of grains, as far as the 3-D view shows it. A terrain may be this too.
#include <array>
#include <vector>

namespace grouser {

struct SoilPoints {
  virtual ~SoilPoints() = default;
  /// Grains at and above the surface near the wheels, x, y, z, radius [m] in W; the nearest to the wheels when there are more than `most`.
  virtual std::vector<std::array<double, 4>> soil_points(std::size_t most) const = 0;
};

}  // namespace grouser
