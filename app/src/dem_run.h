#pragma once
// Runs a discrete-element case; a killed one continues from its checkpoint with the same bits.
#include <filesystem>
#include <functional>

#include "dem_case.h"
#include "grouser/dem/soil_test.h"

namespace grouser::app {

struct DemRunOptions {
  std::filesystem::path out;
  double checkpoint_every = 30;  ///< [s] of the clock
  std::function<void(double time, double total)> progress{};
};

struct DemRunResult {
  dem::Table forces, energy;  ///< one row per output; energy is empty unless asked for
  dem::Counters counters;
  double stable_step = 0;  ///< [s]
  double wall = 0;         ///< [s] of this start
  std::uint64_t hash = 0;
  std::string stopped;  ///< why the run ended early; what was reached is written all the same
};

/// Leaves forces.csv, energy.csv, grains.csv (final state, in the form of the input), contacts.csv, checkpoint.h5.
/// Takes the grains out of the case: the solver's own copy is enough.
/// @throws dem::DemError: the input cannot be run (GrainError: because of these grains). ResultsError: results cannot be
/// written.
DemRunResult run_dem(DemCase& c, const DemRunOptions& o);

}  // namespace grouser::app
