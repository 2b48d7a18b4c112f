#pragma once
// Fit of the law of `sdem.v2` (direction.h) to training runs (training.h): the law is driven over the ways of the runs, free in height
// where they were free, and its coefficients are those with the least sum of squares over windows of the way of
//   height, drawbar, torque (free) or ln of the vertical force, drawbar, torque (held), force (pressed), and the profile's mean behind and ahead
// each over the spread that packings show, plus the squares of what coefficients differ from their starts over their priors.
#include <functional>
#include <string>
#include <vector>

#include "grouser/sdem/direction.h"
#include "grouser/sdem/direction_wheel.h"
#include "grouser/sdem/training.h"

namespace grouser::sdem {

/// Means over a window of the way, of a run and of the law on it.
struct FitWindow {
  std::size_t run = 0;
  double x = 0, slip = 0;
  bool free = false;
  /// Grains, law: height of the lowest point over the ground [m], Fx [N], Fz [N], driving torque [N m], profile behind, ahead [m].
  std::array<double, 6> grains{}, law{};
  double b = 0, depth = 0, tilt = 0;  ///< of the law
  double deepest = 0;                 ///< of the law in it [m]
};

struct FitReport {
  std::vector<FitWindow> windows;
  double cost_before = 0, cost_after = 0;
  int evaluations = 0;
  /// Of the law's fluctuation over that of the grains: height, Fx, torque, Fz (not fitted); free runs.
  std::array<double, 4> sd_ratio{};
};

struct FitSettings {
  int evaluations = 1500;                        ///< 0: the coefficients stay, spread and fluctuation are set
  DirectionSettings wheel{0, 1, 0, true, true};  ///< of the law while it is fitted
};

/// Starts from `law` (radius, width, soil, wheel and coefficients set). records in the order of runs.
FitReport fit(const TrainingPlan& p, const std::vector<TrainingRun>& runs, const std::vector<TrainingRecord>& records,
              Direction& law, const FitSettings& settings = {}, const std::function<void(int, double)>& progress = {});

/// One run and the law on its way (free runs in height, held ones held), over the last share of the way.
struct Comparison {
  double slip = 0, load = 0, x_from = 0, x_to = 0;
  /// Height of the lowest point over the ground [m], Fx [N], driving torque [N m], Fz [N].
  std::array<double, 4> grains{}, grains_sd{}, law{}, law_sd{};
  double profile_rms = 0;  ///< change of the profile 40 mm and more behind the hub at the end [m]
  double outside = 0;      ///< share of steps
  double drift = 0;        ///< of the law's volume [m^2]
  double law_seconds = 0;  ///< processor
  double seconds = 0;      ///< simulated
};
Comparison compare(const TrainingPlan& p, const TrainingRun& r, const TrainingRecord& record, const Direction& law,
                   const DirectionSettings& settings, double share);

}  // namespace grouser::sdem
