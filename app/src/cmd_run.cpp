// grouser run, resume, report.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "commands.h"
#include "file_kind.h"
#include "folders.h"
#include "grouser/models.h"
#include "grouser/terrain/config.h"
#include "grouser/vehicle/simulation.h"
#include "option_text.h"
#include "progress.h"
#include "report.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

constexpr double nothing_done = 1e-3;  // [J] below it a percentage says nothing

void print_summary(const vehicle::RunSummary& s) {
  const double other = std::max(0.0, s.wall_s - s.bullet_s - s.terrain_s - s.output_s);
  fmt::print("simulated {:.2f} s in {:.2f} s: {:.1f} times real time\n", s.simulated_s, s.wall_s,
             s.wall_s > 0 ? s.simulated_s / s.wall_s : 0.0);
  fmt::print("time: Bullet {:.2f} s, terrain {:.2f} s, output {:.2f} s, other {:.2f} s\n", s.bullet_s, s.terrain_s,
             s.output_s, other);
  const std::string parked = s.energy_yardstick_J < nothing_done ? ", next to nothing: the vehicle stood" : "";
  // A ledger that closes says nothing of what the time step itself does, so both stand side by side.
  const std::string share =
      parked.empty() ? fmt::format(" ({:.2g} %)", 100 * std::abs(s.energy_step_J) / s.energy_yardstick_J) : "";
  fmt::print(
      "energy closes within {:.3f} % of the {} ({:.4g} J{}), counting {:.2g} J{} that the time step itself {}; joint "
      "drift {:.4f} mm\n",
      100 * s.energy_residual_ratio, s.energy_yardstick, s.energy_yardstick_J, parked, std::abs(s.energy_step_J), share,
      s.energy_step_J < 0 ? "took" : "added", 1000 * s.joint_drift_m);
  for (const std::string& n : s.notices) fmt::print("note: {}\n", n);
  for (const std::string& w : s.warnings) fmt::print("warning: {}\n", w);
  fmt::print("end state {}\n", s.end_state_hash);
}

int finish(const fs::path& folder, bool no_report) {
  if (no_report) {
    fmt::print("results: {}\n", folder.string());
    return 0;
  }
  const fs::path html = folder / "report.html";
  write_report({folder}, html);
  fmt::print("report: {}\n", html.string());
  return 0;
}

/// A run that stops still gets its report, so that one can look at what happened.
template <class F>
auto keep_what_was_written(const fs::path& folder, bool no_report, F&& f) {
  try {
    return f();
  } catch (const vehicle::SimulationError&) {
    if (!no_report) {
      try {
        write_report({folder}, folder / "report.html");
        fmt::print(stderr, "what was simulated: {}\n", (folder / "report.html").string());
      } catch (const std::exception& e) {
        fmt::print(stderr, "no report: {}\n", e.what());
      }
    }
    throw;
  }
}

}  // namespace

int run(const RunArguments& a) {
  expect_kind(a.scenario, "scenario");
  check_terrain_id(a.terrain);
  const fs::path folder = a.out.empty() ? default_folder(a.scenario, a.terrain) : a.out;
  vehicle::RunOptions o;
  o.out = folder;
  o.threads = a.threads;
  o.terrain = a.terrain;
  if (a.duration) o.duration = option_quantity("--duration", *a.duration, "s", {0, 1e6, true, false});
  vehicle::check_scenario(a.scenario, all_models());
  check_folder(folder, a.overwrite);
  ProgressLine line(a.quiet);
  const std::string head = a.scenario.stem().string();
  o.progress = [&](const vehicle::Progress& p) { line.update(head, p.time, p.duration, p.wall_s, "s"); };
  const auto summary =
      keep_what_was_written(folder, a.no_report, [&] { return vehicle::run_scenario(a.scenario, all_models(), o); });
  print_summary(summary);
  return finish(folder, a.no_report);
}

int resume(const fs::path& folder, int threads, bool quiet) {
  ProgressLine line(quiet);
  const auto progress = [&](const vehicle::Progress& p) { line.update("resumed", p.time, p.duration, p.wall_s, "s"); };
  const auto summary = keep_what_was_written(
      folder, false, [&] { return vehicle::resume_run(folder, all_models(), threads, progress); });
  print_summary(summary);
  return finish(folder, false);
}

int report(const std::vector<fs::path>& folders, fs::path out) {
  if (out.empty()) out = folders.front() / "report.html";
  write_report(folders, out);
  fmt::print("report: {}\n", out.string());
  return 0;
}

}  // namespace grouser::app
