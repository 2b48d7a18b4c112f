#pragma once
#include "grouser/diagnosis/diagnose.h"

namespace grouser::diagnosis {

/// What a person reads first: where the model is wrong and by how much, the cause (`cause`: a sentence), the errors as stated, refitted and
/// extended, what the refit moved, noise that had to grow, rows that contradict statics, the gain.
std::string told(const Diagnosis& d, const RunTable& data, const std::string& cause);

/// Whether the refit had anything to move, and moved it by more than a hundredth of its prior sd.
bool soil_moved(const Diagnosis& d);

/// "a, b or c"; numbers with three digits.
std::string list_of(const std::vector<std::string>& ids, const char* last = " or ");
std::string short_number(double x, int digits = 3);

}  // namespace grouser::diagnosis
