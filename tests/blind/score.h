#pragma once
// The score table: every bar with its count, figure, 90 % interval and whether it is met.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "verdicts.h"

namespace blind {

struct Bar {
  std::string name;
  double low, high;  ///< wanted range of the figure: [0.98, 1] or [0, 0.01]
  int n = 0;
  double figure = 0, from = 0, to = 1;  ///< 90 % interval
  bool met() const { return n > 0 && from <= high && to >= low; }
};

struct Scored {
  nlohmann::json answer;
  Said said;
  std::string folder;  ///< of the sets
};

/// All bars of the evaluation from answers and what was said; the experiments are not simulated here (decides.h).
std::vector<Bar> bars(const std::vector<Scored>& sets);

/// Rates without a bar: what each family was called, oracle beside engine.
std::string details(const std::vector<Scored>& sets);

/// Checks the seal (manifest against answers), reads every result and returns the table as text; `json_file` not
/// empty: also written there. Several folders of sets in one table: lists with commas, in the same order.
/// Throws std::runtime_error when the answers are not those of the sets.
std::string score(const std::string& sets, const std::string& answers, const std::string& results,
                  const std::string& json_file);

}  // namespace blind
