#pragma once
// Strict reader of a table of numbers; not installed.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "grouser/terrain/csv.h"

namespace grouser::ground_detail {

/// What to do about a cell that is no number.
inline constexpr const char* no_height_remedy =
    "; fill it in from its neighbours, or cut the table there: heights are finite numbers";

inline constexpr double farthest = 1e6;  ///< [m] beyond it a height or a place is a wrong unit or exponent

/// Message for a cell beyond +-largest, in the cell's own unit.
std::string out_of_range(std::string_view cell, double largest);

struct CsvTable {
  std::vector<std::string> header;  ///< empty without a header row
  std::vector<int> header_columns;  ///< character column of each name
  int header_line = 0;
  int rows = 0, columns = 0;
  std::vector<double> cells;  ///< row-major
  std::vector<int> line;      ///< of each row
};

/// '#' lines and blank lines are skipped. @throws ConfigError with line and column: ragged rows, cells that are no
/// finite number or beyond +-largest_first (column 1) and +-largest (the others), no rows.
CsvTable read_csv(const std::filesystem::path& file, bool with_header, double largest_first, double largest);

}  // namespace grouser::ground_detail
