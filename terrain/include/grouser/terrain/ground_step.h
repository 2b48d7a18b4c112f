#pragma once
// Kerb: a step up or down at a line.
#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

///   h = 0 (s <= 0),  height s/ramp (0 < s < ramp),  height (s >= ramp);   ramp = 0: h = 0 (s < 0), height (s >= 0)
/// C0 with a ramp. ramp = 0 is a vertical face, the only ground here that is not continuous; its normal is vertical on
/// both sides.
/// Infinite extent. Cost: about 2 ns a point.
struct StepSettings {
  double height = 0;  ///< [m] any, negative = down
  double ramp = 0;    ///< [m] 0 or >= 1 mm: length of the straight ramp
  GroundFrame frame;
};
/// @throws GroundError for settings outside these ranges.
GroundPtr step_ground(const StepSettings& settings);

}  // namespace grouser
