#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Gain in ln likelihood over the nominal model on runs left out, summed over blocks and averaged over the variables load, slip and
/// angular speed: each level of a variable with three or more (more than six levels: six groups) is left out in turn, both
/// models are refitted to the rest, and the ln density that the refit foretells for the block, its own uncertainty included, is compared.
/// `starts`: fitted candidates; the first is the nominal one and gets 0. NaN: no variable has three levels.
struct Account {
  const Candidate* candidate;
  const Fit* fit;
};
std::vector<double> cross_validate(const Search& s, const std::vector<Account>& starts);

}  // namespace grouser::diagnosis
