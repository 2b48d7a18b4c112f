#pragma once
// The published validation run (dissertation 5.4): one wheel of constant spin, free in height, its travel held by an integral controller.
//
//   x'' = (F_x + F_c)/m,   F_c = gain * integral of (v - vx) dt,   v = (1 - s) r w   (rim slip, both signs)          (L1)
//   z'' = (F_z - W)/m,     vz <- 0 where |vz| <= dead_band |vx|                                                      (L2)
// explicit, `time_step` long, in the order: force, wheel, soil. Torque is that of the soil.
// A wheel set down at rest falls at 13.7 mm/s after two such steps, and the published tables end at 10 mm/s: by default velocities outside are
// taken as the nearest ones and counted. A wheel whose hub comes below the lowest height of the tables is not carried on: TerrainError.
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "grouser/sdem/slice.h"

namespace grouser::sdem {

struct LocomotionCase {
  LocomotionCase() { slice.nearest = true; }
  double slip = 0;             ///< (r w - v)/(r w) [-]
  double spin = 0.2967059728;  ///< 17 deg/s [rad/s]
  double mass = 0.55;          ///< [kg]
  double width = 0.03;         ///< [m]
  double gravity = 9.81;       ///< [m/s2]
  double gain = 300;           ///< [N/m]
  double time_step = 7e-4;     ///< [s]
  double distance = 0.69;      ///< of travel [m]
  double start = 0;            ///< lowest point of the rim above the soil at the start [m]; negative: in it
  bool round_wheel = true;     ///< L2; else only the tables see the rounded velocity
  double probe_vz = 0;  ///< a second look-up at this vertical velocity that moves nothing (fz_probe) [m/s]; 0: none
  SliceSettings slice;
  Slice::Profile profile = [](double) { return 0.0; };
  bool local_height =
      false;  ///< heights are counted from the profile under the hub less the bed's depth, not from a level floor
  /// Called in every step once its forces are known, before wheel and soil move.
  std::function<void(const struct LocomotionSample&, const Slice&)> watch;
};

struct LocomotionSample {
  double t, s, z, vx, vz, fx, fz, torque,
      sinkage;          ///< sinkage: undisturbed surface at s less the lowest point of the rim [m]
  double fz_probe = 0;  ///< upward force of the soil, were the vertical velocity `probe_vz` [N]
};

struct LocomotionRun {
  std::vector<LocomotionSample> samples;  ///< one a step
  std::int64_t outside = 0;               ///< times that a velocity or height lay outside the tables
  double seconds = 0;                     ///< of the processor
};

/// @throws TerrainError as Slice, and where the wheel sinks out of the tables; std::invalid_argument when slip >= 1 or a size is not positive.
LocomotionRun run_locomotion(std::shared_ptr<const Tables> tables, const LocomotionCase& c);

}  // namespace grouser::sdem
