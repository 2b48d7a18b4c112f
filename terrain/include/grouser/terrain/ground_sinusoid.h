#pragma once
// Sinusoidal profile (dissertation section 3.4, Table 3.6).
#include <limits>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

///   h = w(s) amplitude sin(wavenumber s + phase),   period = 2 pi / wavenumber
/// w rises from 0 to 1 over `run_in` as 3u^2 - 2u^3 and falls to 0 over the last `run_in` before `length`; outside [0,
/// length] h = 0 when the
/// shape is bounded there, else w = 1. With run_in the ground is C1; without it is C0, and settings that would jump at
/// a bound are refused.
/// The "frequency" 16.1-64.4 of Table 3.6 is a wavenumber in rad/m: periods 390, 195, 130, 97.5 mm.
/// Cost: one sine, 20-35 ns a point.
struct SinusoidSettings {
  double amplitude = 0;        ///< [m] >= 0
  double wavenumber = 0;       ///< [rad/m] > 0
  double phase = 0;            ///< [rad] at s = 0
  double run_in = 0;           ///< [m] >= 0
  bool bounded_start = false;  ///< flat before s = 0
  double length =
      std::numeric_limits<double>::infinity();  ///< [m] > 0; flat after s = length; needs run_in <= length / 2
  GroundFrame frame;
};
/// @throws GroundError for settings outside these ranges, or that jump at a bound.
GroundPtr sinusoid_ground(const SinusoidSettings& settings);

}  // namespace grouser
