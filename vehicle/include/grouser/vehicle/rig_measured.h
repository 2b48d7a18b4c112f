#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"

namespace grouser::vehicle {

/// One column of a measured table, SI.
struct RigMeasuredChannel {
  std::string name;           ///< drawbar_pull, driving_torque, side_force, normal_force, sinkage
  std::vector<double> value;  ///< [SI]
  std::vector<double> error;  ///< [SI] stated error of each value; empty = not stated
};

/// Steady values against slip from a CSV file.
struct RigMeasured {
  std::string file, source;
  std::vector<double> slip;  ///< [-] as the table states it
  std::vector<RigMeasuredChannel> channels;
};

/// `measured:` map: {file: x.csv, source: text, slip: column, drawbar_pull: {column: name, unit: N, error: column}, ...}.
/// Errors (no file, no such column, a cell that is no number, wrong unit) are noted in the node's document.
RigMeasured load_rig_measured(const ConfigNode& node);

/// Channels a measured table may have: name and SI unit.
struct RigChannel {
  const char *name, *unit, *csv_unit;
  double csv_scale;  ///< csv value = SI value * csv_scale
};
const std::vector<RigChannel>& rig_channels();

}  // namespace grouser::vehicle
