#pragma once
#include "figure_page.h"
#include "grouser/diagnosis/fit_file.h"

namespace grouser::app {

/// Tables, data with the fitted law, residuals.
report::FigurePage fit_page(const diagnosis::FitReport& report);

}  // namespace grouser::app
