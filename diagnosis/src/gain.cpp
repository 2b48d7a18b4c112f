#include "gain.h"

#include <algorithm>
#include <map>
#include <random>

namespace grouser::diagnosis {

std::optional<Gain> gain_on(const Search& s, const Candidate& extended, const Fit& fit,
                            const std::vector<Run>& withheld, const std::vector<std::string>& names) {
  Gain g;
  g.withheld = names;
  const Series& series = s.series();
  Candidate constant =
      extended;  // a drift has no value where it was not seen: the extended model is then the nominal one
  if (!extended.named()) constant = nominal_candidate();
  const Fit& used = extended.named() ? fit : s.nominal();
  const Candidate none = nominal_candidate();
  std::vector<std::array<double, 2>> square;  // nominal, extended, of each run
  std::array<std::array<double, channel_count>, 2> sum{};
  std::array<int, channel_count> count{};
  std::vector<std::array<double, channel_count>> sds(withheld.size(), s.usual_sd());
  for (std::size_t r = 0; r < withheld.size(); ++r)
    for (std::size_t c = 0; c < channel_count; ++c)
      if (withheld[r].sd[c] > 0) sds[r][c] = withheld[r].sd[c];
  const Series other(series.given(), withheld, sds);
  // The search for the entry angle begins where the nearest fitted run had it.
  std::vector<double> theta_n(withheld.size(), 0.0), theta_e(withheld.size(), 0.0);
  for (std::size_t r = 0; r < withheld.size(); ++r) {
    double nearest = INFINITY;
    for (std::size_t k = 0; k < series.runs().size(); ++k) {
      const Run& kept = series.runs()[k];
      const double away = std::abs(kept.slip - withheld[r].slip) + std::abs(std::log(kept.load / withheld[r].load));
      if (away >= nearest || k >= s.nominal().theta.size() || k >= used.theta.size()) continue;
      nearest = away, theta_n[r] = s.nominal().theta[k], theta_e[r] = used.theta[k];
    }
  }
  Eigen::VectorXd n, e;
  if (!other.predict(none, s.nominal().x, theta_n, n) || !other.predict(constant, used.x, theta_e, e))
    return std::nullopt;
  square.resize(withheld.size(), {0, 0});
  const Eigen::VectorXd y = other.measured();
  for (int i = 0; i < other.layout().size(); ++i) {
    const auto c = static_cast<std::size_t>(other.layout()[i].channel);
    const auto r = static_cast<std::size_t>(other.layout()[i].run);
    const double sd = other.layout()[i].sd * s.noise().scale[c], dn = y[i] - n[i], de = y[i] - e[i];
    square[r][0] += dn * dn / (sd * sd), square[r][1] += de * de / (sd * sd);
    sum[0][c] += dn * dn, sum[1][c] += de * de;
    ++count[c];
  }
  for (std::size_t c = 0; c < channel_count; ++c) {
    const double m = std::max(count[c], 1);
    g.nominal_rmse[c] = std::sqrt(sum[0][c] / m), g.extended_rmse[c] = std::sqrt(sum[1][c] / m);
  }
  g.runs = static_cast<int>(withheld.size());
  double a = 0, b = 0;
  for (const auto& q : square) a += q[0], b += q[1];
  g.rmse_ratio = a > 0 ? std::sqrt(b / a) : 1;
  // Repeats of one condition stay together.
  std::map<int, std::array<double, 2>> conditions;
  for (std::size_t r = 0; r < square.size(); ++r)
    for (std::size_t k = 0; k < 2; ++k) conditions[withheld[r].condition][k] += square[r][k];
  std::vector<std::array<double, 2>> cells;
  for (const auto& [condition, q] : conditions) cells.push_back(q);
  std::mt19937_64 random(20112022);
  std::vector<double> draws;
  for (int k = 0; k < 2000; ++k) {
    double p = 0, q = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto& pick = cells[random() % cells.size()];
      p += pick[0], q += pick[1];
    }
    draws.push_back(p > 0 ? std::sqrt(q / p) : 1);
  }
  std::sort(draws.begin(), draws.end());
  g.low = draws[50], g.high = draws[1949];
  return g;
}

}  // namespace grouser::diagnosis
