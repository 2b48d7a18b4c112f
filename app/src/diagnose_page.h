#pragma once
#include "figure_page.h"
#include "grouser/diagnosis/diagnose.h"

namespace grouser::app {

/// The sentence, the data against both models, residual maps, the ranking, what would decide, soil against its priors, the gain.
report::FigurePage diagnose_page(const diagnosis::Diagnosis& d, const diagnosis::DiagnosisCase& c,
                                 const std::string& data);

}  // namespace grouser::app
