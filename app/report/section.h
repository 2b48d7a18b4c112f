#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "pack.h"

namespace grouser::report {

/// What the page knows of one run folder: texts, summary numbers, statistics, spectrum and references into `pack`.
/// @throws ResultsError
nlohmann::json run_section(const std::filesystem::path& folder, Pack& pack);
/// The same of a rig folder: sweep, errors and measured tables, and a run section per case.
nlohmann::json rig_section(const std::filesystem::path& folder, Pack& pack);

/// Name of the folder for a person, also of "." and "runs/x/".
std::string folder_name(const std::filesystem::path& folder);

}  // namespace grouser::report
