#include "diagnose_page.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

namespace grouser::app {

namespace {

using namespace diagnosis;
using report::Series;

constexpr double shown_scale[channel_count] = {1, 1, 1000};
constexpr const char* shown_unit[channel_count] = {"N", "N m", "mm"};

std::string number(double x, int digits = 4) { return std::isfinite(x) ? fmt::format("{:.{}g}", x, digits) : "-"; }

struct Axis {
  const char *name, *label;
  std::function<double(const Run&)> of;
};
const std::vector<Axis>& axes() {
  static const std::vector<Axis> list{
      {"slip", "slip [-]", [](const Run& r) { return r.slip; }},
      {"load", "load [N]", [](const Run& r) { return r.load; }},
      {"speed", "angular speed [rad/s]", [](const Run& r) { return r.omega; }},
      {"pass", "pass [-]", [](const Run& r) { return static_cast<double>(r.pass); }},
      {"order", "order of the run, 0 first, 1 last [-]", [](const Run& r) { return r.order; }}};
  return list;
}

/// Mean and scatter of a channel over the runs of one slip and load.
void add_data(const Diagnosis& d, std::size_t ch, report::FigurePage& page) {
  std::map<double, std::map<double, std::vector<std::size_t>>> by_load;
  for (std::size_t i = 0; i < d.runs.size(); ++i)
    if (std::isfinite(d.runs[i].value[ch])) by_load[d.runs[i].load][d.runs[i].slip].push_back(i);
  if (by_load.empty()) return;
  report::Plot p{fmt::format("Measured {} against both models", channel_names()[ch].short_name),
                 "slip [-]",
                 fmt::format("{} [{}]", channel_names()[ch].short_name, shown_unit[ch]),
                 "Points: mean of the runs at one slip and load, bar: their sd (other speeds and passes included). "
                 "Dashed: nominal model, refitted. Line: extended model.",
                 {},
                 false,
                 false};
  // At most four loads, or the picture says nothing.
  std::vector<double> loads;
  for (const auto& [load, x] : by_load) loads.push_back(load);
  const std::size_t step = (loads.size() + 3) / 4;
  int colour = 0;
  for (std::size_t k = 0; k < loads.size(); k += step, ++colour) {
    Series points{fmt::format("{:.4g} N", loads[k]), Series::Style::points, {}, {}, {}, colour};
    Series nominal{fmt::format("{:.4g} N, nominal", loads[k]), Series::Style::dashed, {}, {}, {}, colour};
    Series extended{fmt::format("{:.4g} N, extended", loads[k]), Series::Style::line, {}, {}, {}, colour};
    for (const auto& [slip, list] : by_load[loads[k]]) {
      double y = 0, n = 0, e = 0, square = 0;
      for (const std::size_t i : list)
        y += d.runs[i].value[ch], n += d.nominal.predicted[i][ch], e += d.extended.predicted[i][ch];
      const double m = static_cast<double>(list.size());
      for (const std::size_t i : list) square += std::pow(d.runs[i].value[ch] - y / m, 2);
      for (Series* s : {&points, &nominal, &extended}) s->x.push_back(slip);
      points.y.push_back(y / m * shown_scale[ch]);
      points.error.push_back(m > 1 ? std::sqrt(square / (m - 1)) * shown_scale[ch] : 0);
      nominal.y.push_back(n / m * shown_scale[ch]);
      extended.y.push_back(e / m * shown_scale[ch]);
    }
    for (Series* s : {&points, &nominal, &extended}) p.series.push_back(*s);
  }
  page.items.push_back(std::move(p));
}

void add_residuals(const Diagnosis& d, std::size_t ch, report::FigurePage& page) {
  for (const Axis& a : axes()) {
    std::map<long, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < d.runs.size(); ++i)
      if (std::isfinite(d.runs[i].value[ch]))
        groups[std::lround(a.of(d.runs[i]) * (std::string(a.name) == "order" ? 12 : 1e5))].push_back(i);
    if (groups.size() < 2) continue;
    report::Plot p{fmt::format("Residual of {} over {}", channel_names()[ch].short_name, a.name),
                   a.label,
                   fmt::format("measured - model [{}]", shown_unit[ch]),
                   "Mean of the runs at one value, bar: standard error of the mean.",
                   {},
                   false,
                   false};
    const FittedModel* models[] = {&d.nominal, &d.extended};
    const char* names[] = {"nominal, refitted", "extended"};
    for (int k = 0; k < 2; ++k) {
      Series s{names[k], Series::Style::points, {}, {}, {}, k};
      for (const auto& [key, list] : groups) {
        double sum = 0, square = 0, x = 0;
        for (const std::size_t i : list) {
          const double r = d.runs[i].value[ch] - models[k]->predicted[i][ch];
          sum += r, square += r * r, x += a.of(d.runs[i]);
        }
        const double m = static_cast<double>(list.size());
        s.x.push_back(x / m);
        s.y.push_back(sum / m * shown_scale[ch]);
        s.error.push_back(m > 1 ? std::sqrt(std::max(square / m - sum / m * sum / m, 0.0) / (m - 1)) * shown_scale[ch]
                                : 0);
      }
      p.series.push_back(std::move(s));
    }
    page.items.push_back(std::move(p));
  }
}

report::FigureTable ranking(const Diagnosis& d) {
  report::FigureTable t{
      "Ranking of the causes",
      {"cause", "gain in ln likelihood", "ln evidence", "probability", "gain on runs left out", "amplitude", "how"},
      {}};
  for (const Ranked& r : d.ranking) {
    if (t.rows.size() >= 12) break;
    std::string amplitude;
    for (const Interval& i : r.amplitudes)
      amplitude += (amplitude.empty() ? "" : "; ") +
                   fmt::format("{} [{}, {}] {}", number(i.value, 3), number(i.low, 3), number(i.high, 3),
                               i.unit == "1" ? "" : i.unit) +
                   (i.at_bound ? " (at its bound)" : "");
    t.rows.push_back({r.id, number(r.log_likelihood), number(r.log_evidence), number(r.posterior, 3),
                      number(r.cross_validation, 3), amplitude,
                      r.refitted ? "refitted" : "slope at the nominal model"});
  }
  return t;
}

report::FigureTable left_over(const Diagnosis& d) {
  report::FigureTable t{"What the models leave over", {"model", "test", "about", "statistic", "p", "p after Holm"}, {}};
  for (const auto& [name, tests] :
       {std::pair{"nominal, refitted", &d.nominal.tests}, std::pair{"extended", &d.extended.tests}})
    for (const FitTest& f : *tests)
      t.rows.push_back({name, f.test, f.about, number(f.statistic, 3), number(f.p, 2), number(f.holm, 2)});
  return t;
}

report::FigureTable parameters(const Diagnosis& d) {
  report::FigureTable t{
      "Soil against its priors", {"parameter", "unit", "nominal refit", "prior z", "with the cause", "prior z"}, {}};
  for (const auto& [name, v] : d.nominal.parameters) {
    const auto e = d.extended.parameters.find(name);
    t.rows.push_back({name, v.unit, number(v.value), number(v.prior_z, 2),
                      e == d.extended.parameters.end() ? "-" : number(e->second.value),
                      e == d.extended.parameters.end() ? "-" : number(e->second.prior_z, 2)});
  }
  return t;
}

report::FigureTable next(const Diagnosis& d) {
  report::FigureTable t{
      "What would decide", {"run or check", "decides", "chance that the odds pass 10:1", "cost [runs]"}, {}};
  for (const NextExperiment& e : d.next) {
    std::string what = e.bench_check;
    for (const auto& [name, x] : e.condition)
      what += (what.empty() ? "" : ", ") + fmt::format("{} {}", name, number(x, 3));
    if (e.runs > 0) what += fmt::format("; {} repeats", e.runs);
    t.rows.push_back({what, fmt::format("{}", fmt::join(e.decides, " / ")),
                      number(e.chance, 2) +
                          (e.simulated ? fmt::format(" (simulated with refits: {})", number(*e.simulated, 2)) : ""),
                      number(e.cost, 2)});
  }
  return t;
}

}  // namespace

report::FigurePage diagnose_page(const Diagnosis& d, const DiagnosisCase& c) {
  report::FigurePage page{"Diagnosis of " + c.model, d.sentence, {}};
  page.items.push_back(ranking(d));
  if (!d.next.empty()) page.items.push_back(next(d));
  for (std::size_t ch = 0; ch < channel_count; ++ch) add_data(d, ch, page);
  for (std::size_t ch = 0; ch < channel_count; ++ch) add_residuals(d, ch, page);
  page.items.push_back(parameters(d));
  page.items.push_back(left_over(d));
  if (d.unknown_curve.size() > 1) {
    report::Plot p{fmt::format("Change of {} with {}", d.unknown_through, d.unknown_variable),
                   d.unknown_variable,
                   "change of " + d.unknown_through,
                   "Of the logarithm for k and K. Nothing is said beyond the points.",
                   {},
                   false,
                   false};
    Series s{"what the runs ask for", Series::Style::line, {}, {}, {}, 0};
    for (const auto& [x, y] : d.unknown_curve) s.x.push_back(x), s.y.push_back(y);
    p.series.push_back(std::move(s));
    page.items.push_back(std::move(p));
  }
  if (d.gain) {
    report::FigureTable t{fmt::format("Runs never used: {} ({} runs)", fmt::join(d.gain->withheld, ", "), d.gain->runs),
                          {"channel", "error, nominal", "error, extended", "unit"},
                          {}};
    for (std::size_t ch = 0; ch < channel_count; ++ch)
      t.rows.push_back({channel_names()[ch].short_name, number(d.gain->nominal_rmse[ch] * shown_scale[ch]),
                        number(d.gain->extended_rmse[ch] * shown_scale[ch]), shown_unit[ch]});
    page.items.push_back(std::move(t));
  }
  std::string notes = fmt::format(
      "Noise found: {:.3g}, {:.3g} and {:.3g} times the stated sd of drawbar, torque and sinkage; from run to run ln k "
      "scatters by {:.2g} and phi by {:.2g} rad.",
      d.noise_scale[0], d.noise_scale[1], d.noise_scale[2], d.scatter_ln_k, d.scatter_phi);
  if (!d.suspect_lines.empty())
    notes += fmt::format("\n\nSuspect rows (line of the file): {}.", fmt::join(d.suspect_lines, ", "));
  for (const std::string& n : d.notes) notes += "\n\n" + n + ".";
  page.items.push_back(report::Paragraph{notes});
  return page;
}

}  // namespace grouser::app
