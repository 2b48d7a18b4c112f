#pragma once
#include <string_view>

namespace grouser::vehicle {

/// How a data set or scenario defines slip. w [rad/s] spin, v [m/s] travel along x, r [m] the radius it uses.
///   symmetric: s = (r w - v) / max(|r w|, |v|)        -1 (locked) .. 1 (spinning on the spot); Wong 2010, dissertation eq 2.2
///   rim:       s = (r w - v) / (r w)                  -infinity .. 1; dissertation eq 3.8, its chapters 3-5
/// They agree for driving; a braking slip s_rim < 0 is s_symmetric = s_rim / (1 - s_rim).
enum class SlipDefinition { symmetric, rim };

std::string_view slip_definition_name(SlipDefinition d);

/// Slip of a motion. 0 where w = v = 0; rim: -infinity (v > 0) or +infinity (v < 0) where w = 0.
double slip_of(SlipDefinition d, double radius, double angular_speed, double travel_speed);

/// Slip by the other definition, same radius, rolling forward.
double convert_slip(double slip, SlipDefinition from, SlipDefinition to);

/// v [m/s] that gives this slip at spin w [rad/s]. @throws std::invalid_argument: no such speed (symmetric slip -1, beyond +-1; rim > 1).
double travel_speed_for(SlipDefinition d, double radius, double slip, double angular_speed);
/// w [rad/s] that gives this slip at travel speed v [m/s]. @throws std::invalid_argument: no such spin (slip 1, beyond the range).
double angular_speed_for(SlipDefinition d, double radius, double slip, double travel_speed);

}  // namespace grouser::vehicle
