#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Runs on soil (load x slip x speed x pass, four repeats each) ranked by the worst separation of the first member from the others after their refit,
/// then bench checks of sensor effects. Separation at a condition: d^2 = delta' (C/4 + (J_A V_A J_A' + J_B V_B J_B')/2)^-1 delta with
/// delta the difference of the two fitted models, C the noise of a run, V the covariance of the fitted parameters;
/// chance that the odds pass 10: Phi(d/2 - ln 10/d).
std::vector<NextExperiment> next_experiments(const Search& s, const std::vector<std::string>& members);

}  // namespace grouser::diagnosis
