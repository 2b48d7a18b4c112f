#pragma once
// Unit expressions: parsing and the words for their dimensions. Internal to the config reader.
#include <optional>
#include <string>
#include <string_view>

#include "grouser/terrain/config.h"

namespace grouser::units {

/// As grouser::parse_unit; without n an exponent that contains n is an error.
UnitScale parse(std::string_view unit, std::optional<double> n);

/// "pressure", "angular speed"; SI text such as "kg m^-2 s^-2" for what has no name.
std::string dimension_name(const UnitScale& u);

/// Short text of a number, six significant digits.
std::string number(double x);

}  // namespace grouser::units
