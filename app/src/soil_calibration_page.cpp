// Report of a calibration: trade-off, best compromise, sensitivities, every set.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "soil_calibration.h"

namespace grouser::app {

namespace {

std::string percent(double x) { return std::isnan(x) ? "-" : fmt::format("{:.1f} %", 100 * x); }

report::Plot trade_off(const Calibration& c, const std::vector<CalibrationSet>& sets, const CalibrationSummary& s) {
  report::Plot plot{
      "Trade-off between the two tests",
      "error of direct shear [%]",
      "error of pressure-sinkage [%]",
      "Each point is a set of parameters; error: rms distance of the curve from its target over the rms of "
      "the target. Line: sets that no other one beats in both tests (Pareto). Bars: standard error of the "
      "mean over packings, in the sinkage test.",
      {},
      false,
      false};
  report::Series all{"sets tried", report::Series::Style::points, {}, {}, {}, 7},
      front{"not beaten in both (Pareto)", report::Series::Style::line, {}, {}, {}, 0},
      best{fmt::format("best compromise, weights {:g} and {:g}", c.tests[0].weight, c.tests[1].weight),
           report::Series::Style::points,
           {},
           {},
           {},
           1},
      like{"not told apart from it", report::Series::Style::points, {}, {}, {}, 2};
  std::vector<std::pair<double, double>> line;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    if (!sets[k].failure.empty()) continue;
    const double x = 100 * sets[k].misfit[0].error, y = 100 * sets[k].misfit[1].error;
    report::Series& to = k == s.best ? best : s.like_best[k] ? like : all;
    to.x.push_back(x);
    to.y.push_back(y);
    if (!std::isnan(sets[k].misfit[1].noise)) to.error.push_back(100 * sets[k].misfit[1].noise);
    if (s.front[k]) line.emplace_back(x, y);
  }
  std::sort(line.begin(), line.end());
  for (const auto& [x, y] : line) {
    front.x.push_back(x);
    front.y.push_back(y);
  }
  for (report::Series* p : {&all, &like, &front, &best})
    if (!p->x.empty()) plot.series.push_back(*p);
  return plot;
}

report::FigureTable result_table(const Calibration& c, const std::vector<CalibrationSet>& sets,
                                 const CalibrationSummary& s) {
  report::FigureTable t{"What the search found", {""}, {}};
  for (const CalibrationParameter& p : c.parameters) t.columns.push_back(p.name);
  for (const char* name : {"error, shear", "error, sinkage", "both", "noise of packings"}) t.columns.push_back(name);
  const auto add = [&](const std::string& name, const CalibrationSet& k) {
    std::vector<std::string> row{name};
    for (std::size_t p = 0; p < c.parameters.size(); ++p) row.push_back(value_text(c.parameters[p], k.values[p]));
    row.push_back(percent(k.misfit[0].error));
    row.push_back(percent(k.misfit[1].error));
    row.push_back(percent(k.total));
    row.push_back(percent(k.noise));
    t.rows.push_back(std::move(row));
  };
  add(fmt::format("best compromise (set {})", s.best + 1), sets[s.best]);
  add(fmt::format("best for direct shear (set {})", s.best_of[0] + 1), sets[s.best_of[0]]);
  add(fmt::format("best for pressure-sinkage (set {})", s.best_of[1] + 1), sets[s.best_of[1]]);
  std::vector<std::string> range{
      fmt::format("not told apart from the best: {} sets", std::count(s.like_best.begin(), s.like_best.end(), true))};
  for (std::size_t p = 0; p < c.parameters.size(); ++p)
    range.push_back(
        fmt::format("{:.3g} to {}", s.range_like[p].first, value_text(c.parameters[p], s.range_like[p].second)));
  range.resize(t.columns.size());
  t.rows.push_back(std::move(range));
  return t;
}

report::FigureTable sensitivity_table(const Calibration& c, const CalibrationSummary& s) {
  report::FigureTable t{"Sensitivity: change of the stress in % for 1 % more of a parameter, over all sets (+- 95 %)",
                        {"parameter", "direct shear", "pressure-sinkage"},
                        {}};
  for (std::size_t p = 0; p < c.parameters.size(); ++p) {
    std::vector<std::string> row{c.parameters[p].name};
    for (const auto& e : s.elasticity)
      row.push_back(e.empty()                     ? "too few sets"
                    : std::isnan(e[p].half_width) ? fmt::format("{:.2f}", e[p].value)
                                                  : fmt::format("{:.2f} +- {:.2f}", e[p].value, e[p].half_width));
    t.rows.push_back(std::move(row));
  }
  return t;
}

/// Curves of the best set, and of the best for one test alone, next to the target.
void add_curves(report::FigurePage& page, const Calibration& c, const std::vector<CalibrationSet>& sets,
                const CalibrationSummary& s, std::size_t test) {
  const CalibrationTest& t = c.tests[test];
  const bool shear = test == 0;
  for (std::size_t g = 0; g < sets[s.best].curves[test].size(); ++g) {
    const SoilGroup& group = sets[s.best].curves[test][g];
    report::Plot plot{(shear ? "Direct shear, " : "Pressure-sinkage, ") + group.curve,
                      shear ? "displacement [mm]" : "sinkage [mm]",
                      shear ? "shear stress [kPa]" : "pressure [kPa]",
                      "Mean over packings; bars: standard deviation over packings.",
                      {},
                      false,
                      false};
    const Target target(t, group);
    report::Series aim{target.source(), report::Series::Style::dashed, {}, {}, {}, 7};
    const double last = group.x.back();
    for (int k = 0; k <= 200; ++k) {
      const double x = last * k / 200, y = target(x);
      if (std::isnan(y)) continue;
      aim.x.push_back(1e3 * x);
      aim.y.push_back(1e-3 * y);
    }
    const auto line = [&](const std::string& name, const CalibrationSet& k, int colour, bool bars) {
      const SoilGroup& from = k.curves[test].at(g);
      const auto column = static_cast<std::size_t>(std::find(from.columns.begin(), from.columns.end(), t.column) -
                                                   from.columns.begin());
      report::Series out{name, report::Series::Style::line, {}, {}, {}, colour};
      for (std::size_t i = 0; i < from.x.size(); ++i) {
        out.x.push_back(1e3 * from.x[i]);
        out.y.push_back(1e-3 * from.mean[column][i]);
        if (bars) out.error.push_back(1e-3 * from.sd[column][i]);
      }
      plot.series.push_back(std::move(out));
    };
    line("best compromise", sets[s.best], 1, group.packings > 1);
    if (s.best_of[test] != s.best) line("best for this test", sets[s.best_of[test]], 0, false);
    plot.series.push_back(std::move(aim));
    page.items.push_back(std::move(plot));
  }
}

report::FigureTable all_sets(const Calibration& c, const std::vector<CalibrationSet>& sets,
                             const CalibrationSummary& s) {
  report::FigureTable t{"Every set, in the order tried", {"set"}, {}};
  for (const CalibrationParameter& p : c.parameters) t.columns.push_back(p.name);
  for (const char* name : {"error, shear", "error, sinkage", "both", ""}) t.columns.push_back(name);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    std::vector<std::string> row{std::to_string(k + 1)};
    for (std::size_t p = 0; p < c.parameters.size(); ++p) row.push_back(value_text(c.parameters[p], sets[k].values[p]));
    row.push_back(percent(sets[k].misfit[0].error));
    row.push_back(percent(sets[k].misfit[1].error));
    row.push_back(percent(sets[k].total));
    row.push_back(!sets[k].failure.empty() ? sets[k].failure
                  : k == s.best            ? "best"
                  : s.like_best[k]         ? "like the best"
                  : s.front[k]             ? "Pareto"
                                           : "");
    t.rows.push_back(std::move(row));
  }
  return t;
}

}  // namespace

report::FigurePage calibration_page(const Calibration& c, const std::vector<CalibrationSet>& sets) {
  report::FigurePage page{c.title,
                          fmt::format("{} sets of parameters tried, {} asked for at most; {}", sets.size(),
                                      c.search.most, c.file.filename().string()),
                          {}};
  if (std::all_of(sets.begin(), sets.end(), [](const CalibrationSet& k) { return !k.failure.empty(); })) return page;
  const CalibrationSummary s = summarize(c, sets);
  page.items.push_back(result_table(c, sets, s));
  page.items.push_back(trade_off(c, sets, s));
  page.items.push_back(sensitivity_table(c, s));
  for (std::size_t t = 0; t < 2; ++t) add_curves(page, c, sets, s, t);
  page.items.push_back(all_sets(c, sets, s));
  page.items.push_back(report::Paragraph{fmt::format(
      "Search: {} sets that fill the space between the bounds (Sobol, shifted by seed {}), then {} from the best of "
      "them, on "
      "logarithmic scales. Sets are not told apart from the best where the square of their error is within that of the "
      "best and of the noise: the standard error of the mean curve over packings.",
      c.search.first, c.search.seed, c.search.method)});
  return page;
}

std::string sets_csv(const Calibration& c, const std::vector<CalibrationSet>& sets) {
  std::string out = "set";
  for (const CalibrationParameter& p : c.parameters)
    out += "," + p.name + (p.unit == "Pa" ? "_Pa" : p.unit == "1" ? "" : "_s2_m2");
  out += ",shear_error,sinkage_error,error,shear_noise,sinkage_noise,pareto,best\n";
  if (sets.empty()) return out;
  const CalibrationSummary s = summarize(c, sets);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    out += std::to_string(k + 1);
    for (double v : sets[k].values) out += fmt::format(",{:.9g}", v);
    out += fmt::format(",{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:d},{:d}\n", sets[k].misfit[0].error,
                       sets[k].misfit[1].error, sets[k].total, sets[k].misfit[0].noise, sets[k].misfit[1].noise,
                       static_cast<int>(s.front[k]), static_cast<int>(k == s.best));
  }
  return out;
}

}  // namespace grouser::app
