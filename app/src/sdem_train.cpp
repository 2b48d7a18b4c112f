// grouser sdem train: the runs of a training plan, one file each.
#include "sdem_train.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <chrono>

#include "file_kind.h"
#include "grouser/dem/packing.h"
#include "grouser/sdem/training.h"
#include "grouser/vehicle/folder_lock.h"
#include "progress.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

constexpr double kCost = 6;  ///< processor seconds a simulated one (examples/15_quasi_2d)

std::string line_of(const sdem::TrainingRun& r) {
  using Kind = sdem::TrainingRun::Kind;
  if (r.kind == Kind::press) return fmt::format("press {:.3g} N", fmt::join(r.press, ", "));
  return fmt::format("{}, slips {:.3g}, {:.3g} m",
                     r.kind == Kind::load ? fmt::format("load {:.3g} N", r.load)
                                          : fmt::format("depth {:.3g} +- {:.3g} mm", 1e3 * r.depth, 1e3 * r.swing),
                     fmt::join(r.slips, ", "), r.distance);
}

}  // namespace

int sdem_train(SdemTrainArguments a) {
  expect_kind(a.plan_file, "training");
  std::vector<sdem::TrainingRun> runs;
  const sdem::TrainingPlan p = sdem::load_training(a.plan_file, runs);
  if (a.runs.empty()) a.runs = fs::path("runs") / ("sdem-" + a.plan_file.stem().string());
  const auto file = [&](const sdem::TrainingRun& r) { return a.runs / (r.name + ".h5"); };
  double total = 0, done = 0;
  int missing = 0;
  for (const sdem::TrainingRun& r : runs) {
    const bool there = fs::exists(file(r));
    if (!there) total += r.seconds(p);
    missing += !there;
    if (a.plan)
      fmt::print("{}  seed {}  {}, {:.3g} s{}\n", r.name, r.seed, line_of(r), r.seconds(p), there ? ", there" : "");
  }
  fmt::print("{} runs, {} of them there; the others {:.3g} s simulated, some {:.2g} minutes of one core\n", runs.size(),
             runs.size() - static_cast<std::size_t>(missing), total, total * kCost / 60);
  if (a.plan) return 0;
  std::fflush(stdout);
  const vehicle::FolderLock lock(a.runs);
  ProgressLine line(a.quiet);
  const auto begin = std::chrono::steady_clock::now();
  for (const sdem::TrainingRun& r : runs) {
    if (fs::exists(file(r))) continue;
    try {
      const auto record = sdem::simulate(p, r, [&](double share) {
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        line.update(r.name, done + share * r.seconds(p), total, wall.count(), "s");
      });
      sdem::write_training(record, r, file(r));
    } catch (const dem::DemError& e) {
      throw ConfigError(a.plan_file.string(), 0, 0, "run " + r.name + ": " + e.what());
    }
    done += r.seconds(p);
  }
  return 0;
}

}  // namespace grouser::app
