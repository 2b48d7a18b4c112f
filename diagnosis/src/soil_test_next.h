#pragma once
#include "soil_test_fit.h"

namespace grouser::diagnosis {

struct SoilTestMember {
  const SoilTestAccount* account;
  const SoilTestPosterior* posterior;
  double ln_prior;
};

/// What would tell the members apart, best first: shear tests (normal stress x speed; the rest follows the speed, so
/// that soil creeps as far) or plates at another speed, 2, 4 or 8 repeats. Of each member y ~ N(mean, covariance) over
/// its posterior draws, error of the emulator and scatter of the repeats added (D15); `chance` by chance_to_decide. The
/// cheapest that reaches 0.9 comes first, else the surest. cost: repeats, and 2 for each level that the data have not.
/// Tests outside the stored runs for more than a twentieth of a member's draws are not offered.
std::vector<NextExperiment> next_soil_tests(const SoilTestFits& fits, const std::vector<SoilTestMember>& members);

}  // namespace grouser::diagnosis
