#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace grouser::app {

/// `grouser diagnose` of a case with the key `series`: diagnosis.json, report.html and series.csv.
void run_time_diagnosis(const std::filesystem::path& case_file, const std::filesystem::path& data,
                        const std::filesystem::path& out, const std::vector<std::string>& withhold);

}  // namespace grouser::app
