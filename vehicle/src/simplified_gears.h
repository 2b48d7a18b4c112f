#pragma once
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/terrain.h"

namespace grouser::vehicle {

/// How a terrain simplifies the gears of its bodies: an assumption for each body, one line to print for all that are alike.
/// `file`: the file that names the bodies.
void tell_simplified_gears(const Terrain& terrain, const std::string& file, std::vector<Assumption>& assumptions,
                           std::vector<std::string>& notices);

}  // namespace grouser::vehicle
