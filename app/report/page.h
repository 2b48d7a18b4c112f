#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace grouser::report {

/// The page's script and style sheet as built from app/web.
std::string_view page_script();
std::string_view page_style();

/// One HTML file: header and data blocks (app/web/README.md) with script and style inside.
/// @throws ResultsError: the file cannot be written
void write_page(const std::filesystem::path& html, const std::string& title, const nlohmann::json& header,
                const std::vector<std::string>& blocks);

}  // namespace grouser::report
