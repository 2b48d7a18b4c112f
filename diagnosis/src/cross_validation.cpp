#include "cross_validation.h"

#include <algorithm>
#include <functional>

namespace grouser::diagnosis {
namespace {

constexpr std::size_t most_blocks = 6;
constexpr double out_of_sight = 1e-12;  // weight of a run that is left out

/// Block of each run, by equal or neighbouring values. Empty: fewer than three levels.
std::vector<int> blocks(const std::vector<Run>& runs, const std::function<double(const Run&)>& of, int& count) {
  std::vector<long> level;
  for (const Run& r : runs) level.push_back(std::lround(of(r) * 1e4));
  std::vector<long> seen = level;
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  count = static_cast<int>(std::min(seen.size(), most_blocks));
  if (seen.size() < 3) return {};
  std::vector<int> out;
  for (const long l : level) {
    const auto at = static_cast<std::size_t>(std::lower_bound(seen.begin(), seen.end(), l) - seen.begin());
    out.push_back(static_cast<int>(seen.size() <= most_blocks ? at : at * most_blocks / seen.size()));
  }
  return out;
}

}  // namespace

std::vector<double> cross_validate(const Search& s, const std::vector<Account>& accounts) {
  const Series& series = s.series();
  const std::function<double(const Run&)> variables[] = {
      [](const Run& r) { return r.load; }, [](const Run& r) { return r.slip; }, [](const Run& r) { return r.omega; }};
  std::vector<double> sum(accounts.size(), 0.0);
  int used = 0;
  for (const auto& of : variables) {
    int count = 0;
    const std::vector<int> block = blocks(series.runs(), of, count);
    if (block.empty()) continue;
    ++used;
    for (int b = 0; b < count; ++b) {
      Noise noise = s.noise();
      for (std::size_t r = 0; r < block.size(); ++r)
        if (block[r] == b) noise.weight[r] = out_of_sight;
      const Whitener w(series.layout(), noise, s.scatter());
      for (std::size_t a = 0; a < accounts.size(); ++a) {
        const Fit f = series.fit(*accounts[a].candidate, w, accounts[a].fit->x, accounts[a].fit->theta, 6);
        Eigen::MatrixXd u = f.ok ? f.residual : accounts[a].fit->residual;
        s.whitener().apply(u);
        double chi2 = 0;
        for (int i = 0; i < series.layout().size(); ++i)
          if (block[static_cast<std::size_t>(series.layout()[i].run)] == b) chi2 += u(i, 0) * u(i, 0);
        sum[a] -= 0.5 * chi2;
      }
    }
  }
  std::vector<double> out;
  for (const double x : sum) out.push_back(used > 0 ? (x - sum[0]) / used : std::numeric_limits<double>::quiet_NaN());
  return out;
}

}  // namespace grouser::diagnosis
