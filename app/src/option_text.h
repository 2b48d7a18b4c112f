#pragma once
#include <string>
#include <vector>

#include "grouser/terrain/config.h"

namespace grouser::app {

/// A quantity typed on the command line, in SI. @throws ConfigError that names the option, not a place in a file.
double option_quantity(const std::string& option, const std::string& text, std::string_view unit, Range range);
/// The same for a list; percentages are allowed where the unit is "1".
std::vector<double> option_quantities(const std::string& option, const std::vector<std::string>& words,
                                      std::string_view unit, Range range);

}  // namespace grouser::app
