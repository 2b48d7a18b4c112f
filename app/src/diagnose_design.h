#pragma once
#include <filesystem>
#include <string>

namespace grouser::app {

/// `grouser diagnose --design`: design.json and report.html for a plan (a .csv file or the text of a grid).
void run_design(const std::filesystem::path& case_file, const std::string& plan, std::filesystem::path out,
                bool overwrite);

}  // namespace grouser::app
