// Scenarios that were let through, or refused without a place, a reason or a remedy.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "command.h"

namespace grouser::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string examples = (source / "examples").string();

/// A scenario of the library's robot with these further lines; `terrain` goes into the terrain's map.
void write_scenario(const std::string& lines, const std::string& terrain = "",
                    const std::string& driver = "{type: speed_hold, speed: 0.5 m/s, ramp: 1 s}") {
  std::ofstream(scratch() / "s.yaml") << "scenario: test\nvehicle: " << examples
                                      << "/vehicles/skid_robot.yaml\nterrain: {model: bekker.steady, soil: " << examples
                                      << "/soils/dry_sand.yaml" << terrain << "}\ndriver: " << driver << '\n'
                                      << lines;
}
CommandResult check_scenario(const std::string& lines, const std::string& terrain = "",
                             const std::string& driver = "{type: speed_hold, speed: 0.5 m/s, ramp: 1 s}") {
  write_scenario("duration: 0.5 s\n" + lines, terrain, driver);
  return grouser_command("check s.yaml", scratch());
}
const std::string map_with_an_end = "ground: {shape: height_map, file: " + examples +
                                    "/grounds/data/crater_field.asc, lower_left: [1 m, -3 m], outside: error}\n";

TEST(GroundThatEnds, AStartBesideItIsFoundByCheckAtItsPlace) {
  const CommandResult none = check_scenario(map_with_an_end);
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, AllOf(HasSubstr("s.yaml:6:1: ground: the vehicle would start where there is no ground: "),
                              HasSubstr("the point (0, 0) m is outside its extent x 1..9 m"),
                              HasSubstr("choose another start ('start: {x: ..., y: ...}'), or 'outside: extend'")));
  // The chassis is on the map, a wheel is not.
  const CommandResult wheel = check_scenario(map_with_an_end + "start: {x: 1.1 m}\n");
  EXPECT_EQ(wheel.code, 2);
  EXPECT_THAT(wheel.err, AllOf(HasSubstr("s.yaml:7:1: start: wheel 'rear_left' would start where there is no ground"),
                               HasSubstr("outside its extent")));
  const CommandResult inside = check_scenario(map_with_an_end + "start: {x: 4 m}\n");
  EXPECT_EQ(inside.code, 0) << inside.err;
}

TEST(GroundThatEnds, ARunThatStaysOnItIsNotStoppedByTheMarginOfTheView) {
  write_scenario("duration: 0.5 s\n" + map_with_an_end + "start: {x: 8 m}\n");
  const CommandResult r = grouser_command("run s.yaml --quiet --no-report --overwrite --out ends", scratch());
  EXPECT_EQ(r.code, 0) << r.err;
}

TEST(GroundThatEnds, AWheelThatLeavesItStopsTheRunAndIsNamedWithTheTimeAndTheCheckpoint) {
  write_scenario("duration: 10 s\n" + map_with_an_end + "start: {x: 8.4 m}\n");
  const CommandResult r = grouser_command("run s.yaml --quiet --no-report --overwrite --out leaves", scratch());
  EXPECT_EQ(r.code, 1);
  EXPECT_THAT(r.err, AllOf(HasSubstr("stopped at t = "), HasSubstr("body 'front_"), HasSubstr("off the map"),
                           HasSubstr("last good checkpoint: t = ")));
}

TEST(TerrainSections, AnUnknownModelIdIsAnsweredWithTheKnownOnes) {
  const CommandResult typo = check_scenario("", ", options: {bekker.stedy: {points: 20}}");
  EXPECT_EQ(typo.code, 2);
  EXPECT_THAT(typo.err, HasSubstr("unknown key 'bekker.stedy' in terrain.options; did you mean 'bekker.steady'?"));
  const CommandResult bare = check_scenario("", ", effects: {vertical_damping: 1 s/m}");
  EXPECT_EQ(bare.code, 2);
  EXPECT_THAT(bare.err, HasSubstr("unknown key 'vertical_damping' in terrain.effects; known here: "));
  EXPECT_THAT(bare.err, HasSubstr("bekker.steady"));
}

TEST(TerrainSections, OptionsOfAModelThatIsNotInUseAreCheckedToo) {
  const CommandResult wrong =
      check_scenario("", ", options: {bekker.steady: {points: 20}, rigid: {strips: -1, stiffnes: 1e6 N/m}}");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("terrain.options.rigid.strips: '-1' is out of range"),
                               HasSubstr("unknown key 'stiffnes' in terrain.options.rigid")));
  const CommandResult effect = check_scenario("", ", effects: {bekker.soil_node: {no_such_effect: 1}}");
  EXPECT_EQ(effect.code, 2);
  EXPECT_THAT(effect.err, HasSubstr("no_such_effect"));
  EXPECT_EQ(check_scenario("", ", options: {bekker.steady: {points: 20}, rigid: {strips: 3}}").code, 0);
}

TEST(Drivers, AnUnknownTypeIsTheOnlyError) {
  const CommandResult r = check_scenario("", "", "{type: speedhold, speed: 0.5 m/s, ramp: 1 s}");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("driver.type: 'speedhold' is not one of: open_loop, speed_hold, path; did you mean "
                               "'speed_hold'?\n"));
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

TEST(Drivers, SteeringAVehicleWithoutASteeredJointIsRefusedInEveryType) {
  for (const char* driver : {"{type: speed_hold, speed: 0.5 m/s, steer: 5 deg}",
                             "{type: open_loop, table: [{time: 0 s, speed: 0.5 m/s, steer: 5 deg}]}"}) {
    const CommandResult r = check_scenario("", "", driver);
    EXPECT_EQ(r.code, 2) << driver;
    EXPECT_THAT(r.err, HasSubstr("steer: the vehicle has no steered joint")) << driver;
  }
}

TEST(Drivers, ASpeedBeyondTheMotorsIsTold) {
  const CommandResult fast = check_scenario("", "", "{type: speed_hold, speed: 50 m/s, ramp: 1 s}");
  EXPECT_EQ(fast.code, 0) << fast.err;
  EXPECT_THAT(fast.out, HasSubstr("note: the driver asks for 50 m/s, the motors turn the wheels at "));
  EXPECT_THAT(check_scenario("").out, Not(HasSubstr("the driver asks")));
}

TEST(DataFiles, EmptyCellsAndHeightsBeyondAnyGroundAreNamedWithARemedy) {
  std::ofstream(scratch() / "p.csv") << "s_m,z_mm\n0,1\n0.1,\n0.2,1e300\n0.3,2\n";
  const CommandResult r = check_scenario("ground: {shape: profile, file: p.csv, length_unit: m, height_unit: mm}\n");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, AllOf(HasSubstr("p.csv:3:5: row 2, column 2 ('z_mm'): the cell is empty; fill it in"),
                           HasSubstr("p.csv:4:5: row 3, column 2 ('z_mm'): '1e300' is out of range; allowed is -1e+09 "
                                     "to 1e+09, look at the exponent and the unit")));
}

TEST(RigSlips, AUnitBehindTheLastOneIsItsOwn) {
  std::ofstream(scratch() / "r.yaml") << "rig: test\nwheel: " << examples
                                      << "/wheels/mit_wheel.yaml\nterrain: {model: bekker.steady, soil: " << examples
                                      << "/soils/dry_sand.yaml}\nload: 80 N\nangular_speed: 0.3 rad/s\nslips: [0.2]\n"
                                         "slip_definition: symmetric\nsettle: 0.05 s\nramp: 0.05 s\nduration: 0.1 s\n";
  const CommandResult r =
      grouser_command("rig r.yaml --slips -0.3,0,30% --overwrite --quiet --no-report --out slips", scratch());
  ASSERT_EQ(r.code, 0) << r.err;
  std::istringstream table(read_text(scratch() / "slips/sweep.csv"));
  std::vector<double> slips;
  for (std::string line; std::getline(table, line);)
    if (!line.empty() && line[0] != '#' && line.rfind("slip", 0) != 0) slips.push_back(std::stod(line));
  EXPECT_THAT(slips, testing::ElementsAre(-0.3, 0, 0.3));
}

TEST(BekkerSolve, AColumnInAnotherUnitIsNamedByTheOneThatIsMissing) {
  std::ofstream(scratch() / "deg.csv")
      << "c_Pa,phi_deg,n,K_m,kc,kphi,radius_m,width_m,load_N,a0,a1,b0,b1,beta_rad,slip\n"
         "1700,29,0.7,0.025,5300,1515000,0.08,0.075,80,0.4,0.15,0,0,0,0.2\n";
  const CommandResult r = grouser_command("bekker solve deg.csv --out none.csv", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err,
            "deg.csv:1:6: missing column 'phi_rad'; 'phi_deg' is in another unit: convert it and rename the column\n");
}

}  // namespace
}  // namespace grouser::test
