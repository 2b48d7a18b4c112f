#pragma once
// One run of the rig: soil, effects and condition in, the three channels out.
#include "arc_forces.h"
#include "effects.h"

namespace blind {

struct Soil {
  double k = 254.1e3, n = 1.387, c = 139.28, phi = 0.606, K = 0.5151e-3, a0 = 0.18, a1 = 0.32;
};

struct Wheel {
  double radius = 0.13, width = 0.16, density = 1600.0;
};

/// One condition. slip by the larger of r w and v; order_share 0 for the first run, 1 for the last.
struct Condition {
  double slip = 0, load = 115, omega = 0.3;
  int pass = 1;
  double order_share = 0;
  double ln_k_shift = 0, phi_shift = 0;  ///< preparation of this run
};

struct Channels {
  double drawbar = 0, torque = 0, sinkage = 0;
};

/// Numerics of the generator; cells > 0 is the coarse scheme of the benign mismatch.
struct Numerics {
  int cells = 0;
};

struct AtEntry {
  Channels y;
  double excess;  ///< normal force less the true load [N]
};

/// Channels and balance at a given entry angle.
AtEntry at_entry(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run, double entry,
                 Numerics numerics = {});

/// Entry angle that carries the load; TOMS 748 on the balance. Throws std::runtime_error where no angle below 1.45 rad
/// does.
double entry_angle(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run, double guess = 0.5,
                   Numerics numerics = {});

Channels simulate(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run,
                  Numerics numerics = {});

/// Travel speed over rim speed from the slip.
double speed_ratio(double slip);
double slip_of_ratio(double kappa);

}  // namespace blind
