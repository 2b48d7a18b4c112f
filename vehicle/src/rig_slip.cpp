#include "grouser/vehicle/rig_slip.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace grouser::vehicle {

std::string_view slip_definition_name(SlipDefinition d) { return d == SlipDefinition::rim ? "rim" : "symmetric"; }

double slip_of(SlipDefinition d, double radius, double w, double v) {
  const double rim = radius * w;
  if (rim == v) return 0;
  return (rim - v) / (d == SlipDefinition::rim ? rim : std::max(std::abs(rim), std::abs(v)));
}

double convert_slip(double slip, SlipDefinition from, SlipDefinition to) {
  if (from == to || slip >= 0) return slip;
  // Braking: r w / v = 1 + s (symmetric), v / (r w) = 1 - s (rim).
  return to == SlipDefinition::symmetric ? slip / (1 - slip) : slip / (1 + slip);
}

double travel_speed_for(SlipDefinition d, double radius, double slip, double w) {
  if (slip > 1) throw std::invalid_argument("no wheel has a slip above 1");
  if (slip >= 0 || d == SlipDefinition::rim) return radius * w * (1 - slip);
  if (slip <= -1)
    throw std::invalid_argument(
        "a turning wheel has no slip of -1 or below by the symmetric definition; allowed is above -1 and up to 1");
  return radius * w / (1 + slip);
}

double angular_speed_for(SlipDefinition d, double radius, double slip, double v) {
  if (slip >= 1) throw std::invalid_argument("a travelling wheel has no slip of 1 or above; allowed is below 1");
  if (slip >= 0 || d == SlipDefinition::rim) return v / (1 - slip) / radius;
  if (slip < -1)
    throw std::invalid_argument("the symmetric definition has no slip below -1; allowed is -1 and above, below 1");
  return v * (1 + slip) / radius;
}

}  // namespace grouser::vehicle
