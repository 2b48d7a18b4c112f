#pragma once
#include <nlohmann/json.hpp>

#include "grouser/diagnosis/diagnose.h"

namespace grouser::app {

/// diagnosis.json.
nlohmann::ordered_json diagnosis_json(const diagnosis::Diagnosis& d);

}  // namespace grouser::app
