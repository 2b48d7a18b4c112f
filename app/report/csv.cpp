#include "csv.h"

#include <charconv>
#include <cmath>
#include <fstream>

#include "grouser/terrain/recorder.h"

namespace grouser::report {

namespace {
std::string trimmed(const std::string& s) {
  const auto a = s.find_first_not_of(" \t\r"), b = s.find_last_not_of(" \t\r");
  return a == std::string::npos ? "" : s.substr(a, b - a + 1);
}

/// Commas split; a cell in double quotes may hold commas and doubled quotes.
std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      out.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += c;
  }
  for (std::string& s : out) s = trimmed(s);
  return out;
}
}  // namespace

Table read_table(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw ResultsError(file.string() + ": cannot be opened");
  Table t;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::string text = trimmed(line);
    if (text.empty()) continue;
    if (text[0] == '#') {
      t.notes.push_back(trimmed(text.substr(1)));
    } else if (t.columns.empty()) {
      t.columns = cells(text);
    } else {
      auto row = cells(text);
      if (row.size() != t.columns.size())
        throw ResultsError(file.string() + ":" + std::to_string(number) + ": " + std::to_string(row.size()) +
                           " cells where the header has " + std::to_string(t.columns.size()));
      t.rows.push_back(std::move(row));
    }
  }
  if (t.columns.empty()) throw ResultsError(file.string() + ": no header line");
  return t;
}

nlohmann::json to_json(const Table& t) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& r : t.rows) {
    nlohmann::json row = nlohmann::json::array();
    for (const std::string& s : r) {
      double v = 0;
      const auto [end, failed] = std::from_chars(s.data(), s.data() + s.size(), v);
      const bool number = failed == std::errc() && end == s.data() + s.size();
      if (number && std::isfinite(v))
        row.push_back(v);
      else if (number || s.empty())
        row.push_back(nullptr);
      else
        row.push_back(s);
    }
    rows.push_back(std::move(row));
  }
  return {{"columns", t.columns}, {"rows", std::move(rows)}, {"notes", t.notes}};
}

}  // namespace grouser::report
