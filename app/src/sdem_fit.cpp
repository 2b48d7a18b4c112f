// grouser sdem fit: the law of sdem.v2 from the runs of a training plan.
#include "sdem_fit.h"

#include <fmt/core.h>
#include <fmt/os.h>

#include <cmath>
#include <map>

#include "file_kind.h"
#include "grouser/sdem/direction_fit.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

/// Means over each run, grains and law.
void print_runs(const std::vector<sdem::TrainingRun>& runs, const std::vector<sdem::FitWindow>& windows) {
  std::map<std::pair<std::size_t, long>, std::pair<sdem::FitWindow, int>> sums;
  for (const sdem::FitWindow& w : windows) {
    auto& [sum, n] = sums[{w.run, std::lround(100 * w.slip)}];
    sum.free = w.free;
    for (std::size_t k = 0; k < 6; ++k) {
      sum.grains[k] += w.grains[k];
      sum.law[k] += w.law[k];
    }
    ++n;
  }
  fmt::print("means over each run and slip, grains | law\n{:<10}{:>6}{:>8}  {:>15}{:>17}{:>17}{:>19}{:>17}{:>15}\n",
             "run", "1-v/rw", "load", "height, mm", "Fx, N", "Fz, N", "torque, N m", "behind, mm", "ahead, mm");
  for (const auto& [key, value] : sums) {
    const auto& [s, n] = value;
    const auto two = [&](std::size_t k, double scale) {
      return fmt::format("{:.3g} | {:.3g}", scale * s.grains[k] / n, scale * s.law[k] / n);
    };
    fmt::print("{:<10}{:>6}{:>8.3g}  {:>15}{:>17}{:>17}{:>19}{:>17}{:>15}\n", runs[key.first].name.substr(0, 8),
               0.01 * static_cast<double>(key.second), runs[key.first].load, two(0, 1e3), two(1, 1), two(2, 1),
               two(3, 1), two(4, 1e3), two(5, 1e3));
  }
}

}  // namespace

int sdem_fit(SdemFitArguments a) {
  expect_kind(a.plan_file, "training");
  std::vector<sdem::TrainingRun> runs;
  const sdem::TrainingPlan p = sdem::load_training(a.plan_file, runs);
  if (a.runs.empty()) a.runs = fs::path("runs") / ("sdem-" + a.plan_file.stem().string());
  if (a.out.empty()) a.out = a.runs / "law.h5";
  if (fs::exists(a.out) && !a.overwrite)
    throw ConfigError(a.out.string(), 0, 0, "is there already; use --overwrite, or another file with --out");
  if (a.keep_coefficients && a.start.empty())
    throw ConfigError("--keep-coefficients", 0, 0, "needs --start, the law whose coefficients are kept");
  std::vector<sdem::TrainingRecord> records;
  std::string inputs;
  std::size_t there = 0;
  for (const sdem::TrainingRun& r : runs) {
    const fs::path file = a.runs / (r.name + ".h5");
    if (!fs::exists(file)) {
      if (!a.partly)
        throw ConfigError(a.plan_file.string(), 0, 0,
                          "run " + r.name +
                              " is missing; make it with 'grouser sdem train', or fit those that are "
                              "there with --partly");
      records.emplace_back();
      continue;
    }
    records.push_back(sdem::read_training(r, file));
    inputs += "run " + r.name + "\n";
    ++there;
  }
  sdem::Direction law;
  law.title = p.title;
  law.source = p.source;
  law.wheel = p.wheel;
  law.soil = p.soil_text;
  law.radius = p.radius;
  law.width = p.width;
  law.column = p.column;
  law.inputs = inputs;
  for (std::size_t k = 0; k < sdem::kCoefficients; ++k) law.c[k] = sdem::coefficient_infos()[k].start;
  if (!a.start.empty()) law.c = sdem::Direction::read(a.start).c;
  sdem::FitSettings settings;
  settings.wheel.memory = !a.without_memory;
  settings.wheel.pile = !a.without_pile;
  if (a.keep_coefficients) settings.evaluations = 0;
  const sdem::FitReport report = sdem::fit(p, runs, records, law, settings, [&](int n, double cost) {
    if (!a.quiet) fmt::print(stderr, "{} evaluations, cost {:.5g}\n", n, cost);
  });
  law.write(a.out);
  fmt::print("{} of {} runs; cost {:.4g} before, {:.4g} after {} evaluations\n", there, runs.size(), report.cost_before,
             report.cost_after, report.evaluations);
  for (std::size_t k = 0; k < sdem::kCoefficients; ++k)
    fmt::print("{:<12}{:>10.4g}  {}\n", sdem::coefficient_infos()[k].name, law.c[k], sdem::coefficient_infos()[k].what);
  fmt::print(
      "spread of runs about the law: height {:.3g} mm, mu {:.3g}, tau {:.3g}; noise of grains: {:.3g} mm, {:.3g}, "
      "{:.3g}\n",
      1e3 * law.spread[0], law.spread[1], law.spread[2], 1e3 * law.grain[0], law.grain[1], law.grain[2]);
  fmt::print(
      "fluctuation of the law over that of grains: height {:.2f}, Fx {:.2f}, torque {:.2f}; not fitted: Fz {:.2f}\n",
      report.sd_ratio[0], report.sd_ratio[1], report.sd_ratio[2], report.sd_ratio[3]);
  print_runs(runs, report.windows);
  fmt::print("law: {}, hash {}\n", a.out.string(), law.hash_text());
  return 0;
}

int sdem_compare(const SdemCompareArguments& a) {
  const sdem::Direction law = sdem::Direction::read(a.law);
  expect_kind(a.plan_file, "training");
  std::vector<sdem::TrainingRun> runs;
  const sdem::TrainingPlan p = sdem::load_training(a.plan_file, runs);
  const fs::path folder = a.runs.empty() ? fs::path("runs") / ("sdem-" + a.plan_file.stem().string()) : a.runs;
  fmt::print(
      "run,ground,seed,load_N,slip,rest_s,height_mm,law_height_mm,height_sd_mm,law_height_sd_mm,fx_N,law_fx_N,fx_sd_N,"
      "law_fx_sd_N,torque_Nm,law_torque_Nm,torque_sd_Nm,law_torque_sd_Nm,fz_N,law_fz_N,fz_sd_N,law_fz_sd_N,profile_rms_"
      "mm,outside,drift_m2,way_m,"
      "simulated_s,processor_s,law_processor_s,bar_height_mm,bar_fx_N,bar_torque_Nm\n");
  for (const sdem::TrainingRun& r : runs) {
    const fs::path file = folder / (r.name + ".h5");
    if (!fs::exists(file) || r.kind == sdem::TrainingRun::Kind::press) continue;
    const sdem::TrainingRecord record = sdem::read_training(r, file);
    const sdem::DirectionSettings wheel{a.quiet_grains ? 0.0 : 1.0, static_cast<std::uint64_t>(r.seed), 0,
                                        !a.without_memory, !a.without_pile};
    const double wider = wheel.wider();
    const sdem::Comparison c = sdem::compare(p, r, record, law, wheel, a.share);
    std::string ground = r.ground->describe();
    for (char& x : ground)
      if (x == ',') x = ';';
    fmt::print("{},{},{},{:.4g},{:.3g},{:.3g}", r.name, ground, r.seed, c.load, c.slip, r.rest);
    for (std::size_t k = 0; k < c.law.size(); ++k) {
      const double unit = k == 0 ? 1e3 : 1;
      fmt::print(",{:.5g},{:.5g},{:.4g},{:.4g}", unit * c.grains[k], unit * c.law[k], unit * c.grains_sd[k],
                 unit * c.law_sd[k]);
    }
    fmt::print(",{:.4g},{:.3g},{:.2g},{:.4g},{:.4g},{:.4g},{:.4g},{:.3g},{:.3g},{:.3g}\n", 1e3 * c.profile_rms,
               c.outside, c.drift, c.x_to - c.x_from, c.seconds, record.processor, c.law_seconds,
               1e3 * wider * law.spread[0], wider * c.load * law.spread[1],
               wider * c.load * law.spread[2] * law.radius);
  }
  return 0;
}

}  // namespace grouser::app
