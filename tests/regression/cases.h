#pragma once
#include <string>
#include <vector>

#include "grouser/terrain/registry.h"

namespace grouser::test {

struct Channel {
  std::string name, unit;
  double value = 0;
  double scale = 0;  ///< what the default tolerance is relative to, in `unit`
};
struct Case {
  std::string name, what;
  std::vector<Channel> channels;
};

/// Run every case with a model: smooth wheel of Table 4.5 (r 0.13 m, b 0.16 m) on Mojave Martian simulant (Table 4.1).
std::vector<Case> run_cases(const ModelInfo& model);

}  // namespace grouser::test
