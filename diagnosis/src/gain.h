#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Root mean square error, in noise sd, of the extended over the nominal model on runs that neither was fitted to; 95 % percentile
/// bootstrap over their conditions (repeats stay together), 2000 draws, fixed seed; none below five conditions. A run whose wheel a model
/// cannot carry is left out and told in `notes`; nothing where that leaves none.
std::optional<Gain> gain_on(const Search& s, const Candidate& extended, const Fit& fit, std::vector<Run> withheld,
                            const std::vector<std::string>& names, std::vector<std::string>& notes);

}  // namespace grouser::diagnosis
