// Which soil tables are of, as text.
#include "soil_text.h"

#include <sstream>

#include "grouser/dem/soil_config.h"

namespace grouser::sdem {

std::string soil_text(const dem::SoilSettings& soil) {
  std::istringstream lines(dem::inputs_text(soil));
  std::string all;
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(0, line.find(' '));
    if (name != "seed" && name != "time_step_s" && name != "precision") all += line + "\n";
  }
  return all;
}

std::string soil_text(const ConfigNode& dem) { return dem.present() ? soil_text(dem::read_soil(dem)) : std::string(); }

std::string first_difference(const std::string& a, const std::string& b) {
  std::istringstream left(a), right(b);
  for (std::string l, r;;) {
    const bool more_left = static_cast<bool>(std::getline(left, l)),
               more_right = static_cast<bool>(std::getline(right, r));
    if (!more_left && !more_right) return {};
    if (!more_left) l = "nothing";
    if (!more_right) r = "nothing";
    if (l != r) return l + " | " + r;
  }
}

}  // namespace grouser::sdem
