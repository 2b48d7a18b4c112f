#pragma once
// Results of many cases in one CSV file: what is stored is not computed again, so that a study can be stopped and continued.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace family {

/// Column and value, in the order of the file.
using Cells = std::vector<std::pair<std::string, std::string>>;

std::string text(double v, int digits = 6);

/// 64-bit FNV-1a of everything a case depends on, as 16 hexadecimal digits.
std::string hash_of(const std::string& inputs);
/// Whole file, for the hash. @throws std::runtime_error when it cannot be read.
std::string content(const std::filesystem::path& file);

/// One CSV file: notes, header, one row per case with the hash of its inputs in the last column.
class Store {
 public:
  /// Reads what is there. `again`: forget the stored results.
  Store(std::filesystem::path file, std::vector<std::string> notes, bool again);
  /// The rows of case `key`: from the file when the hash is the same, else from `compute`, then written at once. `key` names the case
  /// in the progress line and is the first columns of its rows; the order of rows in the file is the order of the calls.
  std::vector<Cells> rows(const Cells& key, const std::string& hash,
                          const std::function<std::vector<Cells>()>& compute);
  /// Writes the file without cases that were not asked for this time.
  void finish() const;

 private:
  void write_all() const;
  std::filesystem::path file_;
  std::vector<std::string> notes_;
  std::multimap<std::string, Cells> stored_;  ///< by hash, as read
  std::vector<Cells> done_;
};

/// A CSV file without cases: written whole.
void write_csv(const std::filesystem::path& file, const std::vector<std::string>& notes,
               const std::vector<Cells>& rows);
/// Value of a column. @throws std::out_of_range
const std::string& cell(const Cells& row, const std::string& column);
double number(const Cells& row, const std::string& column);

}  // namespace family
