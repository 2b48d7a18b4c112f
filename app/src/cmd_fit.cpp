// grouser fit: soil parameters from soil tests and from wheel results.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "commands.h"
#include "file_kind.h"
#include "fit_page.h"
#include "grouser/diagnosis/fit_file.h"
#include "grouser/terrain/config.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

void print_table(const diagnosis::FitTable& t) {
  std::vector<std::size_t> width(t.columns.size());
  for (std::size_t c = 0; c < t.columns.size(); ++c) {
    width[c] = t.columns[c].size();
    for (const auto& row : t.rows) width[c] = std::max(width[c], row[c].size());
  }
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t c = 0; c < cells.size(); ++c) fmt::print("{}{:<{}}", c ? "  " : "  ", cells[c], width[c]);
    fmt::print("\n");
  };
  fmt::print("{}\n", t.title);
  line(t.columns);
  for (const auto& row : t.rows) line(row);
}

void print(const diagnosis::FitSection& s) {
  fmt::print("{}: {}\n", s.kind, s.data);
  for (const diagnosis::ShownParameter& p : s.parameters) {
    fmt::print("  {:<16} {:>11.5g} {:<12}", p.name, p.value, p.unit == "1" ? "" : p.unit);
    if (!std::isnan(p.standard_error))
      fmt::print(" +- {:<10.3g} 95 %: {:.5g} to {:.5g}", p.standard_error, p.lower, p.upper);
    fmt::print("{}\n", p.note.empty() ? "" : "  (" + p.note + ")");
  }
  for (const std::string& r : s.remarks) fmt::print("  {}\n", r);
  for (const diagnosis::FitTable& t : s.tables)
    if (t.rows.size() <= 12) print_table(t);
}

}  // namespace

void add_fit_command(CLI::App& cli, int& code) {
  struct Arguments {
    fs::path file, out;
    bool overwrite = false;
  };
  const auto a = std::make_shared<Arguments>();
  auto* cmd = cli.add_subcommand("fit", "soil parameters from direct-shear, plate and wheel tests");
  cmd->add_option("fit", a->file, "fit file: what to fit to which data")->required();
  cmd->add_option("--out", a->out, "folder for the results (default runs/fit-<file>)");
  cmd->add_flag("--overwrite", a->overwrite, "replace the results of an earlier fit");
  cmd->callback([a, &code] {
    expect_kind(a->file, "fit");
    if (a->out.empty()) a->out = fs::path("runs") / ("fit-" + a->file.stem().string());
    if (fs::exists(a->out / "parameters.csv") && !a->overwrite)
      throw ConfigError(a->out.string(), 0, 0,
                        "holds the results of an earlier fit; use --overwrite, or another folder with --out");
    const diagnosis::FitReport r = diagnosis::run_fit(a->file);
    diagnosis::write_fit(r, a->out);
    report::write_figure_page(fit_page(r), a->out / "fit.html");
    for (const diagnosis::FitSection& s : r.sections) print(s);
    if (!r.compare.rows.empty()) print_table(r.compare);
    fmt::print("{}\n", r.soil_text.empty() ? r.soil_note : "soil: " + (a->out / "soil.yaml").string());
    fmt::print("report: {}\n", (a->out / "fit.html").string());
    code = 0;
  });
}

}  // namespace grouser::app
