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

/// A model with options and a wheel of examples/wheels.
struct Subject {
  const ModelInfo& model;
  std::string options;  ///< YAML, empty: defaults
  std::string wheel = "mit_wheel";
};
/// Run every case on Mojave Martian simulant (Table 4.1).
std::vector<Case> run_cases(const Subject& subject);

}  // namespace grouser::test
