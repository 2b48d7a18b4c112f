#include "plan.h"

#include <tuple>

namespace blind {
namespace {

constexpr double kSlips[] = {-0.7, -0.5, -0.3, -0.1, 0.0, 0.1, 0.3, 0.5, 0.7};

std::vector<PlannedRun> crossed(const std::vector<double>& loads, const std::vector<double>& speeds, int passes,
                                int replicates) {
  std::vector<PlannedRun> out;
  for (const double slip : kSlips)
    for (const double load : loads)
      for (const double omega : speeds)
        for (int pass = 1; pass <= passes; ++pass)
          for (int replicate = 1; replicate <= replicates; ++replicate) {
            PlannedRun p;
            p.run = {slip, load, omega, pass};
            p.replicate = replicate;
            out.push_back(p);
          }
  return out;
}

std::vector<PlannedRun> conditions(Plan plan) {
  const std::vector<double> loads{60, 115, 170, 225}, speeds{0.1, 0.3, 0.9};
  switch (plan) {
    case Plan::slip:
      return crossed({115}, {0.3}, 1, 24);
    case Plan::slip_load:
      return crossed(loads, {0.3}, 1, 6);
    case Plan::constant_load:
      return crossed({115}, speeds, 2, 4);
    case Plan::constant_speed:
      return crossed(loads, {0.3}, 2, 3);
    case Plan::full:
      break;
  }
  return crossed(loads, speeds, 2, 1);
}

}  // namespace

std::string_view name(Plan plan) {
  switch (plan) {
    case Plan::slip:
      return "slip";
    case Plan::slip_load:
      return "slip_load";
    case Plan::constant_load:
      return "constant_load";
    case Plan::constant_speed:
      return "constant_speed";
    case Plan::full:
      break;
  }
  return "full";
}

std::vector<PlannedRun> plan_runs(Plan plan, const PlanOptions& options, Dice& dice) {
  std::vector<PlannedRun> runs = conditions(plan);
  if (options.only > 0) {
    dice.shuffle(runs);
    runs.resize(std::min(runs.size(), static_cast<std::size_t>(options.only)));
  }
  std::vector<std::size_t> cells(runs.size());
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = i;
  dice.shuffle(cells);
  for (std::size_t i = 0; i < cells.size() && static_cast<int>(i) < options.extra_replicates; ++i)
    for (int replicate = 2; replicate <= 3; ++replicate) {
      PlannedRun more = runs[cells[i]];
      more.replicate = replicate;
      runs.push_back(more);
    }
  if (options.withheld_block) {
    for (PlannedRun more : crossed({kWithheldLoad}, {0.1, 0.3, 0.9}, 2, 1)) {
      more.withheld = true;
      runs.push_back(more);
    }
  }
  dice.shuffle(runs);
  if (options.sorted)
    std::stable_sort(runs.begin(), runs.end(), [](const PlannedRun& a, const PlannedRun& b) {
      return std::tie(a.run.load, a.run.omega) < std::tie(b.run.load, b.run.omega);
    });
  const double last = runs.size() > 1 ? static_cast<double>(runs.size() - 1) : 1.0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].order = runs[i].batch = static_cast<int>(i) + 1;
    runs[i].run.order_share = static_cast<double>(i) / last;
  }
  if (options.shared_preparation)
    for (PlannedRun& p : runs)
      for (const PlannedRun& first : runs)
        if (first.replicate == 1 && first.run.slip == p.run.slip && first.run.load == p.run.load &&
            first.run.omega == p.run.omega && first.run.pass == p.run.pass)
          p.batch = first.order;
  return runs;
}

}  // namespace blind
