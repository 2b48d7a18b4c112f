#pragma once
#include <string>

#include "grouser/terrain/registry.h"

namespace grouser::vehicle {

/// What is switched on in a terrain, for results and reports: "slip_sinkage_exponent 0.77, hard_pan 5 1/m"; empty when nothing is.
std::string switched_effects(const Terrain& terrain, const Registry& registry);

}  // namespace grouser::vehicle
