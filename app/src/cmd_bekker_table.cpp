// grouser bekker table build, info, query.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "bekker_batch.h"
#include "grouser/bekker/table.h"
#include "grouser/terrain/file_target.h"
#include "grouser/terrain/recorder.h"
#include "progress.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

void print_table(const bekker::WheelTable& t) {
  const bekker::TableSpec& s = t.spec();
  fmt::print("{}\n", s.title);
  fmt::print("wheel: radius {:.6g} mm, width {:.6g} mm, lugs {:.6g} mm\n", 1e3 * s.wheel.radius, 1e3 * s.wheel.width,
             1e3 * s.wheel.lug_height);
  fmt::print("slip {:.6g}..{:.6g}, load {:.6g}..{:.6g} N, unloading sinkage {:.6g}..{:.6g} mm\n", s.slip.lower,
             s.slip.upper, s.load.lower, s.load.upper, 1e3 * s.unloading_sinkage.lower,
             1e3 * s.unloading_sinkage.upper);
  fmt::print("error bound {:.3g}, largest found at points between the grid's {:.3g}\n", s.error_bound, t.error_found());
  fmt::print("{} grid points: {}\n", t.points(), t.grid_text());
  fmt::print("hash {}\n", t.hash_text());
}

void build(const fs::path& spec_file, const fs::path& out, int threads, bool quiet) {
  const bekker::TableSpec spec = bekker::load_table_spec(spec_file);
  if (file_target(out).stream)  // said before the work, not after it
    throw ResultsError(out.string() + ": is a device or a pipe; HDF5 needs a file of its own");
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  std::unique_ptr<ProgressLine> line = std::make_unique<ProgressLine>(quiet);
  std::size_t before = 0;
  double pass_start = 0, last = 0;
  const auto progress = [&](const bekker::WheelTable::Progress& p) {
    // The time left is that of the pass: how many passes follow is not known.
    if (p.done <= before) {
      pass_start = last;
      line = std::make_unique<ProgressLine>(quiet);
    }
    before = p.done;
    last = seconds();
    if (p.done < p.total)
      line->update(fmt::format("{}: {}", spec_file.stem().string(), p.part), static_cast<double>(p.done),
                   static_cast<double>(p.total), last - pass_start, "points");
  };
  try {
    const bekker::WheelTable t = bekker::WheelTable::build(spec, threads, progress);
    line.reset();
    t.write(out, GROUSER_VERSION);
    print_table(t);
    fmt::print("{}: built in {:.1f} s, {:.1f} MB\n", out.string(), seconds(),
               1e-6 * static_cast<double>(fs::file_size(out)));
  } catch (const bekker::TableError& e) {
    throw ConfigError(spec_file.string(), 0, 0, e.what());
  }
}

void query(const fs::path& file, const BatchArguments& a) {
  const bekker::WheelTable t = bekker::WheelTable::read(file);
  const CaseFile cases(a.cases, {CaseColumn::slip, CaseColumn::load_N}, {CaseColumn::zu_m},
                       {"theta_f_rad", "thrust_N", "resistance_N", "drawbar_N", "torque_Nm", "sinkage_m",
                        "unloading_sinkage_m", "status"});
  run_batch(a, cases, "theta_f_rad,thrust_N,resistance_N,drawbar_N,torque_Nm,sinkage_m,unloading_sinkage_m,status",
            [&](BatchBlock& block) {
              for (std::size_t i = block.begin; i < block.end; ++i) {
                CaseFile::Row row(cases, i, block.errors);
                const double slip = row.number(CaseColumn::slip), load = row.number(CaseColumn::load_N);
                const double zu = row.number_or(CaseColumn::zu_m, 0);
                if (block.check_only) continue;
                bekker::TablePoint p;
                const bekker::TableStatus status = t.query(slip, load, zu, p);
                const std::array values{p.entry_angle, p.thrust,  p.resistance,       p.drawbar(),
                                        p.torque,      p.sinkage, p.unloading_sinkage};
                block.add_row(values, status == bekker::TableStatus::ok, bekker::name_of(status));
              }
            });
}

}  // namespace

void add_bekker_table_command(CLI::App& bekker, int& code) {
  struct Arguments {
    fs::path in, out;
    BatchArguments batch;
    int threads = 1;
    bool quiet = false;
  };
  auto* table = bekker.add_subcommand("table", "lookup table of one wheel on one soil");
  table->require_subcommand(1);
  const auto b = std::make_shared<Arguments>(), i = std::make_shared<Arguments>(), q = std::make_shared<Arguments>();
  auto* build_cmd = table->add_subcommand("build", "build a table; its grids are refined until the error bound is met");
  build_cmd->add_option("spec", b->in, "TABLE.yaml: wheel, soil, ranges, error bound")->required();
  build_cmd->add_option("--out", b->out, "HDF5 file")->required();
  build_cmd->add_option("--threads", b->threads, "threads; the table does not depend on it")
      ->check(CLI::Range(1, 1024));
  build_cmd->add_flag("--quiet", b->quiet, "no progress line");
  build_cmd->callback([b, &code] {
    build(b->in, b->out, b->threads, b->quiet);
    code = 0;
  });
  auto* info_cmd = table->add_subcommand("info", "what a table holds");
  info_cmd->add_option("table", i->in, "file that 'table build' wrote")->required();
  info_cmd->callback([i, &code] {
    print_table(bekker::WheelTable::read(i->in));
    code = 0;
  });
  auto* query_cmd = table->add_subcommand("query", "look up the rows slip, load_N and zu_m of a CSV file");
  query_cmd->add_option("table", q->in, "file that 'table build' wrote")->required();
  query_cmd->add_option("cases", q->batch.cases, "CSV file")->required();
  add_batch_options(query_cmd, q->batch);
  query_cmd->callback([q, &code] {
    query(q->in, q->batch);
    code = 0;
  });
}

}  // namespace grouser::app
