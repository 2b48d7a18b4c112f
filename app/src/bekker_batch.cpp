#include "bekker_batch.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>

#include "grouser/terrain/parallel.h"
#include "grouser/terrain/recorder.h"
#include "progress.h"
#include "whole_file.h"

namespace grouser::app {

namespace fs = std::filesystem;

void add_batch_options(CLI::App* cmd, BatchArguments& a) {
  cmd->add_option("--out", a.out, "CSV file for the rows with their results")->required();
  cmd->add_option("--threads", a.threads, "threads; the results do not depend on it")->check(CLI::Range(1, 1024));
  cmd->add_flag("--quiet", a.quiet, "no progress line");
}

void BatchBlock::add_row(std::span<const double> values, bool valid, std::string_view status) {
  for (const double x : values) {
    if (valid)
      fmt::format_to(std::back_inserter(out), "{:.17g},", x + 0.0);  // + 0.0: no -0
    else
      out += "nan,";
  }
  out += status;
  ends.push_back(out.size());
  statuses.emplace_back(status);
}

void BatchBlock::add_row(std::initializer_list<double> values, bekker::ForceStatus s) {
  if (s == bekker::ForceStatus::bad_argument)
    errors.add(cases.line(begin + ends.size()), 1, "the row is outside the range of the law");
  add_row(std::span<const double>(values.begin(), values.size()),
          s == bekker::ForceStatus::ok || s == bekker::ForceStatus::tolerance_not_met, bekker::name_of(s));
}

namespace {

constexpr std::size_t block_rows = 1024;  // fixed, so that the lanes of a batch hold the same rows for any threads

/// Statuses other than ok, with the number of rows and the first line.
void report_statuses(const CaseFile& cases, const std::vector<BatchBlock>& blocks) {
  std::map<std::string, std::pair<std::size_t, int>> kinds;
  for (const BatchBlock& b : blocks)
    for (std::size_t i = 0; i < b.statuses.size(); ++i)
      if (b.statuses[i] != "ok") {
        auto& [count, line] = kinds.try_emplace(b.statuses[i], 0, cases.line(b.begin + i)).first->second;
        ++count;
      }
  for (const auto& [status, place] : kinds)
    fmt::print(stderr, "{}: {} of {} rows: {} (the first in line {})\n", cases.file().string(), place.first,
               cases.size(), status, place.second);
}

void write_rows(const fs::path& file, const CaseFile& cases, const std::string& header,
                const std::vector<BatchBlock>& blocks) {
  WholeFile out(file);
  out.write(cases.header());
  out.write("," + header + "\n");
  for (const BatchBlock& b : blocks) {
    std::size_t from = 0;
    for (std::size_t i = b.begin; i < b.end; ++i) {
      const std::size_t to = b.ends[i - b.begin];
      out.write(cases.text(i));
      out.write(",");
      out.write(std::string_view(b.out).substr(from, to - from));
      out.write("\n");
      from = to;
    }
  }
  out.done();
}

}  // namespace

void run_batch(const BatchArguments& a, const CaseFile& cases, const std::string& header,
               const std::function<void(BatchBlock&)>& f) {
  std::error_code none;
  if (fs::equivalent(a.cases, a.out, none))
    throw ConfigError(a.out.string(), 0, 0, "--out would replace the file of cases; name another file");
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  std::vector<BatchBlock> blocks;
  for (std::size_t i = 0; i < cases.size(); i += block_rows)
    blocks.emplace_back(cases, i, std::min(i + block_rows, cases.size()));
  const auto all_blocks = [&](bool check_only) {
    ProgressLine line(a.quiet || check_only);
    const std::size_t group = 4 * static_cast<std::size_t>(a.threads);
    for (std::size_t i = 0; i < blocks.size(); i += group) {
      const std::size_t count = std::min(group, blocks.size() - i);
      parallel_for(static_cast<int>(count), a.threads, [&](int k) {
        blocks[i + static_cast<std::size_t>(k)].check_only = check_only;
        f(blocks[i + static_cast<std::size_t>(k)]);
      });
      if (seconds() > 1)
        line.update(a.cases.stem().string(), static_cast<double>(blocks[i + count - 1].end),
                    static_cast<double>(cases.size()), seconds(), "rows");
    }
  };
  const auto check = [&] {
    FileErrors all(cases.file());
    for (const BatchBlock& b : blocks) all.add(b.errors);
    all.check();
  };
  // All cells are checked before the first row is computed.
  all_blocks(true);
  check();
  all_blocks(false);
  check();
  report_statuses(cases, blocks);
  write_rows(a.out, cases, header, blocks);
  fmt::print("{}: {} rows in {:.2f} s\n", a.out.string(), cases.size(), seconds());
}

}  // namespace grouser::app
