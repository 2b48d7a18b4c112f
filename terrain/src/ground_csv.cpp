#include "ground_csv.h"

#include <cmath>
#include <cstdio>

namespace grouser::ground_detail {

std::string out_of_range(std::string_view cell, double largest) {
  char bounds[64];
  std::snprintf(bounds, sizeof bounds, "%.6g to %.6g", -largest, largest);
  return "'" + std::string(cell.substr(0, 40)) + "' is out of range; allowed is " + bounds +
         ", look at the exponent and the unit";
}

CsvTable read_csv(const std::filesystem::path& file, bool with_header, double largest_first, double largest) {
  const CsvFile text = CsvFile::read(file);
  FileErrors errors(file);
  CsvTable t;
  std::vector<CsvCell> cells;
  bool header_wanted = with_header;
  for (const auto& [number, line] : text.rows()) {
    if (!CsvFile::split(line, cells)) errors.add(number, cells.back().column, "the quoted cell is not closed");
    const int n = static_cast<int>(cells.size());
    if (t.columns == 0) t.columns = n;
    if (header_wanted) {
      header_wanted = false;
      for (const CsvCell& c : cells) {
        t.header.push_back(c.text);
        t.header_columns.push_back(c.column);
      }
      t.header_line = number;
      if (parse_number(cells[0].text))
        errors.add(number, cells[0].column, "a header row with one name per column is expected before the numbers");
      continue;
    }
    ++t.rows;
    t.line.push_back(number);
    if (n != t.columns) {
      errors.add(number,
                 n < t.columns ? static_cast<int>(line.size()) : cells[static_cast<std::size_t>(t.columns)].column,
                 "row " + std::to_string(t.rows) + " has " + std::to_string(n) + (n == 1 ? " cell" : " cells") +
                     " where the " + (with_header ? "header" : "first row") + " has " + std::to_string(t.columns) +
                     "; separate cells by commas");
      continue;
    }
    for (int c = 0; c < n; ++c) {
      const auto k = static_cast<std::size_t>(c);
      const auto x = parse_number(cells[k].text);
      const auto where = [&] {
        return "row " + std::to_string(t.rows) + ", column " + std::to_string(c + 1) +
               (with_header ? " ('" + t.header[k] + "')" : "") + ": ";
      };
      const double most = c == 0 ? largest_first : largest;
      if (x && std::abs(*x) > most) errors.add(number, cells[k].column, where() + out_of_range(cells[k].text, most));
      if (!x)
        errors.add(number, cells[k].column,
                   where() +
                       (cells[k].text.empty() ? "the cell is empty"
                                              : "'" + cells[k].text.substr(0, 40) + "' is not a finite number") +
                       no_height_remedy);
      t.cells.push_back(x.value_or(0));
    }
  }
  errors.check();
  if (t.rows == 0) errors.fail(1, 1, "the file has no rows of numbers; one row per line, cells separated by commas");
  return t;
}

}  // namespace grouser::ground_detail
