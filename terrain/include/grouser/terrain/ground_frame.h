#pragma once
// Where a shape lies in the plane, and what happens beyond the end of measured data.
#include <stdexcept>
#include <string>

#include "grouser/terrain/types.h"

namespace grouser {

/// Settings that make no ground, or a query outside a ground whose setting is Outside::error. The message names both.
struct GroundError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Line coordinates of a shape: s along the heading from `start`, t to its left from `lateral`:
///   s = x cos(heading) + y sin(heading) - start,   t = -x sin(heading) + y cos(heading) - lateral.
struct GroundFrame {
  double heading = 0;  ///< [rad] -pi..pi, direction of s, from x towards y
  double start = 0;    ///< [m] any; distance of s = 0 from the world origin along the heading
  double lateral = 0;  ///< [m] any; distance of t = 0 from the world origin to the left
};

/// Beyond the data of a height map or profile.
enum class Outside {
  extend,  ///< the height of the edge continues (C0)
  mirror,  ///< the data run back and forth (C0)
  repeat,  ///< the data start again after a cross-fade (C0); profiles only
  error,   ///< GroundError that names the point and the extent
};

}  // namespace grouser
