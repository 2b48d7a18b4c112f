#pragma once
// What is run: conditions, replicates, order, preparations.
#include <string>
#include <string_view>

#include "dice.h"
#include "wheel.h"

namespace blind {

/// slip: nine slips, one load and speed, 24 replicates. slip_load: 9 x 4, six replicates. full: 9 x 4 x 3 speeds x 2
/// passes.
/// constant_load and constant_speed are the two forms of the plan `confounded`. All have 216 runs.
enum class Plan { slip, slip_load, full, constant_load, constant_speed };

struct PlannedRun {
  Condition run;
  int order = 1, batch = 1, replicate = 1;
  bool withheld = false;  ///< a row of the block at 280 N
};

struct PlanOptions {
  int extra_replicates = 0;         ///< cells, drawn at random, that get two more runs
  bool shared_preparation = false;  ///< replicates of one cell lie in one batch
  bool sorted = false;              ///< order not randomised: by load, then speed
  bool withheld_block = false;      ///< 54 more rows at 280 N
  int only = 0;                     ///< > 0: keep so many runs
};

constexpr double kWithheldLoad = 280.0;

std::string_view name(Plan plan);

std::vector<PlannedRun> plan_runs(Plan plan, const PlanOptions& options, Dice& dice);

}  // namespace blind
