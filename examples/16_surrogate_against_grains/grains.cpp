// Runs of grains as one row each.   surrogate_grains PLAN.yaml RUNS >results/grains.csv     (PLAN: ../17_surrogate_by_direction/validation.yaml)
#include <cstdio>
#include <exception>
#include <filesystem>

#include "grouser/sdem/training.h"
#include "track.h"

namespace {

using grouser::sdem::TrainingPlan;
using grouser::sdem::TrainingRecord;
using grouser::sdem::TrainingRun;

void row(const TrainingPlan& p, const TrainingRun& r, const TrainingRecord& k) {
  const auto at = [](const std::vector<float>& v, std::size_t i) { return static_cast<double>(v[i]); };
  const auto ground = [&](double x) { return r.ground->height(x, 0); };
  std::size_t moving = 0;
  while (moving < k.x.size() && !(k.free[moving] > 0 && at(k.vx, moving) > 0)) ++moving;
  const double from = r.start + track::kFrom * r.distance;
  const double last = r.start + (1 - track::kEnd) * r.distance;
  track::Moments drawbar, torque, depth, hub, under, steep, slow, ahead, behind, end;
  double before_x = 0, before_z = 0;
  bool any = false;
  for (std::size_t i = moving; i < k.x.size(); ++i) {
    const double x = at(k.x, i), z = at(k.z, i);
    if (x < from) continue;
    drawbar.add(at(k.fx, i)), torque.add(-at(k.torque, i)), hub.add(z), under.add(ground(x)),
        depth.add(ground(x) - z + p.radius);
    if (x >= last) end.add(ground(x) - z + p.radius);
    if (at(k.vx, i) > 0) steep.add(std::abs(at(k.vz, i) / at(k.vx, i)));
    if (!any || x - before_x >= 0.01) {  // over 10 mm of way: single grains click
      if (any) slow.add(std::abs((z - before_z) / (x - before_x)));
      before_x = x, before_z = z, any = true;
    }
  }
  // Level of the highest grains before the wheel has touched them: they lie below the ground by what the raster sees between them.
  track::Moments level;
  for (int c = 0; c < TrainingRecord::kColumns; ++c)
    level.add(at(k.profile, static_cast<std::size_t>(c)) -
              ground((static_cast<double>(k.profile_column[0] + c) + 0.5) * p.column));
  for (std::size_t m = 1; m < k.profile_sample.size(); ++m) {
    const auto i = static_cast<std::size_t>(k.profile_sample[m]);
    if (i == 0 || i > k.x.size() || i <= moving || at(k.x, i - 1) < from) continue;
    const double x = at(k.x, i - 1);
    track::Moments front, back;
    for (int c = 0; c < TrainingRecord::kColumns; ++c) {
      const double s = (static_cast<double>(k.profile_column[m] + c) + 0.5) * p.column, d = s - x,
                   h = at(k.profile, m * TrainingRecord::kColumns + static_cast<std::size_t>(c)) - ground(s);
      if (d > track::kAheadFrom && d < track::kAheadTo) front.add(h);
      if (d < -track::kAheadFrom - track::kBehind && d > -track::kAheadTo - track::kBehind) back.add(h);
    }
    ahead.add(front.mean() - level.mean());
    behind.add(back.mean() - level.mean());
  }
  std::printf("%s,%s,%d,%.4g,%.4g,%.3g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.4g,%.5g,%.5g\n",
              r.name.c_str(), r.ground->describe() == "flat" ? "flat" : "rough", r.seed, r.slips.front(), r.load,
              r.rest, drawbar.mean(), drawbar.sd(), torque.mean(), torque.sd(), 1e3 * depth.mean(), 1e3 * depth.sd(),
              1e3 * hub.sd(), 1e3 * under.sd(), 1e3 * ahead.mean(), 1e3 * behind.mean(), steep.mean(), slow.mean(),
              k.processor, 1e3 * end.mean(), 1e3 * level.mean());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: surrogate_grains PLAN.yaml RUNS\n");
    return 2;
  }
  try {
    std::vector<TrainingRun> runs;
    const TrainingPlan p = grouser::sdem::load_training(argv[1], runs);
    std::printf(
        "run,ground,seed,slip_rim,load_N,rest_s,drawbar_N,drawbar_sd_N,torque_Nm,torque_sd_Nm,sinkage_mm,sinkage_sd_mm,"
        "hub_sd_mm,ground_sd_mm,ahead_mm,behind_mm,vz_over_vx,vz_over_vx_10mm,processor_s,"
        "sinkage_end_mm,level_mm\n");
    for (const TrainingRun& r : runs)
      if (r.kind == TrainingRun::Kind::load && r.slips.size() == 1)
        row(p, r, read_training(r, std::filesystem::path(argv[2]) / (r.name + ".h5")));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
