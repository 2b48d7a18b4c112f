#include "csv.h"

#include <charconv>
#include <cmath>
#include <fstream>

#include "grouser/terrain/csv.h"
#include "grouser/terrain/recorder.h"

namespace grouser::report {

Table read_table(const std::filesystem::path& file) {
  if (!std::ifstream(file)) throw ResultsError(file.string() + ": cannot be opened");
  const CsvFile csv = CsvFile::read(file);
  Table t;
  t.notes = csv.notes();
  std::vector<CsvCell> cells;
  for (const auto& [line, text] : csv.rows()) {
    CsvFile::split(text, cells);
    std::vector<std::string> row;
    for (CsvCell& c : cells) row.push_back(std::move(c.text));
    if (t.columns.empty()) {
      t.columns = std::move(row);
      continue;
    }
    if (row.size() != t.columns.size())
      throw ResultsError(file.string() + ":" + std::to_string(line) + ": " + std::to_string(row.size()) +
                         " cells where the header has " + std::to_string(t.columns.size()));
    t.rows.push_back(std::move(row));
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
