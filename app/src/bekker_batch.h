#pragma once
// Rows of a case file in blocks: checked, computed on several threads, written with their results.
#include <functional>
#include <span>

#include "bekker_cases.h"

namespace CLI {
class App;
}

namespace grouser::app {

struct BatchArguments {
  std::filesystem::path cases, out;
  int threads = 1;
  bool quiet = false;
};
/// --out, --threads, --quiet.
void add_batch_options(CLI::App* cmd, BatchArguments& a);

/// Rows begin..end of a case file. A block is always the same rows, whatever the threads.
struct BatchBlock {
  BatchBlock(const CaseFile& file, std::size_t b, std::size_t e) : begin(b), end(e), cases(file), errors(file.file()) {}
  std::size_t begin, end;
  const CaseFile& cases;
  FileErrors errors;
  bool check_only = true;
  std::string out;                    ///< results of the rows, one after the other
  std::vector<std::size_t> ends;      ///< of each row in `out`
  std::vector<std::string> statuses;  ///< of each row

  /// Append the next row's results: the values with 17 significant digits, or nan in their place, then the status.
  void add_row(std::span<const double> values, bool valid, std::string_view status);
  /// The same with the status of a force law; bad_argument becomes an error of the file.
  void add_row(std::initializer_list<double> values, bekker::ForceStatus status);
};

/// Runs `f` on every block, first with check_only, and writes each row of the file followed by its results under
/// `header`. Rows whose status is not ok are counted on stderr. A file that is wrong leaves no output.
/// @throws ConfigError with all errors of the file; ResultsError when the output cannot be written.
void run_batch(const BatchArguments& a, const CaseFile& cases, const std::string& header,
               const std::function<void(BatchBlock&)>& f);

/// grouser bekker table ...
void add_bekker_table_command(CLI::App& bekker, int& code);

}  // namespace grouser::app
