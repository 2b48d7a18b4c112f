// grouser diagnose: what the simulation gets wrong on measured runs, why, and what is gained by the extension.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "commands.h"
#include "diagnose_design.h"
#include "diagnose_grains.h"
#include "diagnose_json.h"
#include "diagnose_page.h"
#include "diagnose_time.h"
#include "grouser/diagnosis/diagnose.h"
#include "grouser/diagnosis/extended_file.h"
#include "grouser/diagnosis/soil_test_diagnosis.h"
#include "grouser/diagnosis/time_series.h"
#include "grouser/models.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw ResultsError(file.string() + ": cannot be written; is the folder writable?");
}

/// Every fitted row: measured, all models, how far off each is in noise sd, and what statics says of the row.
std::string runs_csv(const diagnosis::Diagnosis& d) {
  std::string out = "line,slip,load_N,omega_rad_s,pass,order,weight";
  for (const auto& c : diagnosis::channel_names())
    out += fmt::format(
        ",{0}_measured,{0}_stated,{0}_nominal,{0}_extended,{0}_sd,{0}_nominal_off_sd,{0}_extended_off_sd", c.column);
  out += ",theta_deg,theta_f_deg,friction,friction_sd,statics";
  const auto cell = [](double x) { return std::isfinite(x) ? fmt::format(",{:.6g}", x) : std::string(","); };
  for (std::size_t i = 0; i < d.runs.size(); ++i) {
    const diagnosis::Run& r = d.runs[i];
    out += fmt::format("\n{},{:.6g},{:.6g},{:.6g},{},{:.6g},{:.3g}", r.line, r.slip, r.load, r.omega, r.pass, r.order,
                       d.weights[i]);
    for (std::size_t c = 0; c < diagnosis::channel_count; ++c) {
      const double y = r.value[c], n = d.nominal.predicted[i][c], e = d.extended.predicted[i][c], sd = d.sd[i][c];
      const double stated = d.stated ? d.stated->predicted[i][c] : std::numeric_limits<double>::quiet_NaN();
      for (const double x : {y, stated, n, e, std::isfinite(y) ? sd : y, (y - n) / sd, (y - e) / sd}) out += cell(x);
    }
    const auto row = std::find_if(d.statics.begin(), d.statics.end(), [&](const auto& s) { return s.line == r.line; });
    if (row == d.statics.end())
      out += ",,,,,";
    else
      out += fmt::format(",{:.4g},{:.4g},{:.4g},{:.2g},{}", row->theta * 57.29577951308232,
                         row->theta_f * 57.29577951308232, row->friction, row->friction_sd,
                         row->outside  ? "pushed from outside the contact"
                         : row->slides ? "more friction than the soil has"
                                       : "");
  }
  return out + "\n";
}

void print(const diagnosis::Diagnosis& d) {
  fmt::print("{}: {}\n", d.verdict, d.sentence);
  std::size_t shown = 0;
  for (const diagnosis::Ranked& r : d.ranking) {
    if (shown++ == 6) break;
    fmt::print("  {:<42} probability {:<10.3g} ln likelihood +{:<8.4g}", r.id, r.posterior, r.log_likelihood);
    for (const diagnosis::Interval& i : r.amplitudes)
      fmt::print(" {:.4g} [{:.4g}, {:.4g}]{}{}", i.value, i.low, i.high, i.unit == "1" ? "" : " " + i.unit,
                 i.times_typical > 3 ? fmt::format(" ({:.2g} times the ordinary size)", i.times_typical) : "");
    fmt::print("\n");
  }
  for (const diagnosis::Needed& n : d.needed)
    if (n.rise > 4) {
      fmt::print("  {} held where the case has it: chi2 +{:.3g}, error", fmt::join(n.held, " and "), n.rise);
      for (std::size_t ch = 0; ch < diagnosis::channel_count; ++ch)
        if (std::isfinite(n.rmse[ch]))
          fmt::print(" {:.3g} {}", n.rmse[ch] * (ch == 2 ? 1000 : 1),
                     ch == 2 ? "mm" : diagnosis::channel_names()[ch].unit);
      fmt::print("\n");
    }
  for (const diagnosis::JudgedValue& j : d.judged)
    fmt::print("  judged: {} {:.4g} for {:.4g}{}: {:+.2g} prior sd{}\n", j.name, j.value, j.prior,
               j.unit == "1" ? "" : " " + j.unit, j.z, std::abs(j.z) > 3 ? ", structural" : "");
  for (const diagnosis::NextExperiment& e : d.next) {
    fmt::print("  next: {}", e.bench_check);
    for (const auto& [name, x] : e.condition) fmt::print("{} {:.3g}  ", name, x);
    if (e.runs > 0) fmt::print(" {} {}", e.runs, e.bench_check.empty() ? "repeats" : "readings");
    fmt::print(", decides with probability {:.2f}{}", e.chance, e.simulated ? " (simulated with refits)" : "");
    fmt::print("\n");
  }
  if (!d.suspect_lines.empty()) fmt::print("  suspect rows: lines {}\n", fmt::join(d.suspect_lines, ", "));
  for (const std::string& n : d.notes) fmt::print("  {}\n", n);
}

}  // namespace

void add_diagnose_command(CLI::App& cli, int& code) {
  struct Arguments {
    fs::path file, data, out;
    std::vector<std::string> withhold;
    bool overwrite = false, design = false;
    std::string plan;
  };
  const auto a = std::make_shared<Arguments>();
  auto* cmd = cli.add_subcommand(
      "diagnose", "measured runs against the model: the cause of the misfit, the extended model, its gain");
  cmd->add_option("case", a->file, "case file: model, wheel, soil with priors, effects")->required();
  cmd->add_option("--data", a->data, "runs as CSV with units in the header names");
  cmd->add_option("--out", a->out, "folder for the results (default runs/diagnose-<data>)");
  cmd->add_option("--withhold", a->withhold, "runs to keep for the gain: load_N=225, slip=0.3..0.7");
  cmd->add_flag("--design", a->design, "judge a plan before it is run: what it could and could not tell apart");
  cmd->add_option("--plan", a->plan,
                  "the plan: PLAN.csv, or a grid as in 'slip=-0.5,0,0.5 load_N=60,225 drawbar_sd_N=2'");
  cmd->add_flag("--overwrite", a->overwrite, "replace the results of an earlier diagnosis");
  cmd->callback([a, &code] {
    if (a->design && !a->data.empty())
      throw ConfigError(
          "grouser diagnose", 0, 0,
          "--design judges a plan before it is run and takes no --data; give --plan PLAN.csv or a grid, or "
          "leave out --design");
    if (a->design != !a->plan.empty() || a->design != a->data.empty())
      throw ConfigError("grouser diagnose", 0, 0,
                        "needs --data RUNS.csv to find a cause, or --design --plan PLAN to judge a plan");
    if (a->design) {
      run_design(a->file, a->plan, a->out, a->overwrite);
      code = 0;
      return;
    }
    if (diagnosis::is_soil_test_case(a->file))
      return void(code = run_grain_diagnosis(a->file, a->data, a->out, a->withhold, a->overwrite));
    if (a->out.empty()) a->out = fs::path("runs") / ("diagnose-" + a->data.stem().string());
    if (fs::exists(a->out / "diagnosis.json") && !a->overwrite)
      throw ConfigError(a->out.string(), 0, 0,
                        "holds the results of an earlier diagnosis; use --overwrite, or another folder with --out");
    if (diagnosis::is_time_case(a->file))
      return run_time_diagnosis(a->file, a->data, a->out, a->withhold), void(code = 0);
    const diagnosis::DiagnosisCase c = diagnosis::read_case(a->file, &all_models());
    const diagnosis::RunTable data = diagnosis::read_runs(a->data, c);
    const diagnosis::Diagnosis d = diagnosis::diagnose(c, data, a->withhold);
    std::error_code failed;
    fs::create_directories(a->out, failed);
    if (failed)
      throw ResultsError(a->out.string() + ": cannot be made: " + failed.message() + "; choose another output folder");
    write(a->out / "diagnosis.json", diagnosis_json(d).dump(2) + "\n");
    write(a->out / "runs.csv", runs_csv(d));
    for (const diagnosis::ExtendedFile& f : diagnosis::extended_files(d, c)) write(a->out / f.name, f.text);
    report::write_figure_page(diagnose_page(d, c, a->data.stem().string()), a->out / "report.html");
    print(d);
    fmt::print("report: {}\n", (a->out / "report.html").string());
    code = 0;
  });
}

}  // namespace grouser::app
