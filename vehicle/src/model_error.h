#pragma once
// What a model that was fitted to data says of its own error, from the fields that it reports.
#include <limits>
#include <string>

#include "grouser/terrain/terrain.h"

namespace grouser::vehicle {

/// Half widths of 90 % bars, 1.645 times the fields `drawbar_sd`, `torque_sd`, `sinkage_sd`; share of the wheels' steps in contact outside the
/// training, field `outside`. NaN where the model does not say.
struct ModelError {
  double drawbar_pull = std::numeric_limits<double>::quiet_NaN();    ///< [N]
  double driving_torque = std::numeric_limits<double>::quiet_NaN();  ///< [N m]
  double sinkage = std::numeric_limits<double>::quiet_NaN();         ///< [m]
  double outside = std::numeric_limits<double>::quiet_NaN();         ///< [1]
};
ModelError model_error(const Terrain& terrain);

/// What a reader of the results must know of it; empty: nothing.
std::string outside_warning(const Terrain& terrain);

}  // namespace grouser::vehicle
