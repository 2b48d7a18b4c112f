// What a terrain simplifies in a wheel is printed and stands among the assumptions of the results.
#include <gtest/gtest.h>

#include "command.h"
#include "grouser/terrain/recorder.h"

namespace grouser::test {
namespace {

/// A rig file of the library on another terrain, short.
CommandResult rig_with(const std::string& file, const std::string& wheel, const std::string& model,
                       const std::string& options, const std::filesystem::path& out) {
  const std::string examples = (source / "examples").string();
  std::ofstream(scratch() / "r.yaml") << "rig: test\nwheel: " << examples << "/wheels/" << wheel
                                      << "\nterrain:\n  model: " << model << "\n  soil: " << examples << "/soils/"
                                      << file << "\n"
                                      << options
                                      << "load: 80 N\nangular_speed: 0.3 rad/s\nslips: [0.2]\nslip_definition: rim\n"
                                         "settle: 0.05 s\nramp: 0.05 s\nduration: 0.1 s\n";
  return grouser_command("rig r.yaml --overwrite --quiet --no-report --out " + out.string(), scratch());
}

std::string assumptions(const std::filesystem::path& out) {
  return RunFile(out / "case_000/run.h5").attribute("assumptions");
}

const std::string mean_lugs = "wheel simplified: lugs as the mean pressure of tips (share ";

TEST(SimplifiedWheels, LugsThatBekkerSteadyTakesAsAMeanAreTold) {
  const auto out = scratch() / "steady";
  const CommandResult r = rig_with("lunar_soil_nominal.yaml", "mer_wheel.yaml", "bekker.steady", "", out);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("note: " + mean_lugs), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("model bekker.steady does not take lugs one by one"), std::string::npos) << r.out;
  EXPECT_NE(assumptions(out).find("eqs 2.14 and 2.15"), std::string::npos) << assumptions(out);
}

TEST(SimplifiedWheels, ThinLugsOnSoilNodesAreToldAndResolvedOnesAreNot) {
  const auto out = scratch() / "nodes";
  CommandResult r = rig_with("lunar_soil_nominal.yaml", "mer_wheel.yaml", "bekker.soil_node", "", out);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("the lugs are narrower than 2 node spacings or 4 shear displacements K"), std::string::npos)
      << r.out;
  r = rig_with("lunar_soil_nominal.yaml", "mer_wheel.yaml", "bekker.soil_node",
               "  options: {bekker.soil_node: {lugs: resolved}}\n", out);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.find("note:"), std::string::npos) << r.out;
}

TEST(SimplifiedWheels, ALuggedWheelOnHardGroundIsToldToBeACylinder) {
  const auto out = scratch() / "rigid";
  const CommandResult r = rig_with("lunar_soil_nominal.yaml", "mer_wheel.yaml", "rigid", "", out);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_NE(r.out.find("note: wheel simplified: smooth cylinder of radius "), std::string::npos) << r.out;
  EXPECT_NE(assumptions(out).find("does not resolve lugs"), std::string::npos) << assumptions(out);
}

TEST(SimplifiedWheels, ASmoothWheelIsTakenAsItIs) {
  const CommandResult r =
      rig_with("mojave_martian_simulant.yaml", "mit_wheel.yaml", "bekker.steady", "", scratch() / "smooth");
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out.find("note:"), std::string::npos) << r.out;
}

TEST(SimplifiedWheels, AVehicleNamesAllItsWheelsInOneLine) {
  const auto out = scratch() / "rover";
  const CommandResult r = grouser_command(
      "run 02_robot_rough_ground/rover_rocks.yaml --duration '0.01 s' --quiet --no-report --out " + out.string(),
      source / "examples");
  EXPECT_EQ(r.code, 0) << r.err;
  const std::size_t at = r.out.find("note: ");
  ASSERT_NE(at, std::string::npos) << r.out;
  EXPECT_EQ(r.out.find("note: ", at + 1), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("front_left, front_right, middle_left, middle_right, rear_left, rear_right simplified: lugs as "
                       "the mean pressure"),
            std::string::npos)
      << r.out;
}

}  // namespace
}  // namespace grouser::test
