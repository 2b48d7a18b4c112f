// The commands as a user calls them: results, exit codes, and what is said when a results file is not what it should be.
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

/// Half a second of the robot on `terrain`, run once per program.
const fs::path& short_run(const std::string& terrain) {
  static std::map<std::string, fs::path> runs;
  auto [it, fresh] = runs.try_emplace(terrain, scratch() / ("run-" + terrain));
  if (fresh) {
    const CommandResult r =
        grouser_command("run examples/02_robot_rough_ground/robot_sinusoid.yaml --quiet --duration '1.5 s' --terrain " +
                            terrain + " --out " + it->second.string(),
                        source);
    EXPECT_EQ(r.code, 0) << r.err;
  }
  return it->second;
}

void expect_error(const std::string& arguments, const std::string& message) {
  const CommandResult r = grouser_command(arguments, source);
  EXPECT_EQ(r.code, 2) << r.out;
  EXPECT_EQ(r.err, message);
}

TEST(Run, LeavesResultsReportAndAStateHash) {
  const fs::path& folder = short_run("bekker.steady");
  for (const char* file : {"run.h5", "run.xdmf", "checkpoint.h5", "report.html"})
    EXPECT_TRUE(fs::exists(folder / file)) << file;
  const CommandResult r = grouser_command("check " + (folder / "run.h5").string(), source);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("on bekker.steady"), std::string::npos) << r.out;
}

TEST(Run, RefusesToReplaceEarlierResultsUnlessAsked) {
  const fs::path& folder = short_run("rigid");
  expect_error(
      "run examples/02_robot_rough_ground/robot_sinusoid.yaml --out " + folder.string(),
      folder.string() + ": holds the results of an earlier run; use --overwrite, or another folder with --out\n");
}

TEST(Run, UnknownTerrainIsNamedWithTheNearest) {
  expect_error(
      "run examples/02_robot_rough_ground/robot_sinusoid.yaml --terrain rigd",
      "--terrain: unknown terrain model 'rigd'; did you mean 'rigid'? Known: rigid, bekker.steady, bekker.soil_node, dem.sphere, sdem.v1, sdem.v2\n");
}

TEST(Run, DurationNeedsAUnit) {
  expect_error(
      "run examples/02_robot_rough_ground/robot_sinusoid.yaml --duration 5 --out " + (scratch() / "none").string(),
      "--duration: '5' has no unit; a time is wanted, for example '5 s'\n");
  EXPECT_FALSE(fs::exists(scratch() / "none"));
}

TEST(Compare, PutsTwoRunsIntoOneReport) {
  const fs::path out = scratch() / "compare.html";
  const CommandResult r = grouser_command(
      "compare " + short_run("rigid").string() + " " + short_run("bekker.steady").string() + " -o " + out.string(),
      source);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_GT(fs::file_size(out), 100000u);
}

TEST(Resume, RefusesACheckpointOfAnotherScenario) {
  const fs::path mixed = scratch() / "mixed";
  fs::copy(short_run("rigid"), mixed, fs::copy_options::recursive);
  fs::copy_file(short_run("bekker.steady") / "checkpoint.h5", mixed / "checkpoint.h5",
                fs::copy_options::overwrite_existing);
  const CommandResult r = grouser_command("resume " + mixed.string(), source);
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("checkpoint of another scenario"), std::string::npos) << r.err;
}

TEST(Resume, RefusesATruncatedCheckpoint) {
  const fs::path cut = scratch() / "cut";
  fs::copy(short_run("rigid"), cut, fs::copy_options::recursive);
  fs::resize_file(cut / "checkpoint.h5", 3000);
  const CommandResult r = grouser_command("resume " + cut.string(), source);
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err.find((cut / "checkpoint.h5").string() + ": is truncated"), 0u) << r.err;
}

TEST(Check, NamesWhatIsWrongWithAResultsFile) {
  const fs::path cut = scratch() / "cut.h5", text = scratch() / "text.h5", absent = scratch() / "absent.h5";
  fs::copy_file(short_run("rigid") / "run.h5", cut, fs::copy_options::overwrite_existing);
  fs::resize_file(cut, 100000);
  std::ofstream(text) << "hello\n";
  CommandResult r = grouser_command("check " + cut.string(), source);
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err.find(cut.string() + ": is truncated: it holds 100000 of "), 0u) << r.err;
  expect_error("check " + text.string(), text.string() + ": is not an HDF5 file; name a file that grouser wrote\n");
  expect_error("check " + absent.string(), absent.string() + ": no such file; check the path\n");
}

TEST(Check, PassesEveryShippedFile) {
  for (const char* folder : {"soils", "wheels", "grounds", "02_robot_rough_ground", "03_single_wheel_rig"}) {
    const CommandResult r = grouser_command("check examples/" + std::string(folder) + "/*.yaml", source);
    EXPECT_EQ(r.code, 0) << folder << "\n" << r.err;
  }
  const CommandResult r = grouser_command("check examples/vehicles/*.yaml", source);
  EXPECT_EQ(r.code, 0) << r.err;
}

TEST(List, ShowsModelsWithWhatTheyCannotDo) {
  const CommandResult r = grouser_command("list models", source);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("bekker.steady\n"), std::string::npos);
  EXPECT_NE(r.out.find("cannot: "), std::string::npos);
  expect_error("list modls",
               "list: cannot list 'modls'; did you mean 'models'? Known: models, effects, soils, wheels, "
               "vehicles, grounds\n");
  expect_error("list soils sandyloam",
               "list soils: no 'sandyloam'; did you mean 'sandy_loam'? 'grouser list soils' shows all 35\n");
}

TEST(Doctor, FindsThisBuildWell) {
  const CommandResult r = grouser_command("doctor", source);
  EXPECT_EQ(r.code, 0) << r.out;
  EXPECT_NE(r.out.find("all well"), std::string::npos);
}

TEST(Command, UnknownCommandIsNamedWithTheNearest) {
  expect_error("runn x",
               "unknown command 'runn'; did you mean 'run'? Known: run, rig, resume, check, list, report, compare, "
               "doctor, plot, fit, diagnose, bekker, soil, dem, sdem\n");
}

}  // namespace
}  // namespace grouser::test
