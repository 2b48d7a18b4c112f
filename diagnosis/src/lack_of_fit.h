#pragma once
#include "search.h"

namespace grouser::diagnosis {

/// Tests of what a fit leaves over, each p also after Holm (1979) over the family:
///   replicates   F of the cell means' whitened residuals against the scatter within cells (pure error); runs of one condition on
///                preparations of their own
///   structure    the largest score among all effects and drifts, times their number (Search::remainder)
///   runs         number of runs of equal sign along the order, each channel; normal approximation (Wald & Wolfowitz 1940)
///   Ljung-Box    correlation of whitened residuals along the order up to lag 5, each channel; chi2(5) (Ljung & Box 1978)
/// The last two need a column `order` or `time_s` and 20 runs.
std::vector<FitTest> lack_of_fit(const Search& s, const Fit& f, const Search::Remainder& structure, bool ordered);

/// Values of p after Holm's step-down.
void adjust_holm(std::vector<FitTest>& tests);

/// z of the number of runs of equal sign, and Ljung-Box Q with `lags` lags.
double runs_z(const std::vector<double>& residuals);
double ljung_box(const std::vector<double>& residuals, int lags);

}  // namespace grouser::diagnosis
