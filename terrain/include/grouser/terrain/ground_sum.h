#pragma once
// Sum of grounds.
#include <vector>

#include "grouser/terrain/ground.h"

namespace grouser {

/// h = sum of the parts, in their order; the gradient behind normal() is the sum of theirs. @throws GroundError when
/// empty.
GroundPtr sum_ground(std::vector<GroundPtr> parts);

}  // namespace grouser
