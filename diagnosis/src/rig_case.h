#pragma once
#include "grouser/diagnosis/runs.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/registry.h"

namespace grouser::diagnosis {

/// Key `rig`. Notes its errors in the node's document.
void read_rig(const ConfigNode& root, DiagnosisCase& c);
/// Makes the rolling model of a case without errors and leaves out what it has not or does not feel. Notes errors in
/// the node's document.
/// @throws ConfigError: the model refuses its options or the soil.
void use_rig(const ConfigNode& root, const ModelInfo& model, DiagnosisCase& c);

}  // namespace grouser::diagnosis
