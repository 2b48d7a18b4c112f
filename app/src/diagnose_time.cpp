#include "diagnose_time.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "diagnose_json.h"
#include "figure_page.h"
#include "grouser/diagnosis/time_series.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

using namespace diagnosis;
using Json = nlohmann::ordered_json;

constexpr double shown_scale[channel_count] = {1, 1, 1000};
constexpr const char* shown_unit[channel_count] = {"N", "N m", "mm"};

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw ResultsError(file.string() + ": cannot be written; is the folder writable?");
}

Json noise_json(const std::array<TimeNoise, channel_count>& noise, const Diagnosis& d) {
  Json j = Json::object();
  for (std::size_t c = 0; c < channel_count; ++c)
    if (std::isfinite(d.nominal.rmse[c]))
      j[channel_names()[c].column] = {{"scale", noise[c].scale}, {"neighbour_correlation", noise[c].rho}};
  return j;
}

Json time_json(const TimeDiagnosis& t, const TimeCase& c) {
  Json j = diagnosis_json(t.d);
  Json gate = Json::array();
  for (const auto& test : t.gate) gate.push_back({{"about", test.about}, {"p", test.p}});
  j["series"] = {{"relaxation_over", c.options.relaxation_over()},
                 {"noise_nominal", noise_json(t.nominal_noise, t.d)},
                 {"noise_extended", noise_json(t.extended_noise, t.d)},
                 {"gate", gate},
                 {"physics", t.physics}};
  return j;
}

std::string series_csv(const Diagnosis& d) {
  std::string out = "line,batch,time_s,slip,load_N,omega_rad_s";
  for (std::size_t c = 0; c < channel_count; ++c)
    if (std::isfinite(d.nominal.rmse[c]))
      out += fmt::format(",{0}_measured,{0}_nominal,{0}_extended,{0}_sd", channel_names()[c].column);
  const auto cell = [](double x) { return std::isfinite(x) ? fmt::format(",{:.6g}", x) : std::string(","); };
  for (std::size_t i = 0; i < d.runs.size(); ++i) {
    const Run& r = d.runs[i];
    out += fmt::format("\n{},{},{:.6g},{:.6g},{:.6g},{:.6g}", r.line, r.batch + 1, r.time, r.slip, r.load, r.omega);
    for (std::size_t c = 0; c < channel_count; ++c)
      if (std::isfinite(d.nominal.rmse[c]))
        for (const double x : {r.value[c], d.nominal.predicted[i][c], d.extended.predicted[i][c], d.sd[i][c]})
          out += cell(x);
  }
  return out + "\n";
}

std::string number(double x, int digits = 3) { return std::isfinite(x) ? fmt::format("{:.{}g}", x, digits) : "-"; }

std::string shown(const Interval& i) {
  const double f = i.unit == "m" ? 1000 : 1;
  return fmt::format("{} [{}, {}] {}{}", number(i.value * f), number(i.low * f), number(i.high * f),
                     i.unit == "m" ? "mm" : i.unit, i.at_bound ? " (at its bound)" : "");
}

std::string condition(const NextExperiment& e) {
  if (!e.bench_check.empty()) return e.bench_check;
  std::string out;
  for (const auto& [name, x] : e.condition) out += fmt::format("{}{} {:.3g}", out.empty() ? "" : ", ", name, x);
  return out;
}

/// Runs to show: first, middle and last.
std::vector<std::pair<std::size_t, std::size_t>> shown_runs(const Diagnosis& d) {
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (std::size_t i = 0; i < d.runs.size(); ++i) {
    if (i == 0 || d.runs[i].batch != d.runs[i - 1].batch) all.emplace_back(i, i);
    all.back().second = i + 1;
  }
  if (all.size() <= 3) return all;
  return {all.front(), all[all.size() / 2], all.back()};
}

report::FigurePage time_page(const TimeDiagnosis& t, const TimeCase& c) {
  const Diagnosis& d = t.d;
  using report::Series;
  report::FigurePage page{"Diagnosis of a series: " + c.steady.model, d.sentence, {}};
  report::FigureTable ranking{
      "Ranking of the accounts",
      {"account", "gain in ln likelihood", "ln evidence", "probability", "gain on runs left out", "size [90 %]"},
      {}};
  for (const Ranked& r : d.ranking) {
    std::string size;
    for (const Interval& i : r.amplitudes) size += (size.empty() ? "" : "; ") + shown(i);
    ranking.rows.push_back({r.id, number(r.log_likelihood, 4), number(r.log_evidence, 4), number(r.posterior),
                            number(r.cross_validation), size});
  }
  page.items.push_back(ranking);
  if (!d.next.empty()) {
    report::FigureTable next{
        "What would decide", {"run or check", "decides", "chance that the odds pass 10:1", "cost [runs]"}, {}};
    for (const NextExperiment& e : d.next)
      next.rows.push_back(
          {condition(e), fmt::format("{}", fmt::join(e.decides, " / ")),
           number(e.chance) + (e.simulated ? fmt::format(" (simulated with refits: {})", number(*e.simulated)) : ""),
           number(e.cost, 2)});
    page.items.push_back(next);
  }
  for (std::size_t ch = 0; ch < channel_count; ++ch) {
    if (!std::isfinite(d.nominal.rmse[ch])) continue;
    const std::string name = channel_names()[ch].short_name, unit = shown_unit[ch];
    report::Plot value{
        "Measured " + name + " over time",
        "time [s]",
        name + " [" + unit + "]",
        "Points: measured. Dashed: the steady wheel with its soil refitted. Line: with the account found.",
        {},
        false,
        false};
    report::Plot residual{"Residual of " + name,
                          "time [s]",
                          "measured - model [" + unit + "]",
                          "What each model leaves over, the run with the largest misfit of those shown.",
                          {},
                          false,
                          false};
    int colour = 0;
    double worst = -1;
    for (const auto& [from, to] : shown_runs(d)) {
      const std::string run = fmt::format("run {}", d.runs[from].batch + 1);
      Series points{run, Series::Style::points, {}, {}, {}, colour},
          nominal{run + ", steady", Series::Style::dashed, {}, {}, {}, colour},
          extended{run + ", extended", Series::Style::line, {}, {}, {}, colour};
      Series left_n{"steady wheel", Series::Style::dashed, {}, {}, {}, 0},
          left_e{"extended", Series::Style::line, {}, {}, {}, 1};
      double square = 0;
      for (std::size_t i = from; i < to; ++i) {
        const double y = d.runs[i].value[ch] * shown_scale[ch], n = d.nominal.predicted[i][ch] * shown_scale[ch],
                     e = d.extended.predicted[i][ch] * shown_scale[ch], when = d.runs[i].time;
        for (Series* s : {&nominal, &extended}) s->x.push_back(when);
        nominal.y.push_back(n), extended.y.push_back(e);
        if (!std::isfinite(y)) continue;
        for (Series* s : {&points, &left_n, &left_e}) s->x.push_back(when);
        points.y.push_back(y), left_n.y.push_back(y - n), left_e.y.push_back(y - e);
        square += (y - n) * (y - n);
      }
      for (Series* s : {&points, &nominal, &extended}) value.series.push_back(*s);
      if (square > worst) worst = square, residual.series = {left_n, left_e};
      ++colour;
    }
    page.items.push_back(value);
    page.items.push_back(residual);
  }
  report::FigureTable soil{
      "Soil against its priors", {"parameter", "unit", "steady wheel", "prior z", "with the account", "prior z"}, {}};
  for (const auto& [name, v] : d.nominal.parameters) {
    const auto& e = d.extended.parameters.at(name);
    soil.rows.push_back(
        {name, v.unit, number(v.value, 4), number(v.prior_z, 2), number(e.value, 4), number(e.prior_z, 2)});
  }
  page.items.push_back(soil);
  report::FigureTable noise{"Noise found",
                            {"channel", "steady wheel: times the stated", "correlation of neighbours",
                             "with the account", "correlation of neighbours"},
                            {}};
  for (std::size_t ch = 0; ch < channel_count; ++ch)
    if (std::isfinite(d.nominal.rmse[ch]))
      noise.rows.push_back({channel_names()[ch].short_name, number(t.nominal_noise[ch].scale),
                            number(t.nominal_noise[ch].rho, 2), number(t.extended_noise[ch].scale),
                            number(t.extended_noise[ch].rho, 2)});
  page.items.push_back(noise);
  report::FigureTable gate{"What the account leaves over", {"against", "p, corrected for the number of tests"}, {}};
  for (const auto& test : t.gate) gate.rows.push_back({test.about, number(test.p, 2)});
  if (!gate.rows.empty()) page.items.push_back(gate);
  if (d.gain) {
    report::FigureTable gain{
        fmt::format("Runs never used: {} ({} runs), error {} [{}, {}] times that of the steady wheel",
                    fmt::join(d.gain->withheld, ", "), d.gain->runs, number(d.gain->rmse_ratio), number(d.gain->low),
                    number(d.gain->high)),
        {"channel", "error, steady wheel", "error, extended", "unit"},
        {}};
    for (std::size_t ch = 0; ch < channel_count; ++ch)
      if (std::isfinite(d.nominal.rmse[ch]))
        gain.rows.push_back({channel_names()[ch].short_name, number(d.gain->nominal_rmse[ch] * shown_scale[ch]),
                             number(d.gain->extended_rmse[ch] * shown_scale[ch]), shown_unit[ch]});
    page.items.push_back(gain);
  }
  std::string text = t.physics;
  for (const std::string& n : d.notes) text += (text.empty() ? "" : "\n\n") + n + ".";
  if (!text.empty()) page.items.push_back(report::Paragraph{text});
  return page;
}

}  // namespace

void run_time_diagnosis(const fs::path& case_file, const fs::path& data, const fs::path& out,
                        const std::vector<std::string>& withhold) {
  const TimeCase c = read_time_case(case_file);
  const TimeDiagnosis t = diagnose_time(c, read_time_table(data, c), withhold);
  const Diagnosis& d = t.d;
  std::error_code failed;
  fs::create_directories(out, failed);
  if (failed)
    throw ResultsError(out.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
  write(out / "diagnosis.json", time_json(t, c).dump(2) + "\n");
  write(out / "series.csv", series_csv(d));
  report::write_figure_page(time_page(t, c), out / "report.html");
  fmt::print("{}: {}\n", d.verdict, d.sentence);
  std::size_t shown_rows = 0;
  for (const Ranked& r : d.ranking) {
    if (shown_rows++ == 6) break;
    fmt::print("  {:<42} probability {:<10.3g} ln likelihood +{:<8.4g}", r.id, r.posterior, r.log_likelihood);
    for (const Interval& i : r.amplitudes) fmt::print(" {}", shown(i));
    fmt::print("\n");
  }
  for (const NextExperiment& e : d.next)
    fmt::print("  next: {}, decides with probability {}{}\n", condition(e), number(e.chance, 2),
               e.simulated ? fmt::format(" (simulated with refits: {})", number(*e.simulated, 2)) : "");
  for (std::size_t ch = 0; ch < channel_count; ++ch)
    if (std::isfinite(d.nominal.rmse[ch]))
      fmt::print(
          "  {}: rms {:.3g} {} with the steady wheel, {:.3g} with the account; noise {:.2g} times the stated, "
          "correlation {:.2f}\n",
          channel_names()[ch].short_name, d.nominal.rmse[ch] * shown_scale[ch], shown_unit[ch],
          d.extended.rmse[ch] * shown_scale[ch], t.extended_noise[ch].scale, t.extended_noise[ch].rho);
  if (d.gain)
    fmt::print("  runs never used ({}): error {:.3g} [{:.3g}, {:.3g}] times that of the steady wheel\n", d.gain->runs,
               d.gain->rmse_ratio, d.gain->low, d.gain->high);
  if (!t.physics.empty()) fmt::print("  {}\n", t.physics);
  for (const std::string& n : d.notes) fmt::print("  {}\n", n);
  fmt::print("report: {}\n", (out / "report.html").string());
}

}  // namespace grouser::app
