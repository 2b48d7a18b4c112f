#pragma once
// What `grouser diagnose` leaves for simulations: the extended model as files that run.
#include <string>
#include <vector>

#include "grouser/diagnosis/diagnose.h"

namespace grouser::diagnosis {

struct ExtendedFile {
  std::string name, text;
};

/// The refitted soil and the effects found, for `grouser rig` and for vehicles:
///   extended.yaml          a rig file: the wheel again at the loads and slips of the runs that were fitted
///   extended_wheel.yaml    its wheel
///   extended_soil.yaml     its soil: `soil:` of any scenario
///   extended_effects.yaml  the amplitudes: `effects:` of any scenario; not there when no physics was added
///   extended_case.yaml     the same values as a case for `grouser diagnose`
/// Standard deviations and 90 % intervals stand beside the values as their source. What the rig's sensors were found to do (maps of the
/// measurement) is named in comments of extended.yaml only: no vehicle feels it.
/// Left out, and said in extended.yaml: locked runs, runs without travel (the rig needs a rolling wheel), other speeds than the median one.
std::vector<ExtendedFile> extended_files(const Diagnosis& d, const DiagnosisCase& c);

}  // namespace grouser::diagnosis
