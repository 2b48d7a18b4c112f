#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace grouser::report {

/// A small table with a header line. Cells stay text; lines that begin with # are notes.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> notes;
};

/// @throws ResultsError with file and line: cannot be opened, no header, a row with another number of cells.
Table read_table(const std::filesystem::path& file);
/// {columns: [...], rows: [[...]], notes: [...]}; a cell that is a finite number becomes one, an empty cell or nan
/// null.
nlohmann::json to_json(const Table& t);

}  // namespace grouser::report
