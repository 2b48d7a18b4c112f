// grouser soil: soil tests on grains.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "commands.h"
#include "file_kind.h"
#include "grouser/terrain/config.h"
#include "grouser/vehicle/folder_lock.h"
#include "soil_calibration.h"
#include "soil_page.h"
#include "soil_run.h"
#include "whole_file.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

struct Arguments {
  fs::path file, out;
  SoilRunOptions run;
};

void write_results(const SoilFile& f, const std::vector<SoilCaseResult>& results, const fs::path& out) {
  write_whole_file(out / "mean.csv", mean_csv(group_curves(results)));
  report::write_figure_page(soil_page(f, results), out / "report.html");
}

int code_of(const std::vector<SoilCaseResult>& results) {
  int code = 0;
  for (const SoilCaseResult& r : results)
    if (!r.failure.empty()) {
      fmt::print(stderr, "{}: {}\n", r.spec->name, r.failure);
      code = 1;
    }
  return code;
}

int run(const std::string& kind, Arguments a) {
  expect_kind(a.file, "soil_test");
  const SoilFile f = read_soil_file(a.file, kind);
  if (a.out.empty()) a.out = fs::path("runs") / ("soil-" + a.file.stem().string());
  if (a.run.beds.empty()) a.run.beds = a.out / "beds";
  const vehicle::FolderLock lock(a.out);
  std::vector<SoilJob> jobs;
  for (const SoilCase& c : f.cases) jobs.push_back({&c, a.out});
  const auto write = [&](const std::vector<SoilCaseResult>& r) { write_results(f, r, a.out); };
  const std::vector<SoilCaseResult> results = run_soil_cases(jobs, a.run, write);
  write(results);
  fmt::print("report: {}\n", (a.out / "report.html").string());
  return code_of(results);
}

int run_campaign(Arguments a) {
  expect_kind(a.file, "campaign");
  const SoilCampaign campaign = read_campaign(a.file);
  if (a.out.empty()) a.out = fs::path("runs") / a.file.stem();
  if (a.run.beds.empty()) a.run.beds = a.out / "beds";
  const vehicle::FolderLock lock(a.out);
  struct Place {
    std::size_t rank, run;
    const SoilCase* spec;
  };
  std::vector<Place> places;
  for (std::size_t r = 0; r < campaign.runs.size(); ++r) {
    const fs::path folder = a.out / campaign.runs[r].file.file.stem();
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed) throw ConfigError(folder.string(), 0, 0, "cannot be made: " + failed.message());
    for (const SoilCase& c : campaign.runs[r].file.cases) places.push_back({campaign.runs[r].later + c.packing, r, &c});
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& x, const Place& y) { return x.rank < y.rank; });
  std::vector<SoilJob> jobs;
  for (const Place& p : places) jobs.push_back({p.spec, a.out / campaign.runs[p.run].file.file.stem()});
  const auto write = [&](const std::vector<SoilCaseResult>& all) {
    for (std::size_t r = 0; r < campaign.runs.size(); ++r) {
      std::vector<SoilCaseResult> own;
      for (std::size_t k = 0; k < places.size(); ++k)
        if (places[k].run == r) own.push_back(all[k]);
      write_results(campaign.runs[r].file, own, a.out / campaign.runs[r].file.file.stem());
    }
  };
  const std::vector<SoilCaseResult> results = run_soil_cases(jobs, a.run, write);
  write(results);
  for (const SoilCampaign::Run& r : campaign.runs)
    fmt::print("report: {}\n", (a.out / r.file.file.stem() / "report.html").string());
  return code_of(results);
}

int run_calibration(Arguments a) {
  expect_kind(a.file, "calibration");
  const Calibration c = read_calibration(a.file);
  if (a.out.empty()) a.out = fs::path("runs") / ("soil-" + a.file.stem().string());
  if (a.run.beds.empty()) a.run.beds = a.out / "beds";
  const vehicle::FolderLock lock(a.out);
  const auto write = [&](const std::vector<CalibrationSet>& sets) {
    write_whole_file(a.out / "sets.csv", sets_csv(c, sets));
    report::write_figure_page(calibration_page(c, sets), a.out / "report.html");
  };
  std::vector<CalibrationSet> sets;
  try {
    sets = calibrate(c, a.out, a.run, write);
  } catch (const dem::DemError& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  const CalibrationSummary s = summarize(c, sets);
  fmt::print("best compromise of {} sets:", sets.size());
  for (std::size_t k = 0; k < c.parameters.size(); ++k)
    fmt::print(" {} {}", c.parameters[k].name, value_text(c.parameters[k], sets[s.best].values[k]));
  fmt::print("; error {:.1f} % of shear, {:.1f} % of sinkage\nreport: {}\n", 100 * sets[s.best].misfit[0].error,
             100 * sets[s.best].misfit[1].error, (a.out / "report.html").string());
  return 0;
}

void add_options(CLI::App& cmd, Arguments& a) {
  cmd.add_option("--out", a.out, "folder for the results (default under runs/)");
  cmd.add_option("--beds", a.run.beds, "folder of poured packings (default <out>/beds)");
  cmd.add_option("--threads", a.run.threads, "cases at the same time")->check(CLI::Range(1, 1024));
  cmd.add_option("--checkpoint-every", a.run.checkpoint_every, "seconds of the clock between checkpoints")
      ->check(CLI::Range(0.0, 86400.0));
  cmd.add_flag("--overwrite", a.run.overwrite, "replace results of other inputs");
  cmd.add_flag("--quiet", a.run.quiet, "no progress line");
}

void add_test(CLI::App& soil, const std::string& kind, const std::string& what, int& code) {
  const auto a = std::make_shared<Arguments>();
  auto* cmd = soil.add_subcommand(kind, what);
  cmd->add_option("case", a->file, "file of the test: soil, seeds, settings, variants")->required();
  add_options(*cmd, *a);
  cmd->callback([a, kind, &code] { code = run(kind, *a); });
}

}  // namespace

void add_soil_command(CLI::App& cli, int& code) {
  auto* soil = cli.add_subcommand("soil", "soil tests on grains (discrete elements)");
  soil->require_subcommand(1);
  add_test(*soil, "direct-shear", "split box under constant load, several packings and pressures", code);
  add_test(*soil, "pressure-sinkage", "plate pushed into a bed of grains", code);
  add_test(*soil, "angle-of-repose", "a wall of a box is lifted; slope of the heap over time", code);
  add_test(*soil, "oedometer", "compression between smooth walls, loading and unloading", code);
  add_test(*soil, "triaxial", "compression under constant side pressure: strength and dilation", code);
  const auto a = std::make_shared<Arguments>();
  auto* campaign = soil->add_subcommand("campaign", "several files of soil tests, packing by packing");
  campaign->add_option("campaign", a->file, "file that lists them")->required();
  add_options(*campaign, *a);
  campaign->callback([a, &code] { code = run_campaign(*a); });
  const auto b = std::make_shared<Arguments>();
  auto* calibration =
      soil->add_subcommand("calibrate", "stiffness, friction and rolling by shear and sinkage curves together");
  calibration->add_option("calibration", b->file, "file of the calibration: tests, parameters, search")->required();
  add_options(*calibration, *b);
  calibration->callback([b, &code] { code = run_calibration(*b); });
}

}  // namespace grouser::app
