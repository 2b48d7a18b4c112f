// grouser plot: a page of figures and tables from CSV files.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "figure_file.h"
#include "file_kind.h"

namespace grouser::app {

void add_plot_command(CLI::App& cli, int& code) {
  struct Arguments {
    std::filesystem::path figures, out;
  };
  const auto a = std::make_shared<Arguments>();
  auto* cmd = cli.add_subcommand("plot", "a page of figures and tables drawn from CSV files");
  cmd->add_option("figures", a->figures, "file that names the columns to draw")->required();
  cmd->add_option("-o,--out", a->out, "file (default: the same name with .html)");
  cmd->callback([a, &code] {
    expect_kind(a->figures, "items");
    const report::FigurePage page = report::read_figures(a->figures);
    if (a->out.empty()) a->out = std::filesystem::path(a->figures).replace_extension(".html");
    report::write_figure_page(page, a->out);
    fmt::print("figures: {}\n", a->out.string());
    code = 0;
  });
}

}  // namespace grouser::app
