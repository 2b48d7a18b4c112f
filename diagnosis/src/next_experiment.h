#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// What would tell the members of a class apart, best first: runs on soil (load x slip x speed x pass, or a wheel twice as wide; 4, 8 or 12 repeats) and
/// bench checks of sensor effects.
///   y | data, m ~ N(f_m, C/n + J_m V_m J_m'),   C of a run, V_m covariance of the fitted parameters of member m:
/// the second part is all that a refit of m to the new runs can still follow. With m true, y is drawn 400 times; m is decided when its
/// probability among all members is 10 times that of every other. `chance`: the least over the members, each taken as true.
/// The first choice, unless it needs another wheel, is simulated in full: parameters drawn from V_m, runs with noise, refits of every member to old and new runs.
/// cost: runs, 2 for each load or speed that the rig has not had yet, 6 for another wheel; a bench check counts as 1.
std::vector<NextExperiment> next_experiments(const Search& s, const std::vector<std::string>& members);

}  // namespace grouser::diagnosis
