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

/// Loads that stand for one: within 15 % of each other (dead weights are never quite the same), at most four groups.
std::vector<std::vector<std::size_t>> load_groups(const Diagnosis& d, std::size_t ch) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < d.runs.size(); ++i)
    if (std::isfinite(d.runs[i].value[ch])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return d.runs[a].load < d.runs[b].load; });
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t i : order) {
    if (groups.empty() || d.runs[i].load > 1.15 * d.runs[groups.back()[0]].load) groups.emplace_back();
    groups.back().push_back(i);
  }
  while (groups.size() > 4) {  // the narrowest step goes
    std::size_t at = 1;
    double least = INFINITY;
    for (std::size_t g = 1; g < groups.size(); ++g) {
      const double step = d.runs[groups[g][0]].load / d.runs[groups[g - 1][0]].load;
      if (step < least) least = step, at = g;
    }
    groups[at - 1].insert(groups[at - 1].end(), groups[at].begin(), groups[at].end());
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return groups;
}

/// Mean and scatter of a channel over the runs of one slip and load.
void add_data(const Diagnosis& d, std::size_t ch, report::FigurePage& page) {
  const auto groups = load_groups(d, ch);
  if (groups.empty()) return;
  const bool stated = d.stated && groups.size() <= 2;
  report::Plot p{
      fmt::format("Measured {} against the models", channel_names()[ch].short_name),
      "slip [-]",
      fmt::format("{} [{}]", channel_names()[ch].short_name, shown_unit[ch]),
      fmt::format(
          "Points: mean of the runs at one slip and load; bar: their sd (other speeds and passes included), "
          "of a single run the noise found. Dashed: {}nominal model with its soil refitted. Line: extended model.",
          stated ? "the model as the case states it, and the " : ""),
      {},
      false,
      false};
  int colour = 0;
  for (const auto& group : groups) {
    std::map<long, std::vector<std::size_t>> by_slip;
    double load = 0;
    for (const std::size_t i : group) {
      by_slip[std::lround(d.runs[i].slip * 100)].push_back(i);
      load += d.runs[i].load / static_cast<double>(group.size());
    }
    const std::string name = fmt::format("{:.3g} N", load);
    Series points{name, Series::Style::points, {}, {}, {}, colour};
    Series as_stated{name + ", as stated", Series::Style::dashed, {}, {}, {}, colour + 4};
    Series nominal{name + ", refitted", Series::Style::dashed, {}, {}, {}, colour};
    Series extended{name + ", extended", Series::Style::line, {}, {}, {}, colour};
    for (const auto& [slip, list] : by_slip) {
      double x = 0, y = 0, o = 0, n = 0, e = 0, square = 0, sd = 0;
      for (const std::size_t i : list) {
        x += d.runs[i].slip, y += d.runs[i].value[ch], sd += d.sd[i][ch];
        n += d.nominal.predicted[i][ch], e += d.extended.predicted[i][ch];
        if (stated) o += d.stated->predicted[i][ch];
      }
      const double m = static_cast<double>(list.size());
      for (const std::size_t i : list) square += std::pow(d.runs[i].value[ch] - y / m, 2);
      for (Series* s : {&points, &as_stated, &nominal, &extended}) s->x.push_back(x / m);
      points.y.push_back(y / m * shown_scale[ch]);
      points.error.push_back((m > 1 ? std::sqrt(square / (m - 1)) : sd) * shown_scale[ch]);
      as_stated.y.push_back(o / m * shown_scale[ch]);
      nominal.y.push_back(n / m * shown_scale[ch]);
      extended.y.push_back(e / m * shown_scale[ch]);
    }
    p.series.push_back(points);
    if (stated) p.series.push_back(as_stated);
    p.series.push_back(nominal);
    if (d.verdict != "adequate" && d.verdict != "parameter") p.series.push_back(extended);
    ++colour;
  }
  page.items.push_back(std::move(p));
}

/// One sd to each side of zero: what is inside is noise.
void add_band(const Diagnosis& d, std::size_t ch, report::Plot& p) {
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < d.runs.size(); ++i)
    if (std::isfinite(d.runs[i].value[ch])) sum += d.sd[i][ch], ++n;
  const auto [low, high] = std::minmax_element(p.series[0].x.begin(), p.series[0].x.end());
  const double sd = sum / n * shown_scale[ch], gap = std::numeric_limits<double>::quiet_NaN();
  p.series.push_back(
      {"one sd", Series::Style::dashed, {*low, *high, *high, *low, *high}, {sd, sd, gap, -sd, -sd}, {}, 7});
}

void add_residuals(const Diagnosis& d, std::size_t ch, report::FigurePage& page) {
  for (const Axis& a : axes()) {
    if (std::string(a.name) == "order" && std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& n) {
          return n.rfind("no column 'order'", 0) == 0;
        }))
      continue;  // the order of the lines is not that of the runs
    std::map<long, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < d.runs.size(); ++i)
      if (std::isfinite(d.runs[i].value[ch]))
        groups[std::lround(a.of(d.runs[i]) * (std::string(a.name) == "order" ? 12 : 1e5))].push_back(i);
    if (groups.size() < 2) continue;
    report::Plot p{fmt::format("Residual of {} over {}", channel_names()[ch].short_name, a.name),
                   a.label,
                   fmt::format("measured - model [{}]", shown_unit[ch]),
                   "Mean of the runs at one value, bar: standard error of the mean, of a single run the noise found. "
                   "Dashed: the noise of one run, one sd to each side.",
                   {},
                   false,
                   false};
    const FittedModel* models[] = {&d.nominal, &d.extended};
    const char* names[] = {"nominal, refitted", "extended"};
    for (int k = 0; k < 2; ++k) {
      Series s{names[k], Series::Style::points, {}, {}, {}, k};
      for (const auto& [key, list] : groups) {
        double sum = 0, square = 0, x = 0, sd = 0;
        for (const std::size_t i : list) {
          const double r = d.runs[i].value[ch] - models[k]->predicted[i][ch];
          sum += r, square += r * r, x += a.of(d.runs[i]), sd += d.sd[i][ch];
        }
        const double m = static_cast<double>(list.size());
        s.x.push_back(x / m);
        s.y.push_back(sum / m * shown_scale[ch]);
        s.error.push_back(m > 1 ? std::sqrt(std::max(square / m - sum / m * sum / m, 0.0) / (m - 1)) * shown_scale[ch]
                                : sd * shown_scale[ch]);
      }
      p.series.push_back(std::move(s));
    }
    add_band(d, ch, p);
    page.items.push_back(std::move(p));
  }
}

report::FigureTable ranking(const Diagnosis& d) {
  report::FigureTable t{"Ranking of the causes",
                        {"cause", "gain in ln likelihood", "ln evidence", "probability", "gain on runs left out",
                         "amplitude", "times the ordinary size", "how"},
                        {}};
  for (const Ranked& r : d.ranking) {
    if (t.rows.size() >= 12) break;
    std::string amplitude, times;
    for (const Interval& i : r.amplitudes) times += (times.empty() ? "" : "; ") + number(i.times_typical, 2);
    for (const Interval& i : r.amplitudes)
      amplitude += (amplitude.empty() ? "" : "; ") +
                   fmt::format("{} [{}, {}] {}", number(i.value, 3), number(i.low, 3), number(i.high, 3),
                               i.unit == "1" ? "" : i.unit) +
                   (i.at_bound ? " (at its bound)" : "");
    t.rows.push_back({r.id, number(r.log_likelihood), number(r.log_evidence), number(r.posterior, 3),
                      number(r.cross_validation, 3), amplitude, times,
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

/// "254 kPa times or by 1.35", "0.606 +- 0.05"
std::string prior_text(const DiagnosisCase& c, const std::string& name) {
  for (std::size_t i = 0; i < soil_count; ++i) {
    const SoilCoordinate& k = soil_coordinates()[i];
    if (name != k.name) continue;
    return k.logarithmic
               ? fmt::format("{} times or over {}", number(std::exp(c.soil[i].mean)), number(std::exp(c.soil[i].sd), 3))
               : fmt::format("{} +- {}", number(c.soil[i].mean), number(c.soil[i].sd, 2));
  }
  for (const KnownEffect& k : c.known)
    if (k.id == name) return fmt::format("{} +- {}", number(k.value), number(k.sd, 2));
  return "-";
}

report::FigureTable parameters(const Diagnosis& d, const DiagnosisCase& c) {
  report::FigureTable t{"Soil against its priors; sd over prior sd near 1: these runs do not see it",
                        {"parameter", "unit", "as stated", "refitted", "in prior sd", "sd over prior sd",
                         "with the cause", "in prior sd"},
                        {}};
  const auto value = [](const FittedValue& v) { return fmt::format("{} +- {}", number(v.value), number(v.sd, 2)); };
  for (const auto& [name, v] : d.nominal.parameters) {
    const auto e = d.extended.parameters.find(name);
    const bool there = e != d.extended.parameters.end();
    t.rows.push_back({name, v.unit, prior_text(c, name), value(v), number(v.prior_z, 2), number(v.sd_over_prior, 2),
                      there ? value(e->second) : "-", there ? number(e->second.prior_z, 2) : "-"});
  }
  return t;
}

report::FigureTable needed(const Diagnosis& d) {
  report::FigureTable t{"What the refit needed: values held where the case has them, all others refitted",
                        {"held", "rise of chi2", "error of drawbar [N]", "of torque [N m]", "of sinkage [mm]"},
                        {}};
  const auto row = [&](const std::string& name, const std::string& rise,
                       const std::array<double, channel_count>& rmse) {
    t.rows.push_back({name, rise, number(rmse[0], 3), number(rmse[1], 3), number(rmse[2] * 1000, 3)});
  };
  if (d.stated) row("everything (as stated)", number(d.stated->chi2 - d.nominal.chi2, 3), d.stated->rmse);
  for (const Needed& n : d.needed) row(fmt::format("{}", fmt::join(n.held, " and ")), number(n.rise, 3), n.rmse);
  row("nothing (refitted)", "0", d.nominal.rmse);
  return t;
}

report::FigureTable judged(const Diagnosis& d) {
  report::FigureTable t{"Soil to be judged, under the priors of the case",
                        {"parameter", "unit", "value", "prior", "prior sd apart", "says"},
                        {}};
  for (const JudgedValue& j : d.judged)
    t.rows.push_back({j.name, j.unit, number(j.value), number(j.prior), number(j.z, 2),
                      std::abs(j.z) > 3 ? "structural" : "within its prior"});
  return t;
}

void add_statics(const Diagnosis& d, const DiagnosisCase& c, report::FigurePage& page) {
  if (d.statics.size() < 2) return;
  report::Plot friction{"Before any model: friction that the wheel mobilised",
                        "slip [-]",
                        "S/N [-]",
                        "Shear over normal resultant of the contact, from drawbar, torque and load of each row. "
                        "Dashed: tan phi of the case.",
                        {},
                        false,
                        false};
  report::Plot place{
      "Before any model: where the soil pushes",
      "slip [-]",
      "theta/theta_f [-]",
      "Place of the resultant on the arc of contact, from drawbar, torque and sinkage of each row. Above 1 it lies "
      "outside of the contact: the channels contradict each other, whatever the soil.",
      {},
      false,
      false};
  Series s{"rows", Series::Style::points, {}, {}, {}, 0}, t = s;
  for (const RowStatics& r : d.statics) {
    s.x.push_back(r.slip), s.y.push_back(r.friction), s.error.push_back(r.friction_sd);
    t.x.push_back(r.slip), t.y.push_back(r.theta / r.theta_f), t.error.push_back(r.theta_sd / r.theta_f);
  }
  const auto [low, high] = std::minmax_element(s.x.begin(), s.x.end());
  const double tan_phi = std::tan(c.soil[3].mean);
  friction.series = {s, {"tan phi", Series::Style::dashed, {*low, *high}, {tan_phi, tan_phi}, {}, 7}};
  place.series = {t, {"front of the contact", Series::Style::dashed, {*low, *high}, {1, 1}, {}, 7}};
  page.items.push_back(std::move(friction));
  page.items.push_back(std::move(place));
}

report::FigureTable next(const Diagnosis& d) {
  report::FigureTable t{
      "What would decide", {"run or check", "decides", "chance that the odds pass 10:1", "cost [runs]"}, {}};
  for (const NextExperiment& e : d.next) {
    std::string what = e.bench_check;
    for (const auto& [name, x] : e.condition)
      what += (what.empty() ? "" : ", ") + fmt::format("{} {}", name, number(x, 3));
    if (e.runs > 0) what += fmt::format("; {} {}", e.runs, e.bench_check.empty() ? "repeats" : "readings");
    t.rows.push_back({what, fmt::format("{}", fmt::join(e.decides, " / ")),
                      number(e.chance, 2) +
                          (e.simulated ? fmt::format(" (simulated with refits: {})", number(*e.simulated, 2)) : ""),
                      number(e.cost, 2)});
  }
  return t;
}

}  // namespace

report::FigurePage diagnose_page(const Diagnosis& d, const DiagnosisCase& c, const std::string& data) {
  report::FigurePage page{fmt::format("{} against {} ({})", data, c.model, c.file.stem().string()), d.sentence, {}};
  for (std::size_t ch = 0; ch < channel_count; ++ch) add_data(d, ch, page);
  page.items.push_back(ranking(d));
  if (!d.next.empty()) page.items.push_back(next(d));
  page.items.push_back(needed(d));
  page.items.push_back(parameters(d, c));
  if (!d.judged.empty()) page.items.push_back(judged(d));
  for (std::size_t ch = 0; ch < channel_count; ++ch) add_residuals(d, ch, page);
  add_statics(d, c, page);
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
