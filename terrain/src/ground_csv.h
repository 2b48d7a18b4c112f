#pragma once
// Strict reader of a table of numbers; not installed.
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/terrain/csv.h"

namespace grouser::ground_detail {

struct CsvTable {
  std::vector<std::string> header;  ///< empty without a header row
  std::vector<int> header_columns;  ///< character column of each name
  int header_line = 0;
  int rows = 0, columns = 0;
  std::vector<double> cells;  ///< row-major
  std::vector<int> line;      ///< of each row
};

/// '#' lines and blank lines are skipped. @throws ConfigError with line and column: ragged rows, cells that are no
/// finite number, no rows.
CsvTable read_csv(const std::filesystem::path& file, bool with_header);

}  // namespace grouser::ground_detail
