#pragma once
// Text of the two files that the engine reads.
#include <string>

#include "plan.h"
#include "refit.h"

namespace blind {

/// How the slip column is written: by the larger of r w and v or by the rim, and with which radius.
struct ColumnStyle {
  bool rim = false;
  double slip_radius = 0.13;
};

/// The slip that the column shows for a true slip with the wheel's own radius.
double slip_in_column(double slip, const ColumnStyle& style, double radius);

std::string csv_text(const std::vector<PlannedRun>& runs, const std::vector<Eigen::Vector3d>& y,
                     const Eigen::Vector3d& stated_sd, const ColumnStyle& style, const Wheel& wheel);

std::string case_text(const Wheel& wheel, const Priors& priors);

}  // namespace blind
