// grouser dem: runs of grains and bodies, and beds of grains.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <memory>

#include "commands.h"
#include "dem_bed.h"
#include "dem_run.h"
#include "figure_page.h"
#include "file_kind.h"
#include "grouser/vehicle/folder_lock.h"
#include "progress.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

struct Arguments {
  fs::path file;
  DemRunOptions run;
  int threads = 1;
  bool overwrite = false, quiet = false;
};

void add_plot(report::FigurePage& page, const dem::Table& t, const std::string& title, const std::string& unit,
              const std::vector<std::string>& columns) {
  report::Plot plot{title, "time [s]", title + " [" + unit + "]", "", {}, false, false};
  for (const std::string& c : columns)
    plot.series.push_back({c, report::Series::Style::line, t.column("time_s"), t.column(c), {}, -1});
  if (!plot.series.empty()) page.items.push_back(std::move(plot));
}

report::FigurePage page_of(const DemCase& c, const DemRunResult& r) {
  report::FigurePage page{
      c.title,
      fmt::format("{} grains, {} steps of {:g} us, {:.2f} contacts per grain; stable up to {:.3g} us{}",
                  r.counters.grains, r.counters.steps, 1e6 * c.solver.dt, r.counters.touching, 1e6 * r.stable_step,
                  r.stopped.empty() ? "" : "; stopped: " + r.stopped),
      {}};
  if (r.forces.rows.empty()) return page;
  for (const DemBody& b : c.bodies) {
    add_plot(page, r.forces, "force of the grains on " + b.name + ", mean since the last output", "N",
             {b.name + "_fx_N", b.name + "_fy_N", b.name + "_fz_N"});
    add_plot(page, r.forces, "torque on " + b.name, "N m", {b.name + "_tx_Nm", b.name + "_ty_Nm", b.name + "_tz_Nm"});
    add_plot(page, r.forces, "place of " + b.name, "m", {b.name + "_x_m", b.name + "_y_m", b.name + "_z_m"});
  }
  if (!r.energy.rows.empty())
    add_plot(page, r.energy, "energy", "J",
             std::vector<std::string>(r.energy.columns.begin() + 1, r.energy.columns.end()));
  return page;
}

int run(Arguments a) {
  expect_kind(a.file, "dem");
  DemCase c = read_dem_case(a.file);
  c.solver.threads = a.threads;
  if (a.run.out.empty()) a.run.out = fs::path("runs") / ("dem-" + a.file.stem().string());
  const vehicle::FolderLock lock(a.run.out);
  const fs::path final_state = a.run.out / "grains.csv";
  if (a.overwrite) {
    std::error_code ignored;
    for (const char* f : {"grains.csv", "checkpoint.h5"}) fs::remove(a.run.out / f, ignored);
  } else if (fs::exists(final_state)) {
    throw ConfigError(a.run.out.string(), 0, 0,
                      "holds the results of an earlier run; use --overwrite, or another folder with --out");
  }
  ProgressLine line(a.quiet);
  const auto begin = std::chrono::steady_clock::now();
  a.run.progress = [&](double time, double total) {
    line.update(a.file.stem().string(), time, total,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), "s");
  };
  DemRunResult r;
  try {
    r = run_dem(c, a.run);
  } catch (const dem::GrainError& e) {
    throw grain_error(c.grain_files, e);
  } catch (const dem::DemError& e) {
    throw ConfigError(a.file.string(), 0, 0, e.what());
  }
  report::write_figure_page(page_of(c, r), a.run.out / "report.html");
  if (!r.stopped.empty()) {
    fmt::print(stderr, "{}: {}\n", a.file.string(), r.stopped);
    return 1;
  }
  fmt::print("{} grains, {} steps, {:.2f} M grain steps/s, state {:016x}\n", r.counters.grains, r.counters.steps,
             1e-6 * static_cast<double>(r.counters.grains) * static_cast<double>(r.counters.steps) / r.wall, r.hash);
  fmt::print("report: {}\n", (a.run.out / "report.html").string());
  return 0;
}

int bed(const fs::path& file, fs::path out, bool overwrite, bool quiet, double checkpoint_every) {
  expect_kind(file, "bed");
  const DemBedCase c = read_dem_bed(file);
  if (out.empty()) out = fs::path("runs") / (file.stem().string() + ".h5");
  if (fs::exists(out) && !overwrite) {
    if (dem::read_bed(out).inputs == c.inputs) {
      fmt::print("bed: {} is there already\n", out.string());
      return 0;
    }
    throw ConfigError(out.string(), 0, 0, "is a bed of other inputs; use --overwrite, or another file with --out");
  }
  ProgressLine line(quiet);
  const auto begin = std::chrono::steady_clock::now();
  std::error_code failed;
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), failed);
  if (failed) throw ConfigError(out.string(), 0, 0, "cannot be made: " + failed.message());
  fs::path checkpoint = out;
  checkpoint.replace_extension(".checkpoint.h5");
  const dem::Packing p = make_bed(c, checkpoint, checkpoint_every, [&](const std::string& stage, double done) {
    line.update(stage, 100 * done, 100, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
                "%");
  });
  dem::write_bed(p, out, c.title);
  fs::remove(checkpoint, failed);
  const std::vector<double> porosity = dem::porosity_profile(p, 4);
  fmt::print(
      "{} grains, {:.4g} x {:.4g} m, surface at {:.4g} m, bulk density {:.4g} kg/m^3, rms speed at the end {:.2g} m/s\n"
      "porosity from the bottom in quarters: {:.3f} {:.3f} {:.3f} {:.3f}\nbed: {}\n",
      p.grains.size(), p.lx, p.ly, p.height, p.bulk_density, p.residual_speed, porosity[0], porosity[1], porosity[2],
      porosity[3], out.string());
  return 0;
}

}  // namespace

void add_dem_command(CLI::App& cli, int& code) {
  auto* dem = cli.add_subcommand("dem", "grains as discrete elements");
  dem->require_subcommand(1);
  const auto a = std::make_shared<Arguments>();
  auto* cmd = dem->add_subcommand("run", "grains from a table or a bed, with bodies that move");
  cmd->add_option("case", a->file, "file of the case")->required();
  cmd->add_option("--out", a->run.out, "folder for the results (default runs/dem-<case>)");
  cmd->add_option("--threads", a->threads, "threads of the solver")->check(CLI::Range(1, 1024));
  cmd->add_option("--checkpoint-every", a->run.checkpoint_every, "seconds of the clock between checkpoints")
      ->check(CLI::Range(0.0, 86400.0));
  cmd->add_flag("--overwrite", a->overwrite, "replace the results of an earlier run");
  cmd->add_flag("--quiet", a->quiet, "no progress line");
  cmd->callback([a, &code] { code = run(*a); });

  struct BedArguments {
    fs::path file, out;
    bool overwrite = false, quiet = false;
    double checkpoint_every = 30;
  };
  const auto b = std::make_shared<BedArguments>();
  auto* make = dem->add_subcommand("bed", "pour, compact, tile, cut and store a bed of grains");
  make->add_option("bed", b->file, "file of the bed")->required();
  make->add_option("--out", b->out, "HDF5 file (default runs/<bed>.h5)");
  make->add_option("--checkpoint-every", b->checkpoint_every, "seconds of the clock between checkpoints of pouring")
      ->check(CLI::Range(0.0, 86400.0));
  make->add_flag("--overwrite", b->overwrite, "replace a bed of other inputs");
  make->add_flag("--quiet", b->quiet, "no progress line");
  make->callback([b, &code] { code = bed(b->file, b->out, b->overwrite, b->quiet, b->checkpoint_every); });
}

}  // namespace grouser::app
