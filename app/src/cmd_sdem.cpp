// grouser sdem: the surrogate of grains: its campaigns and tables.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "commands.h"
#include "grouser/sdem/direction.h"
#include "grouser/sdem/tables.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/types.h"
#include "sdem_build.h"
#include "sdem_fit.h"
#include "sdem_train.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

/// Share of a part's values that a run gave [%].
double known_share(const sdem::Grid& g) {
  double n = 0;
  for (const float f : g.known) n += f > 0;
  return g.known.empty() ? 0 : 100 * n / static_cast<double>(g.known.size());
}

std::string scaled(const std::vector<double>& x, double factor, const std::string& unit) {
  std::vector<std::string> words;
  for (const double v : x) words.push_back(fmt::format("{:.4g}", factor * v));
  return fmt::format("{} {}", fmt::join(words, ", "), unit);
}

bool is_law(const fs::path& file) { return RunFile(file).attributes().kind == "sdem law"; }

int law_info(const fs::path& file, bool inputs) {
  const sdem::Direction d = sdem::Direction::read(file);
  fmt::print("{}\nsource: {}\nhash: {}, {:.1f} kB\nwheel: {}, radius {:.4g} mm, forces of a width of {:.4g} mm\n",
             d.title, d.source, d.hash_text(), 1e-3 * static_cast<double>(fs::file_size(file)), d.wheel, 1e3 * d.radius,
             1e3 * d.width);
  for (std::size_t k = 0; k < sdem::kCoefficients; ++k)
    fmt::print("{:<12}{:>10.4g}  {}\n", sdem::coefficient_infos()[k].name, d.c[k], sdem::coefficient_infos()[k].what);
  fmt::print("spread of packings: height {:.3g} mm, mu {:.3g}, tau {:.3g}\nsoil:\n{}", 1e3 * d.spread[0], d.spread[1],
             d.spread[2], d.soil);
  if (inputs) fmt::print("inputs:\n{}\n", d.inputs);
  return 0;
}

int info(const fs::path& file, bool inputs) {
  if (is_law(file)) return law_info(file, inputs);
  const sdem::Tables t = sdem::Tables::read(file);
  fmt::print("{}\nsource: {}\nhash: {}, {:.1f} MB on disk, {:.1f} MB in memory\n", t.title, t.source, t.hash_text(),
             1e-6 * static_cast<double>(fs::file_size(file)), 1e-6 * static_cast<double>(t.bytes()));
  fmt::print("wheel: {}, radius {:.4g} mm, measured over a width of {:.4g} mm\nbed: {:.4g} mm deep\n", t.wheel,
             1e3 * t.radius, 1e3 * t.width, 1e3 * t.bed_depth);
  fmt::print("spin: {}\nforward: {}\nupward: {}\n", scaled(t.w, 180 / pi, "deg/s"), scaled(t.vx, 1e3, "mm/s"),
             scaled(t.vz, 1e3, "mm/s"));
  fmt::print("{:<14}{:>20}{:>24}{:>12}\n", "table", "rows", "columns", "from runs");
  for (std::size_t p = 0; p < t.parts.size(); ++p) {
    const sdem::Grid& g = t.parts[p];
    const bool soil = p < 4;
    const double k = soil ? 1e3 : 180 / pi;
    fmt::print("{:<14}{:>20}{:>24}{:>10.1f} %\n", sdem::kPartNames[p],
               fmt::format("{} in {:.4g}..{:.4g} mm", g.u.count, 1e3 * g.u.first, 1e3 * g.u.last),
               fmt::format("{} in {:.4g}..{:.4g} {}", g.v.count, k * g.v.first, k * g.v.last, soil ? "mm" : "deg"),
               known_share(g));
  }
  fmt::print("soil:\n{}", t.soil);
  if (inputs) fmt::print("inputs:\n{}\n", t.inputs);
  return 0;
}

int validate(const fs::path& file) {
  if (is_law(file)) {
    fmt::print("{}: content matches its hash {}, every value finite\n", file.string(),
               sdem::Direction::read(file).hash_text());
    return 0;
  }
  const sdem::Tables t = sdem::Tables::read(file);  // hash, sizes, finite values
  fmt::print("{}: content matches its hash {}, {} velocity nodes, every value finite\n", file.string(), t.hash_text(),
             t.nodes());
  for (std::size_t p = 0; p < t.parts.size(); ++p) {
    const sdem::Grid& g = t.parts[p];
    const double share = known_share(g);
    float least = 0, most = 0;
    for (const auto* values : {&g.x, &g.z})
      if (!values->empty()) {
        const auto [low, high] = std::minmax_element(values->begin(), values->end());
        least = std::min(least, *low);
        most = std::max(most, *high);
      }
    fmt::print("{:<14} {:.4g} to {:.4g} {}, {:.1f} % from runs{}\n", sdem::kPartNames[p], least, most,
               p < 4 ? "m/s" : "Pa", share, share < 10 ? ": nearly all of it is estimated" : "");
  }
  return 0;
}

}  // namespace

void add_sdem_command(CLI::App& cli, int& code) {
  auto* sdem = cli.add_subcommand("sdem", "surrogate of grains: campaigns and tables");
  sdem->require_subcommand(1);
  const auto b = std::make_shared<SdemBuildArguments>();
  auto* build = sdem->add_subcommand("build", "run what is missing of a campaign of grains, and make its tables");
  build->add_option("campaign", b->campaign, "file of the campaign")->required();
  build->add_option("--out", b->out, "file of the tables (default tables.h5 in the folder of the runs)");
  build->add_option("--runs", b->runs, "folder of the runs (default runs/sdem-<campaign>)");
  build->add_option("--beds", b->beds, "folder that keeps the poured brick (default that of the runs)");
  build->add_option("--threads", b->threads, "runs at the same time")->check(CLI::Range(1, 1024));
  build->add_option("--part", b->part,
                    "K/N: only every N-th run, from the K-th, and no tables; auto: K and N from Slurm or mpirun");
  build->add_option("--slurm", b->slurm, "print a script of a Slurm array of so many jobs, nothing else")
      ->check(CLI::Range(1, 1000000));
  build->add_flag("--plan", b->plan, "only list the runs and what they cost");
  build->add_flag("--overwrite", b->overwrite, "replace tables");
  build->add_flag("--quiet", b->quiet, "no progress line");
  build->callback([b, &code] { code = sdem_build(*b); });

  const auto n = std::make_shared<SdemTrainArguments>();
  auto* train = sdem->add_subcommand("train", "run what is missing of a training plan of sdem.v2");
  train->add_option("plan", n->plan_file, "file of the plan")->required();
  train->add_option("--runs", n->runs, "folder of the runs (default runs/sdem-<plan>)");
  train->add_flag("--plan", n->plan, "only list the runs and what they cost");
  train->add_flag("--quiet", n->quiet, "no progress line");
  train->callback([n, &code] { code = sdem_train(*n); });

  const auto l = std::make_shared<SdemFitArguments>();
  auto* fit = sdem->add_subcommand("fit", "fit the law of sdem.v2 to the runs of a training plan");
  fit->add_option("plan", l->plan_file, "file of the plan")->required();
  fit->add_option("--runs", l->runs, "folder of the runs (default runs/sdem-<plan>)");
  fit->add_option("--out", l->out, "file of the law (default law.h5 in the folder of the runs)");
  fit->add_option("--start", l->start, "law whose coefficients the fit begins with");
  fit->add_flag("--keep-coefficients", l->keep_coefficients,
                "only the fluctuation of grains and the spread are fitted, to the coefficients of --start");
  fit->add_flag("--partly", l->partly, "fit the runs that are there");
  fit->add_flag("--without-memory", l->without_memory, "ablation: no elastic memory, forces by direction alone");
  fit->add_flag("--without-pile", l->without_pile, "ablation: displaced soil is compacted, none goes ahead or behind");
  fit->add_flag("--overwrite", l->overwrite, "replace the law");
  fit->add_flag("--quiet", l->quiet, "no progress");
  fit->callback([l, &code] { code = sdem_fit(*l); });

  const auto v = std::make_shared<SdemCompareArguments>();
  auto* compare = sdem->add_subcommand("compare", "a law of sdem.v2 beside runs of grains, as CSV");
  compare->add_option("law", v->law, "law (HDF5)")->required();
  compare->add_option("plan", v->plan_file, "file of the plan whose runs it is held against")->required();
  compare->add_option("--runs", v->runs, "folder of the runs (default runs/sdem-<plan>)");
  compare->add_option("--share", v->share, "last share of the way that means are taken over")
      ->check(CLI::Range(0.01, 1.0));
  compare->add_flag("--without-noise", v->quiet_grains, "law without the fluctuation of grains");
  compare->add_flag("--without-memory", v->without_memory, "ablation: no elastic memory");
  compare->add_flag("--without-pile", v->without_pile, "ablation: displaced soil is compacted");
  compare->callback([v, &code] { code = sdem_compare(*v); });

  const auto file = std::make_shared<fs::path>();
  const auto inputs = std::make_shared<bool>(false);
  auto* show = sdem->add_subcommand("info", "what a file of tables or a law holds, and what it was made from");
  show->add_option("file", *file, "tables or law (HDF5)")->required();
  show->add_flag("--inputs", *inputs, "also everything that they were made from");
  show->callback([file, inputs, &code] { code = info(*file, *inputs); });
  auto* check = sdem->add_subcommand("validate",
                                     "check a file of tables or a law: hash, sizes, values, share of estimated cells");
  check->add_option("file", *file, "tables or law (HDF5)")->required();
  check->callback([file, &code] { code = validate(*file); });
}

}  // namespace grouser::app
