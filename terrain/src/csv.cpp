#include "grouser/terrain/csv.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "csv_rows.h"
#include "text_check.h"

namespace grouser {

namespace {
bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
}  // namespace

void refuse_other_separator(const std::filesystem::path& file, const CsvFile::Row& first) {
  const bool commas = first.text.find(',') != std::string_view::npos;
  bool quoted = false;
  for (std::size_t i = 0; i < first.text.size(); ++i) {
    const char c = first.text[i];
    if (c == '"') quoted = !quoted;
    if (quoted || (c != ';' && (c != '\t' || commas))) continue;
    throw ConfigError(file.string(), first.line, static_cast<int>(i) + 1,
                      std::string("the cells are separated by ") + (c == ';' ? "';'" : "tabs") +
                          "; separate them by commas, and write the decimal sign as a point");
  }
}

std::string_view trimmed_csv(std::string_view s) {
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

void refuse_unreadable(const std::filesystem::path& file) {
  const bool folder = std::filesystem::is_directory(file);
  throw ConfigError(file.string(), 0, 0,
                    folder ? "this is a folder; a file is wanted" : "cannot read the file; is it there, and readable?");
}

bool split_record(const CsvFile::Row& line, std::vector<std::string>& columns, std::vector<CsvCell>& cells,
                  FileErrors& errors) {
  const bool closed = CsvFile::split(line.text, cells);
  if (!closed) errors.add(line.line, cells.back().column, "the quoted cell is not closed");
  if (columns.empty()) {
    for (const CsvCell& c : cells) columns.push_back(c.text);
    return false;
  }
  if (cells.size() == columns.size()) return true;
  if (closed) {
    const bool few = cells.size() < columns.size();
    errors.add(line.line, few ? static_cast<int>(line.text.size()) : cells[columns.size()].column,
               std::to_string(cells.size()) + (cells.size() == 1 ? " cell" : " cells") + " where the header has " +
                   std::to_string(columns.size()) + "; separate cells by commas");
  }
  return false;
}

void add_empty_file(FileErrors& errors) {
  errors.add(1, 1, "the file is empty; a header line and rows, cells separated by commas, are wanted");
}

void FileErrors::add(int line, int column, std::string message) {
  constexpr std::size_t limit = 20;
  if (errors_.size() < limit)
    errors_.push_back({file_, line, column, std::move(message)});
  else
    ++more_;
}

void FileErrors::add(const FileErrors& more) {
  for (const Diagnostic& d : more.errors_) add(d.line, d.column, d.message);
  more_ += more.more_;
}

std::vector<Diagnostic> FileErrors::all() const {
  auto all = errors_;
  if (more_ > 0)
    all.push_back(
        {file_, all.back().line, all.back().column, "and " + std::to_string(more_) + " more errors in this file"});
  return all;
}

void FileErrors::check() const {
  if (!errors_.empty()) throw ConfigError(all());
}

void FileErrors::report_to(const ConfigNode& node) const {
  for (Diagnostic& d : all()) node.report(std::move(d));
}

void FileErrors::fail(int line, int column, std::string message) {
  add(line, column, std::move(message));
  check();
  std::abort();  // not reached: check() throws
}

std::string read_text_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  // An empty file is read well, but inserting nothing sets the failbit of `text`.
  if (in && in.peek() != std::ifstream::traits_type::eof()) text << in.rdbuf();
  if (std::filesystem::is_directory(file) || !(in || in.eof()) || !text) refuse_unreadable(file);
  if (const auto wrong = find_non_text(text.view(), "a text file", false))
    throw ConfigError(file.string(), wrong->line, wrong->column, wrong->message);
  return std::move(text).str();
}

std::optional<double> parse_number(std::string_view cell) {
  cell = trimmed_csv(cell);
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  double x = 0;
  const auto r = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (r.ec != std::errc() || r.ptr != cell.data() + cell.size() || !std::isfinite(x)) return std::nullopt;
  return x;
}

CsvFile CsvFile::read(const std::filesystem::path& file) {
  CsvFile f;
  f.file_ = file;
  f.text_ = std::make_shared<const std::string>(read_text_file(file));
  std::string_view rest = *f.text_;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  for (int number = 1; !rest.empty(); ++number) {
    const std::string_view line = take_line(rest), text = trimmed_csv(line);
    if (text.empty()) continue;
    if (text.front() == '#')
      f.notes_.emplace_back(trimmed_csv(text.substr(1)));
    else
      f.rows_.push_back({number, line});
  }
  if (!f.rows_.empty()) refuse_other_separator(file, f.rows_.front());
  return f;
}

bool CsvFile::split(std::string_view line, std::vector<CsvCell>& out) {
  std::size_t used = 0, at = 0;
  bool closed = true;
  for (;;) {
    while (at < line.size() && blank(line[at])) ++at;
    if (used == out.size()) out.emplace_back();
    CsvCell& cell = out[used++];
    cell.column = static_cast<int>(at) + 1;
    if (at < line.size() && line[at] == '"') {
      cell.text.clear();
      closed = false;
      for (++at; at < line.size(); ++at) {
        if (line[at] != '"') {
          cell.text += line[at];
        } else if (at + 1 < line.size() && line[at + 1] == '"') {
          cell.text += line[at++];
        } else {
          closed = true;
          ++at;
          break;
        }
      }
      const std::size_t comma = std::min(line.find(',', at), line.size());
      cell.text += trimmed_csv(line.substr(at, comma - at));
      at = comma;
    } else {
      const std::size_t comma = std::min(line.find(',', at), line.size());
      cell.text = trimmed_csv(line.substr(at, comma - at));
      at = comma;
    }
    if (!closed || at >= line.size()) break;
    ++at;
  }
  out.resize(used);
  return closed;
}

CsvRecords CsvRecords::read(const std::filesystem::path& file, FileErrors& errors) {
  CsvRecords t;
  t.file = file;
  CsvFile csv;
  try {
    csv = CsvFile::read(file);
  } catch (const ConfigError& e) {
    for (const Diagnostic& d : e.diagnostics()) errors.add(d.line, d.column, d.message);
    return t;
  }
  t.notes = csv.notes();
  std::vector<CsvCell> cells;
  for (const CsvFile::Row& r : csv.rows())
    if (split_record(r, t.columns, cells, errors)) t.rows.push_back({r.line, cells});
  if (t.columns.empty()) add_empty_file(errors);
  return t;
}

std::optional<std::size_t> CsvRecords::column(std::string_view name) const {
  const auto at = std::find(columns.begin(), columns.end(), name);
  return at == columns.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - columns.begin()));
}

std::string CsvRecords::unknown_column(std::string_view name) const {
  const auto near = did_you_mean(name, columns);
  std::string all;
  for (const std::string& c : columns) all += (all.empty() ? "" : ", ") + c;
  return "the table " + file.string() + " has no column '" + std::string(name) + "'" +
         (near ? "; did you mean '" + *near + "'?" : "; it has: " + all);
}

}  // namespace grouser
