#pragma once
// Tables as comma-separated text: each cell with its place in the file, so that every error can name line and column.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grouser/terrain/config.h"

namespace grouser {

/// Errors of one data file: kept until 20, then counted.
class FileErrors {
 public:
  explicit FileErrors(std::filesystem::path file) : file_(file.string()) {}
  void add(int line, int column, std::string message);
  void add(const FileErrors& more);
  bool any() const { return !errors_.empty(); }
  /// @throws ConfigError when there are any.
  void check() const;
  /// Hands them to the document of the node that names the file.
  void report_to(const ConfigNode& node) const;
  [[noreturn]] void fail(int line, int column, std::string message);

 private:
  std::vector<Diagnostic> all() const;
  std::string file_;
  std::vector<Diagnostic> errors_;
  std::size_t more_ = 0;
};

/// Whole file. @throws ConfigError when it cannot be read or is no text (a picture, an HDF5 file, control characters).
std::string read_text_file(const std::filesystem::path& file);

/// A finite number that fills `cell` (blanks around it and a leading + allowed); otherwise nullopt.
std::optional<double> parse_number(std::string_view cell);

/// One cell: without blanks around it; where it was in double quotes, without them and with "" as ".
struct CsvCell {
  std::string text;
  int column = 1;  ///< character in the line, from 1
};

/// A CSV file as text. Lines that begin with # are notes, blank lines are skipped. Rows may have any number of cells:
/// the caller, who knows what is wanted, checks.
class CsvFile {
 public:
  struct Row {
    int line;               ///< from 1
    std::string_view text;  ///< the line as it stands, without its end
  };
  /// @throws ConfigError when the file cannot be read, is no text, or its first line is separated by ';' or tabs.
  static CsvFile read(const std::filesystem::path& file);

  const std::filesystem::path& file() const { return file_; }
  const std::vector<Row>& rows() const { return rows_; }  ///< a header line, if the file has one, is the first
  const std::vector<std::string>& notes() const { return notes_; }
  /// Replaces `out` by the cells of a line. False: a quoted cell is not closed.
  static bool split(std::string_view line, std::vector<CsvCell>& out);

 private:
  std::filesystem::path file_;
  std::shared_ptr<const std::string> text_;
  std::vector<Row> rows_;
  std::vector<std::string> notes_;
};

/// A CSV file with one header line, every other row with as many cells.
struct CsvRecords {
  struct Row {
    int line;  ///< from 1
    std::vector<CsvCell> cells;
  };
  std::filesystem::path file;
  std::vector<std::string> columns, notes;
  std::vector<Row> rows;

  /// Never throws for bad content: no file, no header, a quoted cell that is not closed and rows of another length, which are left
  /// out, are added to `errors`.
  static CsvRecords read(const std::filesystem::path& file, FileErrors& errors);
  std::optional<std::size_t> column(std::string_view name) const;
  /// "the table t.csv has no column 'x'" with the nearest name, or all of them.
  std::string unknown_column(std::string_view name) const;
};

}  // namespace grouser
