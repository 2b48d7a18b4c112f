#include "diagnose_grains.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "figure_page.h"
#include "grouser/diagnosis/soil_test_diagnosis.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"
#include "whole_file.h"

namespace grouser::app {
namespace {

namespace fs = std::filesystem;
using namespace diagnosis;
using Json = nlohmann::ordered_json;

std::string shown(double x, int digits = 3) { return std::isfinite(x) ? fmt::format("{:.{}g}", x, digits) : "-"; }
Json value(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json text(const std::string& s) { return s.empty() ? Json(nullptr) : Json(s); }
Json interval(const Interval& i) {
  return {{"value", value(i.value)}, {"sd", value(i.sd)}, {"ci90", {value(i.low), value(i.high)}}, {"unit", i.unit}};
}

Json fitted(const std::map<std::string, FittedValue>& soil, double chi2, double p, int values, double rmse) {
  Json parameters = Json::object();
  for (const auto& [name, v] : soil)
    parameters[name] = {{"value", v.value}, {"sd", v.sd}, {"prior_z", v.prior_z}, {"unit", v.unit}};
  return {{"rmse_ln_stress", rmse}, {"chi2", chi2}, {"values", values}, {"p", p}, {"parameters", parameters}};
}

std::string condition_text(const NextExperiment& e) {
  std::string s = e.condition.at("normal_stress_Pa") > 0
                      ? fmt::format("shear at {} Pa", shown(e.condition.at("normal_stress_Pa"), 5))
                      : std::string("plate");
  s += fmt::format(", {} mm/s", shown(e.condition.at("speed_mm_s")));
  if (e.condition.count("rest_s")) s += fmt::format(" after {} s of rest", shown(e.condition.at("rest_s")));
  return s + fmt::format(", {} repeats", e.runs);
}

Json json_of(const SoilTestDiagnosis& d) {
  Json j{{"verdict", d.verdict}, {"cause", text(d.cause)}, {"class", d.members}, {"sentence", d.sentence}};
  j["posterior"] = d.posterior;
  j["parameters"] = Json::object();
  for (const auto& [id, i] : d.parameters) j["parameters"][id] = interval(i);
  j["unknown"] = {{"variable", text(d.unknown_variable)}, {"acts_through", text(d.unknown_through)}};
  j["nominal"] = fitted(d.nominal, d.nominal_chi2, d.nominal_p, d.values, d.nominal_rmse);
  j["extended"] = fitted(d.extended, d.extended_chi2, d.extended_p, d.values, d.extended_rmse);
  j["gain"] = nullptr;
  if (d.gain)
    j["gain"] = {{"withheld", d.gain->withheld},
                 {"curves", d.gain->runs},
                 {"rmse_ratio", d.gain->rmse_ratio},
                 {"ci95", {d.gain->low, d.gain->high}},
                 {"rmse_ln_stress", {{"nominal", d.gain->nominal_rmse[0]}, {"extended", d.gain->extended_rmse[0]}}}};
  j["next_experiment"] = Json::array();
  for (const NextExperiment& e : d.next)
    j["next_experiment"].push_back({{"condition", e.condition},
                                    {"decides", e.decides},
                                    {"chance", e.chance},
                                    {"cost_runs", e.cost},
                                    {"runs", e.runs}});
  j["visible"] = Json::object();
  for (const auto& [id, size] : d.visible) j["visible"][id] = value(size);
  j["noise"] = {{"variance_of_repeats_over_stored", {{"shear", d.noise_scale[0]}, {"plate", d.noise_scale[1]}}}};
  j["ranking"] = Json::array();
  for (const Ranked& r : d.ranking) {
    Json x{{"id", r.id},
           {"log_likelihood_gain", r.log_likelihood},
           {"log_evidence", r.log_evidence},
           {"posterior", r.posterior}};
    for (const Interval& i : r.amplitudes) x["amplitudes"].push_back(interval(i));
    j["ranking"].push_back(x);
  }
  j["emulators"] = Json::array();
  for (const EmulatorQuality& e : d.emulators)
    j["emulators"].push_back({{"law", e.law},
                              {"test", e.kind == SoilTestKind::shear ? "shear" : "plate"},
                              {"runs", e.runs},
                              {"terms", e.terms},
                              {"scatter_ln", e.scatter},
                              {"left_out_ln", e.left_out}});
  j["notes"] = d.notes;
  j["timing"] = {{"total_s", d.seconds}};
  return j;
}

/// Middle of each window, in mm.
std::array<double, 3> middles(SoilTestKind kind) {
  std::array<double, 3> out{};
  const auto& w = kind == SoilTestKind::shear ? soil_test_windows().shear : soil_test_windows().plate;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = 500 * (w[i][0] + w[i][1]);
  return out;
}

std::string curves_csv(const SoilTestDiagnosis& d) {
  std::string out =
      "test,normal_stress_Pa,speed_mm_s,repeats,displacement_mm,measured_Pa,nominal_Pa,extended_Pa,ln_sd_of_one_test";
  for (const SoilTestFigures& f : d.figures)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      out += fmt::format("\n{},{:.6g},{:.6g},{},{:.5g},{:.5g},{:.5g},{:.5g},{:.3g}",
                         f.condition.kind == SoilTestKind::shear ? "shear" : "plate", f.condition.normal_stress,
                         f.condition.speed * 1e3, f.repeats.size(), middles(f.condition.kind)[i], std::exp(f.mean[k]),
                         std::exp(f.nominal[k]), std::exp(f.extended[k]), f.sd[k]);
    }
  return out + "\n";
}

report::Plot plot_of(const SoilTestDiagnosis& d, SoilTestKind kind) {
  const bool shear = kind == SoilTestKind::shear;
  report::Plot p{
      shear ? "Shear stress" : "Pressure under the plate",
      shear ? "displacement [mm]" : "sinkage [mm]",
      shear ? "shear stress [kPa]" : "pressure [kPa]",
      "Points: mean of the repeats in a window of displacement, bar: sd of one test. Dashed: nominal law, refitted. "
      "Line: extended model.",
      {},
      false,
      true};
  int colour = 0;
  for (const SoilTestFigures& f : d.figures) {
    if (f.condition.kind != kind) continue;
    using report::Series;
    Series points{f.condition.name(), Series::Style::points, {}, {}, {}, colour},
        nominal{f.condition.name() + ", nominal", Series::Style::dashed, {}, {}, {}, colour},
        extended{f.condition.name() + ", extended", Series::Style::line, {}, {}, {}, colour};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      for (Series* s : {&points, &nominal, &extended}) s->x.push_back(middles(kind)[i]);
      points.y.push_back(std::exp(f.mean[k]) / 1e3), points.error.push_back(std::exp(f.mean[k]) / 1e3 * f.sd[k]);
      nominal.y.push_back(std::exp(f.nominal[k]) / 1e3), extended.y.push_back(std::exp(f.extended[k]) / 1e3);
    }
    for (Series* s : {&points, &nominal, &extended}) p.series.push_back(*s);
    ++colour;
  }
  return p;
}

report::FigurePage page_of(const SoilTestDiagnosis& d) {
  report::FigurePage page{"Diagnosis of soil tests on grains", d.sentence, {}};
  report::FigureTable ranking{
      "Ranking of the causes",
      {"cause", "probability", "gain in ln likelihood", "ln evidence over the nominal law", "amplitude [90 %]"},
      {}};
  ranking.rows.push_back({"none", shown(d.posterior.at("none")), "0", "0", ""});
  for (const Ranked& r : d.ranking) {
    std::string amplitude;
    for (const Interval& i : r.amplitudes)
      amplitude = fmt::format("{} [{}, {}] {}{}", shown(i.value), shown(i.low), shown(i.high),
                              i.unit == "1" ? "" : i.unit, i.at_bound ? " (at its bound)" : "");
    ranking.rows.push_back({r.id, shown(r.posterior), shown(r.log_likelihood), shown(r.log_evidence), amplitude});
  }
  page.items.push_back(std::move(ranking));
  if (!d.next.empty()) {
    report::FigureTable next{
        "What would decide", {"test", "decides", "chance that the odds pass 10:1", "cost [tests]"}, {}};
    for (const NextExperiment& e : d.next)
      next.rows.push_back(
          {condition_text(e), fmt::format("{}", fmt::join(e.decides, " / ")), shown(e.chance, 2), shown(e.cost, 2)});
    page.items.push_back(std::move(next));
  }
  for (const SoilTestKind kind : {SoilTestKind::shear, SoilTestKind::plate}) {
    report::Plot p = plot_of(d, kind);
    if (!p.series.empty()) page.items.push_back(std::move(p));
  }
  report::FigureTable soil{
      "Soil against its priors", {"parameter", "unit", "nominal refit", "prior z", "extended", "prior z"}, {}};
  for (const auto& [name, v] : d.nominal) {
    const auto e = d.extended.find(name);
    const bool there = e != d.extended.end();
    soil.rows.push_back({name, v.unit, shown(v.value), shown(v.prior_z, 2), there ? shown(e->second.value) : "-",
                         there ? shown(e->second.prior_z, 2) : "-"});
  }
  page.items.push_back(std::move(soil));
  report::FigureTable fit{"What the models leave over", {"model", "chi2", "values", "p", "error of ln stress"}, {}};
  fit.rows.push_back({"nominal, refitted", shown(d.nominal_chi2), std::to_string(d.values), shown(d.nominal_p, 2),
                      shown(d.nominal_rmse, 2)});
  fit.rows.push_back({"extended", shown(d.extended_chi2), std::to_string(d.values), shown(d.extended_p, 2),
                      shown(d.extended_rmse, 2)});
  page.items.push_back(std::move(fit));
  report::FigureTable seen{
      "What these tests could show", {"effect at its typical size", "what a refit leaves of it [noise sd]"}, {}};
  for (const auto& [id, size] : d.visible) seen.rows.push_back({id, shown(size, 2)});
  page.items.push_back(std::move(seen));
  report::FigureTable e{"Emulators of the stored runs",
                        {"law", "test", "runs", "terms", "scatter of single runs, ln stress by window (and rise, mm)",
                         "left out of the fit"},
                        {}};
  for (const EmulatorQuality& q : d.emulators) {
    std::string a, b;
    for (const double x : q.scatter) a += (a.empty() ? "" : ", ") + shown(x, 2);
    for (const double x : q.left_out) b += (b.empty() ? "" : ", ") + shown(x, 2);
    e.rows.push_back({q.law, q.kind == SoilTestKind::shear ? "shear" : "plate", std::to_string(q.runs),
                      std::to_string(q.terms), a, b});
  }
  page.items.push_back(std::move(e));
  std::string notes =
      fmt::format("Variance of repeats over that of the stored runs about their emulator: {} (shear), {} (plate).",
                  shown(d.noise_scale[0], 2), shown(d.noise_scale[1], 2));
  for (const std::string& n : d.notes) notes += "\n\n" + n + ".";
  page.items.push_back(report::Paragraph{notes});
  return page;
}

void print(const SoilTestDiagnosis& d) {
  fmt::print("{}: {}\n", d.verdict, d.sentence);
  fmt::print("  {:<42} probability {:.3g}\n", "none", d.posterior.at("none"));
  for (std::size_t i = 0; i < std::min<std::size_t>(d.ranking.size(), 6); ++i) {
    const Ranked& r = d.ranking[i];
    fmt::print("  {:<42} probability {:<10.3g} ln likelihood +{:<8.4g}", r.id, r.posterior, r.log_likelihood);
    for (const Interval& k : r.amplitudes)
      fmt::print(" {:.4g} [{:.4g}, {:.4g}]{}", k.value, k.low, k.high, k.unit == "1" ? "" : " " + k.unit);
    fmt::print("\n");
  }
  for (const NextExperiment& e : d.next)
    fmt::print("  next: {}, decides {} with probability {:.2f}\n", condition_text(e), fmt::join(e.decides, " / "),
               e.chance);
  for (const std::string& n : d.notes) fmt::print("  {}\n", n);
}

}  // namespace

int run_grain_diagnosis(const fs::path& case_file, const fs::path& data, fs::path out,
                        const std::vector<std::string>& withhold, bool overwrite) {
  if (out.empty()) out = fs::path("runs") / ("diagnose-" + data.stem().string());
  if (fs::exists(out / "diagnosis.json") && !overwrite)
    throw ConfigError(out.string(), 0, 0,
                      "holds the results of an earlier diagnosis; use --overwrite, or another folder with --out");
  const SoilTestCase c = read_soil_test_case(case_file);
  const SoilTestData curves = read_soil_test_curves(data);
  const SoilTestDiagnosis d = diagnose_soil_tests(c, curves, withhold);
  std::error_code failed;
  fs::create_directories(out, failed);
  if (failed)
    throw ResultsError(out.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
  write_whole_file(out / "diagnosis.json", json_of(d).dump(2) + "\n");
  write_whole_file(out / "curves.csv", curves_csv(d));
  write_whole_file(out / "extended_soil.yaml", extended_soil_text(d));
  report::write_figure_page(page_of(d), out / "report.html");
  print(d);
  fmt::print("report: {}\n", (out / "report.html").string());
  return 0;
}

}  // namespace grouser::app
