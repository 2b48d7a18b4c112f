#pragma once
// Strict reader of a table of numbers; not installed.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "grouser/terrain/config.h"

namespace grouser::ground_detail {

/// Errors of one data file: kept until `limit`, then counted.
class FileErrors {
 public:
  explicit FileErrors(std::filesystem::path file) : file_(file.string()) {}
  void add(int line, int column, std::string message);
  bool any() const { return !errors_.empty(); }
  /// @throws ConfigError when there are any.
  void check() const;
  [[noreturn]] void fail(int line, int column, std::string message);

 private:
  std::string file_;
  std::vector<Diagnostic> errors_;
  std::size_t more_ = 0;
};

/// @throws ConfigError when the file cannot be read.
std::string read_text(const std::filesystem::path& file);

/// A finite number that fills `cell` (blanks around it allowed); otherwise nullopt.
std::optional<double> parse_number(std::string_view cell);

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
