#pragma once
// Inclined plane that begins at a line.
#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

///   h = 0                                   s <= 0
///   h = tan(angle) s^2 / (2 transition)     0 < s < transition
///   h = tan(angle) (s - transition/2)       s >= transition
/// C1 with a transition, C0 with a crease at s = 0 without. Infinite extent. Cost: about 2 ns a point.
struct SlopeSettings {
  double angle = 0;       ///< [rad] -60..60 deg, positive = uphill along the heading
  double transition = 0;  ///< [m] >= 0
  GroundFrame frame;
};
/// @throws GroundError for settings outside these ranges.
GroundPtr slope_ground(const SlopeSettings& settings);

}  // namespace grouser
