#include "needed.h"

#include <algorithm>
#include <cmath>

namespace grouser::diagnosis {

std::vector<Needed> needed_by_refit(const Search& s) {
  const Series& series = s.series();
  const Fit& nominal = s.nominal();
  std::vector<std::vector<std::size_t>> sets;
  for (std::size_t i = 0; i < soil_count; ++i)
    if (series.given().soil[i].sd > 0) sets.push_back({i});
  if (series.given().soil[5].sd > 0 && series.given().soil[6].sd > 0) sets.push_back({5, 6});
  std::vector<Needed> out;
  for (const auto& held : sets) {
    DiagnosisCase c = series.given();
    for (const std::size_t i : held) c.soil[i].sd = 0;
    const Series fewer(c, series.runs(), s.stated_sd());
    const auto is_held = [&](int input) {
      return std::find(held.begin(), held.end(), static_cast<std::size_t>(input)) != held.end();
    };
    Eigen::VectorXd x(fewer.soil_parameters());
    Needed n;
    for (int i = 0, at = 0; i < series.soil_parameters(); ++i) {
      const Parameter& p = series.parameter(i);
      if (!is_held(p.input)) x[at++] = nominal.x[i];
      if (!is_held(p.input)) continue;
      n.held.push_back(p.name);
      if (n.held.size() == 1) n.prior_z = (nominal.x[i] - p.mean) / p.sd;
    }
    Fit f = fewer.fit(nominal_candidate(), s.whitener(), x, nominal.theta, 25);
    const Fit g = fewer.fit(nominal_candidate(), s.whitener(), fewer.prior_mean(), nominal.theta, 25);
    if (g.ok && (!f.ok || g.objective() < f.objective())) f = g;
    if (!f.ok) continue;
    n.rise = std::max(0.0, f.objective() - nominal.objective());
    std::array<int, channel_count> count{};
    for (int i = 0; i < fewer.layout().size(); ++i) {
      const auto ch = static_cast<std::size_t>(fewer.layout()[i].channel);
      n.rmse[ch] += f.residual[i] * f.residual[i], ++count[ch];
    }
    for (std::size_t ch = 0; ch < channel_count; ++ch)
      n.rmse[ch] = count[ch] ? std::sqrt(n.rmse[ch] / count[ch]) : std::numeric_limits<double>::quiet_NaN();
    out.push_back(std::move(n));
  }
  std::stable_sort(out.begin(), out.end(), [](const Needed& a, const Needed& b) { return a.rise > b.rise; });
  return out;
}

std::vector<JudgedValue> judge_soil(const DiagnosisCase& c) {
  std::vector<JudgedValue> out;
  for (std::size_t i = 0; i < soil_count; ++i) {
    if (!c.judged[i] || !(c.soil[i].sd > 0)) continue;
    const SoilCoordinate& k = soil_coordinates()[i];
    const auto plain = [&](double x) { return k.logarithmic ? std::exp(x) : x; };
    out.push_back(
        {k.name, k.unit, plain(*c.judged[i]), plain(c.soil[i].mean), (*c.judged[i] - c.soil[i].mean) / c.soil[i].sd});
  }
  return out;
}

}  // namespace grouser::diagnosis
