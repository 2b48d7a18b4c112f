#include "grouser/terrain/csv_stream.h"

#include <algorithm>

#include "csv_rows.h"
#include "text_check.h"

namespace grouser {

CsvStream::CsvStream(const std::filesystem::path& file, FileErrors& errors)
    : file_(file), errors_(errors), in_(file, std::ios::binary) {
  try {
    if (std::filesystem::is_directory(file) || !in_) refuse_unreadable(file);
    CsvFile::Row head;
    std::vector<CsvCell> cells;
    if (!next_line(head)) {
      if (in_.eof()) add_empty_file(errors_);
      return;
    }
    refuse_other_separator(file, head);
    split_record(head, columns_, cells, errors_);
  } catch (const ConfigError& e) {
    for (const Diagnostic& d : e.diagnostics()) errors_.add(d.line, d.column, d.message);
  }
}

bool CsvStream::next_line(CsvFile::Row& row) {
  while (std::getline(in_, line_)) {
    ++number_;
    // Behind a line end, so that a line that begins like a picture is not taken for one.
    text_.assign("\n").append(line_);
    std::string_view text = std::string_view(text_).substr(1);
    if (const auto wrong = find_non_text(number_ == 1 ? text : text_, "a text file", false)) {
      errors_.add(number_, wrong->column, wrong->message);
      in_.clear(std::ios::failbit);  // no end of the file: nothing more is said of it
      return false;
    }
    if (number_ == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    row = {number_, take_line(text)};
    const std::string_view content = trimmed_csv(row.text);
    if (!content.empty() && content.front() != '#') return true;
  }
  if (in_.bad()) errors_.add(0, 0, "the file cannot be read to its end");
  return false;
}

std::optional<std::size_t> CsvStream::column(std::string_view name) const {
  const auto at = std::find(columns_.begin(), columns_.end(), name);
  return at == columns_.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - columns_.begin()));
}

bool CsvStream::next(CsvRecords::Row& row) {
  CsvFile::Row line;
  while (!columns_.empty() && next_line(line)) {
    row.line = line.line;
    if (split_record(line, columns_, row.cells, errors_)) return true;
  }
  return false;
}

}  // namespace grouser
