#include "ground_csv.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace grouser::ground_detail {

namespace {

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

/// Cells of one line with the character column (from 1) of each.
void split(std::string_view line, std::vector<std::string_view>& cells, std::vector<int>& columns) {
  cells.clear();
  columns.clear();
  std::size_t begin = 0;
  for (;;) {
    const std::size_t comma = line.find(',', begin);
    const std::string_view raw = line.substr(begin, comma == std::string_view::npos ? comma : comma - begin);
    const std::string_view cell = trimmed(raw);
    cells.push_back(cell);
    columns.push_back(
        static_cast<int>((cell.empty() ? begin : static_cast<std::size_t>(cell.data() - line.data())) + 1));
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

}  // namespace

void FileErrors::add(int line, int column, std::string message) {
  constexpr std::size_t limit = 20;
  if (errors_.size() < limit)
    errors_.push_back({file_, line, column, std::move(message)});
  else
    ++more_;
}

void FileErrors::check() const {
  if (errors_.empty()) return;
  auto all = errors_;
  if (more_ > 0)
    all.push_back(
        {file_, all.back().line, all.back().column, "and " + std::to_string(more_) + " more errors in this file"});
  throw ConfigError(std::move(all));
}

void FileErrors::fail(int line, int column, std::string message) {
  add(line, column, std::move(message));
  check();
  std::abort();  // not reached: check() throws
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in || !text) throw ConfigError(file.string(), 0, 0, "cannot read the file");
  return std::move(text).str();
}

std::optional<double> parse_number(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  double x = 0;
  const auto r = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (r.ec != std::errc() || r.ptr != cell.data() + cell.size() || !std::isfinite(x)) return std::nullopt;
  return x;
}

CsvTable read_csv(const std::filesystem::path& file, bool with_header) {
  const std::string text = read_text(file);
  FileErrors errors(file);
  CsvTable t;
  std::vector<std::string_view> cells;
  std::vector<int> columns;
  int number = 0;
  bool header_wanted = with_header;
  std::string_view rest = text;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++number;
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    split(line, cells, columns);
    const int n = static_cast<int>(cells.size());
    if (t.columns == 0) t.columns = n;
    if (header_wanted) {
      header_wanted = false;
      t.header.assign(cells.begin(), cells.end());
      t.header_columns = columns;
      t.header_line = number;
      if (parse_number(cells[0]))
        errors.add(number, columns[0], "a header row with one name per column is expected before the numbers");
      continue;
    }
    ++t.rows;
    t.line.push_back(number);
    if (n != t.columns) {
      errors.add(number, n < t.columns ? static_cast<int>(line.size()) : columns[static_cast<std::size_t>(t.columns)],
                 "row " + std::to_string(t.rows) + " has " + std::to_string(n) + (n == 1 ? " cell" : " cells") +
                     " where the " + (with_header ? "header" : "first row") + " has " + std::to_string(t.columns) +
                     "; separate cells by commas");
      continue;
    }
    for (int c = 0; c < n; ++c) {
      const auto k = static_cast<std::size_t>(c);
      const auto x = parse_number(cells[k]);
      if (!x)
        errors.add(number, columns[k],
                   "row " + std::to_string(t.rows) + ", column " + std::to_string(c + 1) +
                       (with_header ? " ('" + t.header[k] + "')" : "") + ": " +
                       (cells[k].empty() ? "the cell is empty"
                                         : "'" + std::string(cells[k].substr(0, 40)) + "' is not a finite number"));
      t.cells.push_back(x.value_or(0));
    }
  }
  errors.check();
  if (t.rows == 0) errors.fail(0, 0, "the file has no rows of numbers");
  return t;
}

}  // namespace grouser::ground_detail
