#pragma once
// A reader of the report's data blocks written apart from the page's own (app/web/src/data.ts), from app/web/README.md.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grouser::test {

std::string read_text(const std::filesystem::path& file);
/// Content of the element <script ... id="ID">.
std::string script_content(const std::string& html, const std::string& id);
std::vector<unsigned char> unpack(const std::string& base64);
std::vector<double> decode(const std::vector<unsigned char>& block, const nlohmann::json& reference);

}  // namespace grouser::test
