// The grouser command: parses arguments, calls one function per command, turns errors into exit codes.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "commands.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/terrain.h"
#include "grouser/vehicle/rig.h"
#include "grouser/vehicle/simulation.h"

namespace {

using namespace grouser::app;

/// A message as it can be shown: what names of files and arguments bring along must not reach the terminal.
void say(std::string_view message) {
  while (!message.empty()) {
    const std::size_t end = std::min(message.find('\n'), message.size());
    fmt::print(stderr, "{}\n", grouser::printable(message.substr(0, end)));
    message.remove_prefix(std::min(end + 1, message.size()));
  }
}

/// What is wrong with the arguments, and how the command is called.
std::string usage_error(const CLI::App& root, const CLI::Error& e) {
  const CLI::App* app = &root;
  std::string name = "grouser";
  while (!app->get_subcommands().empty()) {
    app = app->get_subcommands().front();
    name += " " + app->get_name();
  }
  std::vector<std::string> options, commands;
  for (const CLI::Option* o : app->get_options())
    for (const std::string& l : o->get_lnames()) options.push_back("--" + l);
  for (const CLI::App* c : app->get_subcommands({})) commands.push_back(c->get_name());
  std::string what = e.what();
  const bool missing = e.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError);
  // What CLI11 could not place; an unknown option leaves its value behind too.
  const std::vector<std::string> extra = root.remaining(true);
  const auto option = std::find_if(extra.begin(), extra.end(), [](const std::string& x) { return x.starts_with("-"); });
  const auto meant = [](const std::string& word, const std::vector<std::string>& known) {
    const auto near = grouser::did_you_mean(word, known);
    return near ? "; did you mean '" + *near + "'?" : std::string(".");
  };
  if (option != extra.end())
    what = "unknown option '" + *option + "'" + meant(*option, options);
  else if (!extra.empty() && missing && !commands.empty())
    what = "unknown command '" + extra.front() + "'" + meant(extra.front(), commands) +
           fmt::format(" Known: {}", fmt::join(commands, ", "));
  else if (!extra.empty())
    what = fmt::format("too many arguments: '{}'", fmt::join(extra, "', '"));
  else if (missing && !commands.empty())
    what = fmt::format("a command is wanted: {}", fmt::join(commands, ", "));
  else if (missing)
    what = "argument missing: " + what;
  return fmt::format("{}: {}\n'{} --help' shows how it is called\n", name, grouser::printable(what), name);
}

int parse_and_run(int argc, char** argv) {
  CLI::App cli{"grouser: vehicles on soil in the Bullet physics engine", "grouser"};
  cli.require_subcommand(1);
  cli.set_version_flag("--version", "grouser " GROUSER_VERSION);
  cli.footer("Exit codes: 0 done, 1 the simulation stopped, 2 the input is wrong.");
  int code = 0;

  RunArguments run_args;
  auto* run_cmd = cli.add_subcommand("run", "run a scenario: a vehicle over a ground on one terrain model");
  run_cmd->add_option("scenario", run_args.scenario, "scenario file")->required();
  run_cmd->add_option("--terrain", run_args.terrain, "terrain model instead of the scenario's (grouser list models)");
  run_cmd->add_option("--duration", run_args.duration, "simulated time instead of the scenario's, with a unit: '5 s'");
  run_cmd->add_option("--out", run_args.out, "folder for the results (default runs/<scenario>-<terrain>)");
  run_cmd->add_option("--threads", run_args.threads, "threads for the terrain")->check(CLI::Range(1, 1024));
  run_cmd->add_flag("--overwrite", run_args.overwrite, "replace the results of an earlier run");
  run_cmd->add_flag("--no-report", run_args.no_report, "do not write report.html");
  run_cmd->add_flag("--quiet", run_args.quiet, "no progress line");
  run_cmd->callback([&] { code = run(run_args); });

  RigArguments rig_args;
  auto* rig_cmd = cli.add_subcommand("rig", "single-wheel rig: slip sweep, imposed torque or digging");
  rig_cmd->add_option("rig", rig_args.rig, "rig file")->required();
  rig_cmd->add_option("--terrain", rig_args.terrain, "terrain model instead of the rig's");
  rig_cmd
      ->add_option("--slips", rig_args.slips,
                   "slips instead of the rig's, comma separated, in the rig's own definition")
      ->delimiter(',');
  rig_cmd->add_option("--integrator", rig_args.integrator, "fixed (Bullet, as a vehicle) or cvode (reference)")
      ->check(CLI::IsMember({"fixed", "cvode"}));
  rig_cmd->add_option("--out", rig_args.out, "folder for the results (default runs/<rig>-<terrain>)");
  rig_cmd->add_option("--threads", rig_args.threads, "cases at the same time")->check(CLI::Range(1, 1024));
  rig_cmd->add_flag("--overwrite", rig_args.overwrite, "replace the results of an earlier run");
  rig_cmd->add_flag("--csv", rig_args.csv, "also series.csv of every case: time, forces, sinkage");
  rig_cmd->add_flag("--no-report", rig_args.no_report, "do not write report.html");
  rig_cmd->add_flag("--quiet", rig_args.quiet, "no progress line");
  rig_cmd->callback([&] { code = rig(rig_args); });

  std::filesystem::path resume_folder;
  int resume_threads = 1;
  bool resume_quiet = false;
  auto* resume_cmd = cli.add_subcommand("resume", "continue a run that was stopped, from its last checkpoint");
  resume_cmd->add_option("folder", resume_folder, "folder of the run")->required();
  resume_cmd->add_option("--threads", resume_threads, "threads for the terrain")->check(CLI::Range(1, 1024));
  resume_cmd->add_flag("--quiet", resume_quiet, "no progress line");
  resume_cmd->callback([&] { code = resume(resume_folder, resume_threads, resume_quiet); });

  std::vector<std::filesystem::path> check_files;
  auto* check_cmd = cli.add_subcommand("check", "check input files and name every error with line and column");
  check_cmd->add_option("files", check_files, "scenario, rig, soil, wheel, vehicle, ground, URDF or run file")
      ->required();
  check_cmd->callback([&] { code = check(check_files); });

  std::string list_what, list_id;
  bool list_yaml = false;
  auto* list_cmd = cli.add_subcommand("list", "what there is: models, effects, soils, wheels, vehicles, grounds");
  list_cmd->add_option("what", list_what, "models | effects | soils | wheels | vehicles | grounds");
  list_cmd->add_option("id", list_id, "one entry in full");
  list_cmd->add_flag("--yaml", list_yaml, "annotated defaults of a model as YAML");
  list_cmd->callback([&] { code = list(list_what, list_id, list_yaml); });

  std::vector<std::filesystem::path> report_folders, compare_folders;
  std::filesystem::path report_out, compare_out = "compare.html";
  auto* report_cmd = cli.add_subcommand("report", "write the report of a finished or stopped run again");
  report_cmd->add_option("folder", report_folders, "folder of a run or rig")->required()->expected(1);
  report_cmd->add_option("-o,--out", report_out, "file (default report.html in the folder)");
  report_cmd->callback([&] { code = report(report_folders, report_out); });

  auto* compare_cmd = cli.add_subcommand("compare", "several runs in one report");
  compare_cmd->add_option("folders", compare_folders, "folders of runs")->required()->expected(2, 16);
  compare_cmd->add_option("-o,--out", compare_out, "file");
  compare_cmd->callback([&] { code = report(compare_folders, compare_out); });

  auto* doctor_cmd =
      cli.add_subcommand("doctor", "check this build and machine: libraries, files, every terrain model");
  doctor_cmd->callback([&] { code = doctor(); });

  add_plot_command(cli, code);
#ifdef GROUSER_DIAGNOSIS
  add_fit_command(cli, code);
  add_diagnose_command(cli, code);
#endif
#ifdef GROUSER_BEKKER
  add_bekker_command(cli, code);
#endif
#ifdef GROUSER_DEM
  add_soil_command(cli, code);
  add_dem_command(cli, code);
#endif
#ifdef GROUSER_SDEM
  add_sdem_command(cli, code);
#endif

  std::vector<std::string> commands;
  for (const CLI::App* c : cli.get_subcommands({})) commands.push_back(c->get_name());
  if (argc > 1 && argv[1][0] != '-' && std::find(commands.begin(), commands.end(), argv[1]) == commands.end()) {
    const auto near = grouser::did_you_mean(argv[1], commands);
    say(fmt::format("unknown command '{}'{} Known: {}", argv[1], near ? "; did you mean '" + *near + "'?" : ".",
                    fmt::join(commands, ", ")));
    return 2;
  }
  // An empty value would pass for one that was not given.
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (!word.empty() && !(word.starts_with("--") && word.ends_with("="))) continue;
    say(fmt::format("grouser: {} has no value; give one or leave it out",
                    !word.empty()                                    ? std::string(word.substr(0, word.size() - 1))
                    : std::string_view(argv[i - 1]).starts_with("-") ? argv[i - 1]
                                                                     : fmt::format("argument {}", i)));
    return 2;
  }
  cli.failure_message([](const CLI::App* app, const CLI::Error& e) { return usage_error(*app, e); });
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int parse_code = cli.exit(e);
    return parse_code == 0 ? 0 : 2;
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const grouser::ConfigError& e) {
    say(e.what());
    return 2;
  } catch (const grouser::ResultsError& e) {
    say(e.what());
    return 2;
  } catch (const grouser::vehicle::SimulationError& e) {
    say(e.what());
    return 1;
  } catch (const grouser::vehicle::RigError& e) {
    say(e.what());
    return 1;
  } catch (const std::exception& e) {
    say(std::string("grouser: ") + e.what());
    return 1;
  }
}
