#pragma once
#include "grouser/dem/packing.h"
#include "grouser/sdem/v1.h"

namespace grouser::sdem {

std::string soil_text(const dem::SoilSettings& soil);

}  // namespace grouser::sdem
