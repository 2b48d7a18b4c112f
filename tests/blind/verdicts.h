#pragma once
// What the diagnosis said of one set, read from its diagnosis.json.
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace blind {

struct Said {
  bool present = false;
  std::string verdict;
  std::set<std::string> cause;  ///< ids; two for a pair written "a+b" or as a list
  std::vector<std::string> klass;
  std::string top;  ///< most probable single effect or pair, "none" and "unknown" left out
  std::map<std::string, nlohmann::json> parameters;
  std::set<std::string> variable, acts_through;
  std::optional<double> gain_ratio;
  nlohmann::json experiments = nlohmann::json::array();
  std::optional<double> rank_seconds, total_seconds, wall_seconds;
};

/// Ids of "a+b", "a + b", "a" or a list of them.
std::set<std::string> ids_of(const nlohmann::json& cause);

/// Throws std::runtime_error when the text is not JSON or `verdict` is not one of the six.
Said said_of(const nlohmann::json& diagnosis);

/// Reads folder/diagnosis.json and folder/run.json; `present` is false when the first is not there.
Said read_said(const std::string& folder);

}  // namespace blind
