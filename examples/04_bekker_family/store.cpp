#include "store.h"

#include <fmt/core.h>

#include <chrono>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

#include "grouser/terrain/csv.h"

namespace family {

namespace {
constexpr const char* hash_column = "inputs_hash";

std::string key_text(const Cells& key) {
  std::string out;
  for (const auto& [name, value] : key) out += (out.empty() ? "" : ", ") + name + " " + value;
  return out;
}
/// A cell as it stands in the file.
std::string quoted(const std::string& cell) { return cell.find(',') == std::string::npos ? cell : '"' + cell + '"'; }
}  // namespace

std::string text(double v, int digits) { return fmt::format("{:.{}g}", v, digits); }

std::string hash_of(const std::string& inputs) {
  std::uint64_t h = 14695981039346656037ull;
  for (const unsigned char c : inputs) h = (h ^ c) * 1099511628211ull;
  return fmt::format("{:016x}", h);
}

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

const std::string& cell(const Cells& row, const std::string& column) {
  for (const auto& [name, value] : row)
    if (name == column) return value;
  throw std::out_of_range("no column " + column);
}

double number(const Cells& row, const std::string& column) {
  return grouser::parse_number(cell(row, column)).value_or(std::numeric_limits<double>::quiet_NaN());
}

Store::Store(std::filesystem::path file, std::vector<std::string> notes, bool again)
    : file_(std::move(file)), notes_(std::move(notes)) {
  if (again || !std::filesystem::exists(file_)) return;
  const auto csv = grouser::CsvFile::read(file_);
  std::vector<grouser::CsvCell> header, cells;
  for (const auto& row : csv.rows()) {
    grouser::CsvFile::split(row.text, header.empty() ? header : cells);
    if (cells.empty()) continue;
    if (cells.size() != header.size())
      throw std::runtime_error(fmt::format("{}:{}: not as many cells as the header", file_.string(), row.line));
    Cells c;
    for (std::size_t k = 0; k < cells.size(); ++k) c.emplace_back(header[k].text, cells[k].text);
    std::string hash = cell(c, hash_column);
    stored_.emplace(std::move(hash), std::move(c));
  }
}

std::vector<Cells> Store::rows(const Cells& key, const std::string& hash,
                               const std::function<std::vector<Cells>()>& compute) {
  std::vector<Cells> out;
  const auto [from, to] = stored_.equal_range(hash);
  for (auto it = from; it != to; ++it) out.push_back(it->second);
  if (!out.empty()) {
    done_.insert(done_.end(), out.begin(), out.end());
    return out;
  }
  const auto begin = std::chrono::steady_clock::now();
  fmt::print("{}: {} ...", file_.filename().string(), key_text(key));
  std::fflush(stdout);
  for (Cells& values : compute()) {
    Cells row = key;
    row.insert(row.end(), values.begin(), values.end());
    row.emplace_back(hash_column, hash);
    out.push_back(std::move(row));
  }
  fmt::print(" {:.1f} s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  done_.insert(done_.end(), out.begin(), out.end());
  write_all();
  return out;
}

void Store::write_all() const {
  // What was stored and not yet asked for stays until finish(), so that a stopped study loses nothing.
  std::set<std::string> asked;
  for (const Cells& r : done_) asked.insert(cell(r, hash_column));
  std::vector<Cells> all = done_;
  for (const auto& [hash, row] : stored_)
    if (!asked.contains(hash)) all.push_back(row);
  write_csv(file_, notes_, all);
}

void Store::finish() const { write_csv(file_, notes_, done_); }

void write_csv(const std::filesystem::path& file, const std::vector<std::string>& notes,
               const std::vector<Cells>& rows) {
  const auto part = std::filesystem::path(file).concat(".part");
  {
    std::ofstream out(part);
    for (const std::string& n : notes) out << "# " << n << '\n';
    std::vector<std::string> columns;
    if (!rows.empty())
      for (const auto& c : rows.front()) columns.push_back(c.first);
    for (std::size_t k = 0; k < columns.size(); ++k) out << (k ? "," : "") << columns[k];
    out << '\n';
    for (const Cells& r : rows) {
      for (std::size_t k = 0; k < columns.size(); ++k) out << (k ? "," : "") << quoted(cell(r, columns[k]));
      out << '\n';
    }
    if (!out.flush()) throw std::runtime_error(part.string() + ": cannot be written");
  }
  std::filesystem::rename(part, file);
}

}  // namespace family
