#pragma once
#include "time_model.h"

namespace grouser::diagnosis {

/// An account with its fit and how probable it is.
struct TimeRival {
  TimeAccount account;
  TimeFit fit;
  double posterior = 0;
};

/// Runs and bench checks that would tell the members apart, best first.
///   y | data, m ~ N(f_m, C + J_m V_m J_m')     of each member m on the new run                                  (T9)
///   chance = least over the members, each taken as true, of the share of 400 draws in which it gets ten times the odds of all others
/// Runs: one slip step there and back at other speeds, other sizes, rows closer together, longer; all of what the rig has done times a
/// stated factor. The first is simulated: 8 draws of rows, the members refitted to old and new rows together.
std::vector<NextExperiment> next_series(const TimeModel& m, const std::vector<TimeRival>& members);

}  // namespace grouser::diagnosis
