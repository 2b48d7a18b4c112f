// grouser sdem build: the runs of a campaign, one file each, then the tables.
#include "sdem_build.h"

#include <fmt/core.h>

#include <chrono>
#include <cstdlib>
#include <mutex>
#include <optional>

#include "file_kind.h"
#include "grouser/sdem/campaign.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/parallel.h"
#include "grouser/vehicle/folder_lock.h"
#include "progress.h"
#include "sdem_part.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

/// One core on the bed of 11,500 grains (dem/README.md, Speed).
constexpr double kGrainStepsPerSecond = 4e7;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Missing runs of a campaign, several at a time, with their progress weighed by cost.
class Runs {
 public:
  Runs(const sdem::Campaign& c, const std::vector<sdem::CampaignRun>& runs, const fs::path& folder,
       const SdemPart& part)
      : c_(c), runs_(runs), folder_(folder), done_(runs.size(), 0.0) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      cost_.push_back(sdem::grain_steps(c, runs[k]));
      if (!part.has(k) || fs::exists(file(k))) continue;
      missing_.push_back(k);
      total_ += cost_[k];
    }
  }
  fs::path file(std::size_t k) const { return folder_ / (runs_[k].name + ".h5"); }
  const std::vector<std::size_t>& missing() const { return missing_; }
  double hours() const { return total_ / kGrainStepsPerSecond / 3600; }

  void make(const dem::Packing& brick, int threads, ProgressLine& line) {
    const auto begin = Clock::now();
    parallel_for(static_cast<int>(missing_.size()), threads, [&](int i) {
      const std::size_t k = missing_[static_cast<std::size_t>(i)];
      const sdem::CampaignRun& r = runs_[k];
      sdem::RunRecord record;
      try {
        record = sdem::simulate(c_, r, brick, [&](double done) {
          const std::lock_guard lock(one_);
          done_[k] = done;
          double sum = 0;
          for (const std::size_t m : missing_) sum += done_[m] * cost_[m];
          line.update(fmt::format("{} runs", missing_.size()), 100 * sum / total_, 100, seconds_since(begin), "%");
        });
      } catch (const dem::DemError& e) {
        throw dem::DemError(
            fmt::format("run at {:.4g} rad/s, {:.4g} m/s forward, {:.4g} m/s upward: {}", r.w, r.vx, r.vz, e.what()));
      }
      const std::lock_guard lock(one_);
      sdem::write_run(record, r, file(k));
    });
  }

 private:
  const sdem::Campaign& c_;
  const std::vector<sdem::CampaignRun>& runs_;
  fs::path folder_;
  std::vector<double> cost_, done_;
  std::vector<std::size_t> missing_;
  double total_ = 0;
  std::mutex one_;
};

void print_plan(const sdem::Campaign& c, const std::vector<sdem::CampaignRun>& runs, const Runs& state) {
  fmt::print("{:>10} {:>10} {:>10} {:>9} {:>8} {:>14}  {}\n", "deg/s", "mm/s fwd", "mm/s up", "s", "m of bed",
             "grain steps", "run");
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const sdem::CampaignRun& r = runs[k];
    fmt::print("{:>10.4g} {:>10.4g} {:>10.4g} {:>9.3g} {:>8.3g} {:>14.3g}  {}{}\n", 180 / pi * r.w, 1e3 * r.vx,
               1e3 * r.vz, r.duration, r.bricks * c.brick, sdem::grain_steps(c, r), r.name,
               fs::exists(state.file(k)) ? ", there" : "");
  }
}

}  // namespace

int sdem_build(SdemBuildArguments a) {
  expect_kind(a.campaign, "surrogate");
  const sdem::Campaign c = sdem::load_campaign(a.campaign);
  const std::vector<sdem::CampaignRun> runs = sdem::plan_of(c);
  const std::string stem = a.campaign.stem().string();
  if (a.runs.empty()) a.runs = fs::path("runs") / ("sdem-" + stem);
  if (a.out.empty()) a.out = a.runs / "tables.h5";
  if (a.beds.empty()) a.beds = a.runs;
  if (a.slurm > 0) {
    // This program, wherever it lies: a job has a PATH of its own.
    std::string command = fmt::format("'{}' sdem build '{}' --runs '{}' --beds '{}' --out '{}'",
                                      fs::read_symlink("/proc/self/exe").string(), a.campaign.string(), a.runs.string(),
                                      a.beds.string(), a.out.string());
    if (a.overwrite) command += " --overwrite";
    fmt::print("{}", sdem_slurm_script(command, a.slurm));
    return 0;
  }
  const SdemPart part = a.part.empty() ? SdemPart() : sdem_part(a.part);
  Runs state(c, runs, a.runs, part);
  if (a.plan) print_plan(c, runs, state);
  fmt::print("{} runs{}, {} of them missing, some {:.2g} hours of one core at {:.0f} million grain steps a second\n",
             runs.size(), part.of > 1 ? fmt::format(", part {} of {}", part.number, part.of) : "",
             state.missing().size(), state.hours(), 1e-6 * kGrainStepsPerSecond);
  if (a.plan) return 0;
  if (part.of == 1 && fs::exists(a.out) && !a.overwrite)
    throw ConfigError(a.out.string(), 0, 0, "is there already; use --overwrite, or another file with --out");
  std::fflush(stdout);
  // Parts share the folder: no two have a run in common, and every file is written whole.
  std::optional<vehicle::FolderLock> lock;
  if (a.part.empty())
    lock.emplace(a.runs);
  else
    fs::create_directories(a.runs);
  ProgressLine line(a.quiet);
  const auto begin = Clock::now();
  try {
    if (!state.missing().empty()) {
      const dem::Packing brick = sdem::campaign_brick(
          c, a.beds, [&](double done) { line.update("pouring", 100 * done, 100, seconds_since(begin), "%"); });
      state.make(brick, a.threads, line);
    }
  } catch (const dem::DemError& e) {
    throw ConfigError(a.campaign.string(), 0, 0, e.what());
  }
  if (!a.part.empty()) {
    std::size_t there = 0;
    for (std::size_t k = 0; k < runs.size(); ++k) there += fs::exists(state.file(k)) ? 1 : 0;
    fmt::print("part {} of {} done, {} of {} runs there; tables: the same command without --part\n", part.number,
               part.of, there, runs.size());
    return 0;
  }
  const sdem::Tables tables =
      sdem::make_tables(c, runs, [&](std::size_t k) { return sdem::read_run(runs[k], state.file(k)); });
  tables.write(a.out);
  fmt::print("tables: {}, hash {}\n", a.out.string(), tables.hash_text());
  return 0;
}

}  // namespace grouser::app
