#include "gain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>

namespace grouser::diagnosis {
namespace {

constexpr std::size_t least_conditions = 5;  // that a bootstrap can draw from

}  // namespace

std::optional<Gain> gain_on(const Search& s, const Candidate& extended, const Fit& fit, std::vector<Run> withheld,
                            const std::vector<std::string>& names, std::vector<std::string>& notes) {
  Gain g;
  g.withheld = names;
  const Series& series = s.series();
  Candidate constant =
      extended;  // a drift has no value where it was not seen: the extended model is then the nominal one
  if (!extended.named()) constant = nominal_candidate();
  const Fit& used = extended.named() ? fit : s.nominal();
  const Candidate none = nominal_candidate();
  g.carried = extended.named();
  std::vector<std::array<double, 2>> square;  // nominal, extended, of each run
  std::array<std::array<double, channel_count>, 2> sum{};
  std::array<int, channel_count> count{};
  const auto errors_of = [&](const std::vector<Run>& runs) {
    std::vector<std::array<double, channel_count>> sds(runs.size(), s.usual_sd());
    for (std::size_t r = 0; r < runs.size(); ++r)
      for (std::size_t c = 0; c < channel_count; ++c)
        if (runs[r].sd[c] > 0) sds[r][c] = runs[r].sd[c];
    return sds;
  };
  Eigen::VectorXd n, e;
  // The search for the entry angle begins where the nearest fitted run had it, or anew.
  const auto answer = [&](const std::vector<Run>& runs, const Series& other) {
    std::vector<double> theta_n(runs.size(), 0.0), theta_e(runs.size(), 0.0);
    for (std::size_t r = 0; r < runs.size(); ++r) {
      double nearest = INFINITY;
      for (std::size_t k = 0; k < series.runs().size(); ++k) {
        const Run& kept = series.runs()[k];
        const double away = std::abs(kept.slip - runs[r].slip) + std::abs(std::log(kept.load / runs[r].load));
        if (away >= nearest || k >= s.nominal().theta.size() || k >= used.theta.size()) continue;
        nearest = away, theta_n[r] = s.nominal().theta[k], theta_e[r] = used.theta[k];
      }
    }
    std::vector<double> cold_n(runs.size(), 0.0), cold_e = cold_n;
    return (other.predict(none, s.nominal().x, theta_n, n) || other.predict(none, s.nominal().x, cold_n, n)) &&
           (other.predict(constant, used.x, theta_e, e) || other.predict(constant, used.x, cold_e, e));
  };
  auto whole = std::make_unique<Series>(series.given(), withheld, errors_of(withheld));
  if (!answer(withheld, *whole)) {
    std::vector<Run> carried;
    std::string lines;
    for (const Run& r : withheld)
      if (answer({r}, Series(series.given(), {r}, errors_of({r}))))
        carried.push_back(r);
      else
        lines += (lines.empty() ? "" : ", ") + std::to_string(r.line);
    notes.push_back(
        "runs kept for the gain whose wheel the refitted or the extended model does not carry, left out: line " +
        lines + (carried.empty() ? "; so no gain is measured" : ""));
    withheld = std::move(carried);
    if (withheld.empty()) return std::nullopt;
    whole = std::make_unique<Series>(series.given(), withheld, errors_of(withheld));
    if (!answer(withheld, *whole)) return std::nullopt;
  }
  const Series& other = *whole;
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
  for (const auto& q : cells) g.of_conditions.push_back(q[0] > 0 ? std::sqrt(q[1] / q[0]) : 1);
  g.has_interval = cells.size() >= least_conditions;
  if (!g.has_interval) return g;
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
