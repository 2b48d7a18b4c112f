#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Every run with drawbar, torque and sinkage on a level bed. Errors by the delta method from the noise found.
std::vector<RowStatics> statics_of(const Search& s);

}  // namespace grouser::diagnosis
