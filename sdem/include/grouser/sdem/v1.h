#pragma once
// Model `sdem.v1`: the published surrogate (dissertation chapter 5) as a terrain. Kept as it was, faults included: drawbar pull and torque are
// good, sinkage is not (README).
#include <string>

#include "grouser/terrain/registry.h"

namespace grouser::sdem {

/// Each wheel rolls in a vertical plane of its own over its own row of soil points (slice.h, V1 to V4); forces are those of the plane times
/// the wheel's width, there is no side force and nothing of the width is resolved.
///
/// Over the host's step dt, in n = ceil(dt/time_step) equal parts h:
///   soil points move while the wheel goes from begin to end;  then, where the host tells mass m and the other forces F of the hub,
///   v <- v + (F_z(z, v) + F) h/m,  v <- 0 where |v| <= dead_band |vx| (rounded: wheel),  z <- z + v h               (V5)
///   and the impulse is the one with which the host's next step ends where V5 ends: m ((z_n - z_0)/dt - v_host) - F dt.
/// V5 is explicit, as published: tables are steep in vz (W/(2.5 mm/s) or so), so the wheel chatters where it is not rounded.
/// Without a hub (wheel held in height) the impulse is F_z dt, the weight is unknown and soil moves while F_z > 0.
///
/// The integral gain of the published carrier (300 N/m) belongs to who holds the travel: locomotion.h; a rig or vehicle has its own.
/// Valid: within the tables' velocities and heights, the tables' radius and soil; otherwise TerrainError, or nearest values, counted and
/// shown by field `outside`, with the option. Refused by name: other radius, other grains, no tables. Smooth cylinders; others as the cylinder over them.
/// Not: side force, camber, rut of another wheel, soil on a slope flowing by itself, mass of the soil.
/// Ledger: dissipated = -(local pressure times rim velocity), external = work of the rounding and of V5's difference to F_z dt.
/// Cost: README. Example: examples/14_surrogate.
ModelInfo v1_model();

/// What tables say of their grains, from the section dem: of a soil: everything but seed, step and precision. Empty when there is no such section.
/// Errors of the section are noted in its document.
std::string soil_text(const ConfigNode& dem);

/// First line in which two such texts differ, "a | b"; empty when they agree.
std::string first_difference(const std::string& a, const std::string& b);

}  // namespace grouser::sdem
