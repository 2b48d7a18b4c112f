#pragma once
// Model `sdem.v2`: the surrogate of grains by direction of motion (direction.h), as a terrain.
#include "grouser/terrain/registry.h"

namespace grouser::sdem {

/// Each wheel rolls in a vertical plane of its own over its own row of columns (rut.h); forces are those of the plane times the wheel's
/// width over that of the training. Direction and memory: D1 to D6; volume of soil: R1.
///
/// Valid: smooth wheels of the law's radius in its soil (otherwise refused by name), directions and depths like those of the
/// training; a state outside (Mahalanobis distance over outside_limit) is counted: field `outside`, per cent of a wheel's steps.
/// Error bars: fields `drawbar_sd`, `torque_sd`, `sinkage_sd`: what packings differ by, of means over 0.1 m.
/// Not: side force in the law itself (options side_friction, side_turn: Coulomb's, fitted apart), camber, rut of another wheel, speed (the law has none;
/// soils whose forces depend on it, as eq 3.20, need its logarithm as an input).
/// Ledger: stored = N^2/(2 k), dissipated = lasting depth, slip; each by its own formula.
/// Cost: README. Example: examples/17_surrogate_by_direction.
ModelInfo v2_model();

}  // namespace grouser::sdem
