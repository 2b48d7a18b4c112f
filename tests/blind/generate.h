#pragma once
// Sets of the blind evaluation: what is hidden, the data with their noise, the files and the sealed answers.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plan.h"

namespace blind {

struct GenerateOptions {
  std::string plan = "full";  ///< slip | slip_load | full | confounded
  int sets = 20;
  std::string seed = "development";
  std::string out;      ///< folder of the sets
  std::string answers;  ///< file; default: <out>_answers/answers.json
  std::string family;   ///< only this family; default the mix of the plan
  bool with_oracle = true;
};

/// Families in the mix of a plan with their weights. Throws std::invalid_argument on an unknown plan.
std::vector<std::pair<std::string, int>> mix_of(const std::string& plan);

/// Family of each of n sets: exact shares (largest remainder), shuffled by the seed.
std::vector<std::string> families(const GenerateOptions& options);

struct MadeSet {
  std::string csv, case_yaml;
  nlohmann::json answer;
  std::vector<std::string> withhold;  ///< arguments for the engine
};

/// One set; the same text and index give the same bytes. Redraws what physics refuses; throws std::runtime_error after
/// 200 draws.
MadeSet make_set(const GenerateOptions& options, const std::string& family, int index);

/// All sets and the files: set_0001/{data.csv,case.yaml[,withhold.txt]}, manifest.json, answers; one thread a core,
/// progress on stderr.
void generate(const GenerateOptions& options);

}  // namespace blind
