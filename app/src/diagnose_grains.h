#pragma once
// grouser diagnose with `model: dem.soil_tests`: which contact law made the curves of soil tests.
#include <filesystem>
#include <string>
#include <vector>

namespace grouser::app {

/// Writes diagnosis.json, report.html, curves.csv and extended_soil.yaml; 0. @throws ConfigError, ResultsError.
int run_grain_diagnosis(const std::filesystem::path& case_file, const std::filesystem::path& data,
                        std::filesystem::path out, const std::vector<std::string>& withhold, bool overwrite);

}  // namespace grouser::app
