#include "replicates.h"

#include <map>
#include <set>

namespace grouser::diagnosis {

std::optional<Replicates> replicates(const std::vector<Run>& runs, const DataLayout& layout,
                                     const Eigen::MatrixXd& slopes, const Eigen::VectorXd& residual, int least) {
  std::vector<std::array<int, channel_count>> row(runs.size());
  for (auto& r : row) r.fill(-1);
  for (int i = 0; i < layout.size(); ++i)
    row[static_cast<std::size_t>(layout[i].run)][static_cast<std::size_t>(layout[i].channel)] = i;
  std::map<int, std::vector<std::size_t>> cells;
  for (std::size_t r = 0; r < runs.size(); ++r) cells[runs[r].condition].push_back(r);
  std::vector<Run> made;
  std::vector<std::array<double, channel_count>> sd;
  std::vector<std::array<Eigen::Vector2d, channel_count>> by;
  for (const auto& [condition, members] : cells) {
    std::set<int> batches;
    for (const std::size_t r : members) batches.insert(runs[r].batch);
    if (members.size() < 2 || batches.size() < members.size()) continue;
    for (std::size_t k = 1; k < members.size(); ++k) {
      Run e;
      e.batch = static_cast<int>(made.size());
      std::array<double, channel_count> error{};
      std::array<Eigen::Vector2d, channel_count> slope;
      for (std::size_t c = 0; c < channel_count; ++c) {
        double sum = 0;
        bool all = true;
        for (std::size_t m = 0; m <= k; ++m) {
          const int i = row[members[m]][c];
          all = all && i >= 0;
          if (!all) break;
          sum += (m < k ? 1.0 : -static_cast<double>(k)) * residual[i];
          error[c] = layout[i].sd;
          slope[c] = slopes.row(i).transpose();
        }
        const double n = static_cast<double>(k);
        e.value[c] = all ? sum / std::sqrt(n * (n + 1)) : std::numeric_limits<double>::quiet_NaN();
      }
      made.push_back(e);
      sd.push_back(error);
      by.push_back(slope);
    }
  }
  Replicates out{DataLayout(made, sd), {}, {}};
  if (out.layout.size() < least) return std::nullopt;
  out.contrast.resize(out.layout.size());
  out.slopes.resize(out.layout.size(), 2);
  for (int i = 0; i < out.layout.size(); ++i) {
    const auto r = static_cast<std::size_t>(out.layout[i].run), c = static_cast<std::size_t>(out.layout[i].channel);
    out.contrast[i] = made[r].value[c];
    out.slopes.row(i) = by[r][c].transpose();
  }
  return out;
}

}  // namespace grouser::diagnosis
