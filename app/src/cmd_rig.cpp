// grouser rig: runs the sweep and prints its steady means.
#include <fmt/core.h>

#include "commands.h"
#include "file_kind.h"
#include "folders.h"
#include "grouser/models.h"
#include "grouser/vehicle/rig.h"
#include "option_text.h"
#include "progress.h"
#include "report.h"
#include "rig_csv.h"

namespace grouser::app {

namespace {

void print_rows(const vehicle::RigSummary& s) {
  fmt::print("{:>8} {:>8}  {:>17}  {:>17}  {:>15}  {}\n", "slip", "rim", "drawbar [N]", "torque [N m]", "sinkage [mm]",
             "");
  for (const vehicle::RigRow& r : s.rows)
    fmt::print("{:>8.3f} {:>8.3f}  {:>8.2f} +- {:<5.2f}  {:>8.3f} +- {:<5.3f}  {:>6.2f} +- {:<5.2f}  {}\n",
               r.slip_symmetric, r.slip_rim, r.drawbar_pull.mean, r.drawbar_pull.sd, r.driving_torque.mean,
               r.driving_torque.sd, 1e3 * r.sinkage.mean, 1e3 * r.sinkage.sd,
               r.stationary ? "" : "not stationary: " + r.note);
}

void print_errors(const vehicle::RigSummary& s) {
  if (s.errors.empty()) return;
  fmt::print("against the measured values\n");
  for (const vehicle::RigErrorRow& e : s.errors)
    fmt::print("  {:<24} {:<16} rmse {:8.3f} {}, bias {:+8.3f} {}, measured range {:.3f} {}\n", e.group, e.channel,
               e.rmse, e.unit, e.bias, e.unit, e.measured_range, e.unit);
}

}  // namespace

int rig(const RigArguments& a) {
  expect_kind(a.rig, "rig");
  check_terrain_id(a.terrain);
  vehicle::RigOptions o;
  o.out = a.out.empty() ? default_folder(a.rig, a.terrain) : a.out;
  o.threads = a.threads;
  o.terrain = a.terrain;
  o.integrator = a.integrator;
  if (!a.slips.empty()) o.slips = option_quantities("--slips", a.slips, "1", Range::any());
  vehicle::check_rig(a.rig, all_models(), o.terrain, o.slips);
  check_folder(o.out, a.overwrite);
  ProgressLine line(a.quiet);
  o.progress = [&](double done, double total, double wall) {
    line.update(a.rig.stem().string(), done, total, wall, "s");
  };
  const vehicle::RigSummary s = vehicle::run_rig(a.rig, all_models(), o);
  if (a.csv) write_rig_csv(s.folder);
  print_rows(s);
  print_errors(s);
  for (const std::string& n : s.notices) fmt::print("note: {}\n", n);
  for (const vehicle::RigRow& r : s.rows)
    if (!r.warning.empty()) fmt::print("warning: slip {:g}, {:g} N: {}\n", r.slip_rim, r.spec.load, r.warning);
  if (a.no_report) {
    fmt::print("results: {}\n", s.folder.string());
    return 0;
  }
  write_report({s.folder}, s.folder / "report.html");
  fmt::print("report: {}\n", (s.folder / "report.html").string());
  return 0;
}

}  // namespace grouser::app
