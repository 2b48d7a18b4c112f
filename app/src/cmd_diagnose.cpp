// grouser diagnose: what the simulation gets wrong on measured runs, why, and what is gained by the extension.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>

#include "commands.h"
#include "diagnose_json.h"
#include "diagnose_page.h"
#include "grouser/diagnosis/diagnose.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw ResultsError(file.string() + ": cannot be written; is the folder writable?");
}

void print(const diagnosis::Diagnosis& d) {
  fmt::print("{}: {}\n", d.verdict, d.sentence);
  std::size_t shown = 0;
  for (const diagnosis::Ranked& r : d.ranking) {
    if (shown++ == 6) break;
    fmt::print("  {:<42} probability {:<10.3g} ln likelihood +{:<8.4g}", r.id, r.posterior, r.log_likelihood);
    for (const diagnosis::Interval& i : r.amplitudes)
      fmt::print(" {:.4g} [{:.4g}, {:.4g}]{}", i.value, i.low, i.high, i.unit == "1" ? "" : " " + i.unit);
    fmt::print("\n");
  }
  for (const diagnosis::NextExperiment& e : d.next) {
    fmt::print("  next: {}", e.bench_check);
    for (const auto& [name, x] : e.condition) fmt::print("{} {:.3g}  ", name, x);
    if (e.runs > 0) fmt::print("{} repeats, decides with probability {:.2f}", e.runs, e.chance);
    fmt::print("\n");
  }
  if (!d.suspect_lines.empty()) fmt::print("  suspect rows: lines {}\n", fmt::join(d.suspect_lines, ", "));
  for (const std::string& n : d.notes) fmt::print("  {}\n", n);
}

}  // namespace

void add_diagnose_command(CLI::App& cli, int& code) {
  struct Arguments {
    fs::path file, data, out;
    std::vector<std::string> withhold;
    bool overwrite = false;
  };
  const auto a = std::make_shared<Arguments>();
  auto* cmd = cli.add_subcommand(
      "diagnose", "measured runs against the model: the cause of the misfit, the extended model, its gain");
  cmd->add_option("case", a->file, "case file: model, wheel, soil with priors, effects")->required();
  cmd->add_option("--data", a->data, "runs as CSV with units in the header names")->required();
  cmd->add_option("--out", a->out, "folder for the results (default runs/diagnose-<data>)");
  cmd->add_option("--withhold", a->withhold, "runs to keep for the gain: load_N=225, slip=0.3..0.7");
  cmd->add_flag("--overwrite", a->overwrite, "replace the results of an earlier diagnosis");
  cmd->callback([a, &code] {
    if (a->out.empty()) a->out = fs::path("runs") / ("diagnose-" + a->data.stem().string());
    if (fs::exists(a->out / "diagnosis.json") && !a->overwrite)
      throw ConfigError(a->out.string(), 0, 0,
                        "holds the results of an earlier diagnosis; use --overwrite, or another folder with --out");
    const diagnosis::DiagnosisCase c = diagnosis::read_case(a->file);
    const diagnosis::RunTable data = diagnosis::read_runs(a->data, c);
    const diagnosis::Diagnosis d = diagnosis::diagnose(c, data, a->withhold);
    std::error_code failed;
    fs::create_directories(a->out, failed);
    if (failed)
      throw ResultsError(a->out.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
    write(a->out / "diagnosis.json", diagnosis_json(d).dump(2) + "\n");
    write(a->out / "extended.yaml", diagnosis::extended_case_text(d, c));
    report::write_figure_page(diagnose_page(d, c), a->out / "report.html");
    print(d);
    fmt::print("report: {}\n", (a->out / "report.html").string());
    code = 0;
  });
}

}  // namespace grouser::app
