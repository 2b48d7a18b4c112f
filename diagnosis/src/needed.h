#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// The refit of the nominal model again with each soil value held at its prior mean, and with both of a0 and a1. Largest rise first.
/// Cost: a refit each.
std::vector<Needed> needed_by_refit(const Search& s);

/// Soil values of `judge:` under the priors.
std::vector<JudgedValue> judge_soil(const DiagnosisCase& c);

}  // namespace grouser::diagnosis
