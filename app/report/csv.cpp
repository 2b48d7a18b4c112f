#include "csv.h"

#include <charconv>
#include <cmath>

namespace grouser::report {

CsvRecords read_table(const std::filesystem::path& file) {
  FileErrors errors(file);
  CsvRecords t = CsvRecords::read(file, errors);
  errors.check();
  return t;
}

nlohmann::json to_json(const CsvRecords& t) {
  nlohmann::json rows = nlohmann::json::array();
  for (const CsvRecords::Row& r : t.rows) {
    nlohmann::json row = nlohmann::json::array();
    for (const CsvCell& cell : r.cells) {
      const std::string& s = cell.text;
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
