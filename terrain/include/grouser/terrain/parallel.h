#pragma once
#include <functional>

namespace grouser {

/// Run f(0..n-1) on up to `threads` threads of a pool that lives as long as the process. Which thread runs an item is not fixed,
/// so f(i) must write only what belongs to i; then the result does not depend on `threads`. Exceptions: the one of the lowest
/// index is rethrown. threads <= 1 or n <= 1 runs in place.
void parallel_for(int n, int threads, const std::function<void(int)>& f);

}  // namespace grouser
