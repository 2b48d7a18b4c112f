#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Root mean square error, in noise sd, of the extended over the nominal model on runs that neither was fitted to; 95 % percentile
/// bootstrap over their conditions (repeats stay together), 2000 draws, fixed seed.
std::optional<Gain> gain_on(const Search& s, const Candidate& extended, const Fit& fit,
                            const std::vector<Run>& withheld, const std::vector<std::string>& names);

}  // namespace grouser::diagnosis
