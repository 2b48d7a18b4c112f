#pragma once
// Tables of millions of rows: a row at a time, so that memory does not grow with the file.
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grouser/terrain/csv.h"

namespace grouser {

/// A CSV file with one header line, as CsvRecords and with the same errors, but only the row asked for is in memory.
/// Bytes that are no text are found out when their line is read.
class CsvStream {
 public:
  /// Reads the header line. Never throws for bad content: that is added to `errors`, which must outlive the stream.
  CsvStream(const std::filesystem::path& file, FileErrors& errors);

  const std::vector<std::string>& columns() const { return columns_; }  ///< none: no header could be read
  std::optional<std::size_t> column(std::string_view name) const;
  /// Next row with as many cells as the header; others are added to the errors and left out. False at the end of the
  /// file, and where it is no text any more.
  bool next(CsvRecords::Row& row);

 private:
  bool next_line(CsvFile::Row& row);

  std::filesystem::path file_;
  FileErrors& errors_;
  std::ifstream in_;
  std::string line_, text_;  ///< as read; behind a line end
  int number_ = 0;           ///< of the line
  std::vector<std::string> columns_;
};

}  // namespace grouser
