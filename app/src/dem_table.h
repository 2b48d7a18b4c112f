#pragma once
#include <string>

#include "grouser/dem/soil_test.h"

namespace grouser::app {

/// Header line and rows, nine digits.
std::string csv_text(const dem::Table& t);

}  // namespace grouser::app
