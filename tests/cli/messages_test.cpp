// What a new user types wrong, and what he is told: every message whole.
#include <gtest/gtest.h>

#include "command.h"

namespace grouser::test {
namespace {

struct Mistake {
  const char* name;
  std::string arguments;
  std::string message;  ///< all of stderr
};

class Mistakes : public testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, EndWithCode2AndNameTheRemedy) {
  const CommandResult r = grouser_command(GetParam().arguments, source / "examples");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, GetParam().message);
  EXPECT_EQ(r.out, "");
}

const std::string rig = "03_single_wheel_rig/hit_ding.yaml", scenario = "02_robot_rough_ground/robot_iso_e.yaml";

#ifdef GROUSER_DEM
const std::string with_dem = ", soil, dem, sdem";
#else
const std::string with_dem;
#endif

INSTANTIATE_TEST_SUITE_P(
    CommandLine, Mistakes,
    testing::Values(
        Mistake{"rig_file_for_run", "run " + rig,
                rig + ":1:1: this is a rig file, not a scenario; use 'grouser rig " + rig + "'\n"},
        Mistake{"scenario_for_rig", "rig " + scenario,
                scenario + ":1:1: this is a scenario, not a rig file; use 'grouser run " + scenario + "'\n"},
        Mistake{"soil_for_run", "run soils/sandy_loam.yaml",
                "soils/sandy_loam.yaml:1:1: this is a soil, not a scenario; name it in a scenario, which begins with "
                "'scenario:'\n"},
        Mistake{
            "wheel_for_plot", "plot wheels/mit_wheel.yaml",
            "wheels/mit_wheel.yaml:1:1: this is a wheel, not a file of figures; name it in a file of figures, which "
            "begins with 'items:'\n"},
        Mistake{"slip_above_1", "rig " + rig + " --slips 0.1,2",
                "--slips: 2 by the definition 'rim': a travelling wheel has no slip of 1 or above; allowed is below "
                "1\n"},
        Mistake{"slip_no_number", "rig " + rig + " --slips 0.1,fast,nan",
                "--slips: 'fast' is not a number; for example '1'\n--slips: 'nan' is not a finite number; for example "
                "'1'\n"},
        Mistake{"slip_for_digging", "rig 03_single_wheel_rig/dig_mer.yaml --slips 0.1",
                "--slips: this rig imposes no slip but digs on the spot; leave the option out, or use a rig file with "
                "'slips'\n"},
        Mistake{"duration_negative", "run " + scenario + " --duration '-5 s'",
                "--duration: '-5 s' is out of range; allowed is more than 0 s and at most 1e+06 s\n"},
        Mistake{"duration_part_of_a_step", "run " + scenario + " --duration '1.5004 s' --out never",
                "--duration: must be a whole number of the scenario's time steps of 1 ms\n"},
        Mistake{"out_is_empty", "run " + scenario + " --out ''",
                "grouser: --out has no value; give one or leave it out\n"},
        Mistake{"out_is_nothing",
                "run " + scenario + " --out=", "grouser: --out has no value; give one or leave it out\n"},
        Mistake{"file_is_empty", "check ''", "grouser: argument 2 has no value; give one or leave it out\n"},
        Mistake{"duration_absurd", "run " + scenario + " --duration '1e30 s'",
                "--duration: '1e30 s' is out of range; allowed is more than 0 s and at most 1e+06 s\n"},
        Mistake{"forces_of_a_folder", "bekker forces soils --out never.csv",
                "soils: this is a folder; a CSV file is wanted\n"},
        Mistake{"control_characters", "check $(printf 'a\\033[31m.yaml')",
                "a\\x1b[31m.yaml: the file does not exist\n"},
        Mistake{"out_is_a_file", "run " + scenario + " --out soils/README.md",
                "soils/README.md: is a file; name a folder with --out\n"},
        Mistake{"list_nothing", "list nothing",
                "list: cannot list 'nothing'. Known: models, effects, soils, wheels, vehicles, grounds\n"},
        Mistake{"list_yaml_of_soils", "list soils --yaml",
                "--yaml: goes with 'list models'; 'list soils NAME' shows a whole file\n"},
        Mistake{"list_unknown_ground", "list grounds moon",
                "list grounds: no 'moon'. 'grouser list grounds' shows all 10\n"},
        Mistake{"list_unknown_model", "list models mud",
                "list: unknown terrain model 'mud'. Known: rigid, bekker.steady, bekker.soil_node, dem.sphere, sdem.v1, sdem.v2\n"},
        Mistake{"check_table", "check grounds/data/crater_field.csv",
                "grounds/data/crater_field.csv: a table alone says nothing of its use; check the ground, rig, fit or "
                "figures file that names it\n"},
        Mistake{"check_absent_urdf", "check absent.urdf", "absent.urdf: the file does not exist\n"},
        Mistake{"report_of_nothing", "report soils",
                "soils: has neither run.h5 nor sweep.csv; give a folder written by 'grouser run' or 'grouser rig'\n"},
        Mistake{"report_of_two", "report a b",
                "grouser report: folder: At Most 1 required but received 2\n'grouser report --help' shows how it is "
                "called\n"},
        Mistake{
            "compare_one", "compare soils",
            "grouser compare: folders: At least 2 required but received 1\n'grouser compare --help' shows how it is "
            "called\n"},
        Mistake{"doctor_of_something", "doctor me",
                "grouser doctor: too many arguments: 'me'\n'grouser doctor --help' shows how it is called\n"},
        Mistake{
            "unknown_option", "run " + scenario + " --duraton '5 s'",
            "grouser run: unknown option '--duraton'; did you mean '--duration'?\n'grouser run --help' shows how it "
            "is called\n"},
        Mistake{"no_command", "",
                "grouser: a command is wanted: run, rig, resume, check, list, report, compare, doctor, plot, fit, "
                "diagnose, bekker" +
                    with_dem + "\n'grouser --help' shows how it is called\n"},
        Mistake{"unknown_subcommand", "bekker sovle",
                "grouser bekker: unknown command 'sovle'; did you mean 'solve'? Known: forces, solve, table\n'grouser "
                "bekker --help' shows how it is called\n"},
        Mistake{"no_file", "run",
                "grouser run: argument missing: scenario is required\n'grouser run --help' shows how "
                "it is called\n"}),
    [](const testing::TestParamInfo<Mistake>& i) { return i.param.name; });

TEST(List, WithoutAWordSaysWhatCanBeListed) {
  const CommandResult r = grouser_command("list", source);
  EXPECT_EQ(r.code, 0);
  EXPECT_NE(r.out.find("grounds   ground files of the library"), std::string::npos) << r.out;
}

TEST(List, DescribesEveryFileOfTheLibrary) {
  for (const char* what : {"soils", "wheels", "vehicles", "grounds"}) {
    const CommandResult r = grouser_command(std::string("list ") + what, source);
    EXPECT_EQ(r.code, 0) << r.err;
    std::istringstream lines(r.out);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line.rfind("# ", 0), 0u) << "where the files are: " << line;
    int files = 0;
    for (; std::getline(lines, line); ++files) {
      std::istringstream words(line);
      std::string file, description;
      words >> file;
      std::getline(words, description);
      EXPECT_GT(description.size(), 4u) << what << ": " << line;
    }
    EXPECT_GE(files, 4) << what;
  }
  const CommandResult r = grouser_command("list grounds", source);
  EXPECT_NE(r.out.find("sinusoid, amplitude 9.75 mm"), std::string::npos) << r.out;
}

}  // namespace
}  // namespace grouser::test
