// What a run says of itself: where its ground ends, what its energy is compared with, what it assumes, how it looks.
#include <algorithm>
#include <cmath>
#include <set>

#include "grouser/vehicle/scenario.h"
#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

constexpr double degree = pi / 180;

TEST(BelgianBlock, ThePathDriverKeepsTheRobotStraightOnTheMeasuredLines) {
  for (const char* model : {"rigid", "bekker.steady"}) {
    const Folder f;
    const RunSummary s = run(examples / "02_robot_rough_ground/robot_belgian_block.yaml", f.path() / "out", model, 15);
    const RunFile r(f.path() / "out/run.h5");
    const std::vector<double> yaw = r.read("vehicle.yaw");
    const double most = std::abs(
        *std::max_element(yaw.begin(), yaw.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
    EXPECT_LT(most, 2 * degree) << model;  // 0.3 and 0.7 degrees
    EXPECT_GT(last(r, "vehicle.distance"), 7) << model;
    EXPECT_TRUE(s.warnings.empty()) << model << ": " << s.warnings.front();
  }
}

TEST(Extent, AWheelBesideTheMeasuredLinesIsWarnedOf) {
  const Folder f;
  // The data reach from -1.3 m to 1.7 m across; moved by 1.1 m to the left their right edge lies under the middle of the right wheels.
  const fs::path file =
      f.write("edge.yaml", replaced(shipped("robot_belgian_block.yaml"), "seam: 1 m", "seam: 1 m\n    lateral: 1.1 m"));
  const RunSummary s = run(file, f.path() / "out", "rigid", 3);
  ASSERT_EQ(s.warnings.size(), 2u);
  const RunFile r(f.path() / "out/run.h5");
  for (const std::string wheel : {"front_right", "rear_right"}) {
    // Beyond 0.6 m the ground is the profile: the first frame with the wheel there.
    const std::vector<double> p = r.read(wheel + ".position"), t = r.time();
    std::size_t first = 0, outside = 0;
    for (std::size_t i = t.size(); i-- > 0;)
      if (p[3 * i] > 0.6) ++outside, first = i;
    char since[40], share[40];
    std::snprintf(since, sizeof since, "at t = %.2f s", t[first]);
    std::snprintf(share, sizeof share, "for %.0f %% of",
                  100.0 * static_cast<double>(outside) / static_cast<double>(t.size()));
    const auto at = std::find_if(s.warnings.begin(), s.warnings.end(),
                                 [&](const std::string& w) { return w.find("wheel " + wheel) == 0; });
    ASSERT_NE(at, s.warnings.end()) << wheel;
    for (const std::string& part :
         {std::string(since), std::string(share), std::string("right of the outermost line, whose heights continue")})
      EXPECT_NE(at->find(part), std::string::npos) << part << " in " << *at;
    EXPECT_NE(r.attribute("warnings").find(*at), std::string::npos) << "the report reads it from run.h5";
  }
}

TEST(Settling, ARunThatDoesNotBeginAtRestSaysSoAndOneThatDoesIsSilent) {
  const Folder f;
  const std::string text = read(parked(f.path(), "skid_robot.yaml", "90 deg"));
  const fs::path hasty = f.write("hasty.yaml", replaced(text, "yaw: 90 deg", "yaw: 90 deg, settle: 20 ms"));
  const RunSummary moving = run(hasty, f.path() / "moving", "bekker.steady", 0.5);
  ASSERT_EQ(moving.warnings.size(), 1u);
  EXPECT_NE(moving.warnings[0].find("not at rest"), std::string::npos) << moving.warnings[0];
  EXPECT_NE(RunFile(f.path() / "moving/run.h5").attribute("warnings").find("not at rest"), std::string::npos);
  EXPECT_TRUE(run(f.path() / "parked.yaml", f.path() / "resting", "bekker.steady", 0.5).warnings.empty());
}

TEST(Energy, AStepThatDoesNotResolveTheContactIsToldWithTheOneThatDoesAndTheLedgerClosesStill) {
  // On heavy clay the robot's wheels stand 7 um deep. Same soil, same ground: at 1 ms the bounces belong to the step, at the step that is
  // advised they do not.
  const Folder f;
  const std::string clay = replaced(shipped("robot_sinusoid.yaml"), "sandy_loam", "heavy_clay_25_wes");
  const RunSummary coarse = run(f.write("coarse.yaml", clay), f.path() / "coarse", "bekker.steady", 3);
  EXPECT_LT(coarse.energy_residual_ratio, 0.005);
  ASSERT_EQ(coarse.warnings.size(), 1u);
  const std::string& w = coarse.warnings[0];
  EXPECT_NE(w.find("time_step 1 ms does not resolve the contact of wheel '"), std::string::npos) << w;
  EXPECT_NE(w.find(" Hz across the surface"), std::string::npos) << w;
  const std::string mark = "; time_step ";
  const auto at = w.find(mark);
  ASSERT_NE(at, std::string::npos) << w;
  const std::string advised = w.substr(at + mark.size(), w.find(" ms resolves it") - at - mark.size());
  EXPECT_GT(std::stod(advised), 0.1) << w;
  EXPECT_LT(std::stod(advised), 0.5) << w;
  // The outputs' period must be whole steps: the next finer round one.
  const fs::path fine = f.write("fine.yaml", replaced(clay, "time_step: 1 ms", "time_step: 0.2 ms"));
  const RunSummary resolved = run(fine, f.path() / "fine", "bekker.steady", 3);
  EXPECT_TRUE(resolved.warnings.empty()) << resolved.warnings.front();
  EXPECT_LT(resolved.energy_residual_ratio, 0.005);
}

TEST(Energy, TheYardstickIsThePositiveMotorWork) {
  const Folder f;
  // A frame per step: the recorded work of the motors says when they drove and when they braked.
  const fs::path file = f.write("fine.yaml", replaced(shipped("robot_sinusoid.yaml"), "rate: 100 Hz", "rate: 1000 Hz"));
  const RunSummary s = run(file, f.path() / "out", "rigid", 4);
  const RunFile r(f.path() / "out/run.h5");
  const std::vector<double> motor = r.read("energy.motor");
  double driving = 0, braking = 0;
  for (std::size_t i = 1; i < motor.size(); ++i)
    (motor[i] > motor[i - 1] ? driving : braking) += motor[i] - motor[i - 1];
  ASSERT_LT(braking, -1) << "the bumps drive the motors, so the difference matters";
  EXPECT_NEAR(s.energy_yardstick_J, driving, 1e-9 * driving);
  EXPECT_EQ(s.energy_yardstick, "positive motor work");
  EXPECT_NEAR(s.energy_residual_ratio, std::abs(last(r, "energy.residual")) / driving, 1e-9);
  EXPECT_LT(s.energy_residual_ratio, 0.005);
}

TEST(ShippedScenarios, TheRobotOverClassEKeepsItsLineOnHardGroundAndOnSoil) {
  // A tenth of a metre: a quarter of the track. With equal wheel speeds it ends 0.48 m off on soil.
  const Folder f;
  for (const char* terrain : {"rigid", "bekker.steady"}) {
    run(examples / "02_robot_rough_ground/robot_iso_e.yaml", f.path() / terrain, terrain, 15);
    const std::vector<double> p = RunFile(f.path() / terrain / "run.h5").read("chassis.position");
    double off = 0;
    for (std::size_t i = 1; i < p.size(); i += 3) off = std::max(off, std::abs(p[i]));
    EXPECT_LT(off, 0.1) << terrain;
    EXPECT_GT(p[p.size() - 3], 5.5) << terrain << ": and gets on";
  }
}

TEST(Energy, ACoastingVehicleIsMeasuredByTheHeightItGivesUp) {
  const Folder f;
  std::string text = replaced(shipped("robot_slope_parked.yaml"), "angle: 10 deg", "angle: -10 deg");
  text = replaced(text, "speed: 0 m/s", "torque: 0 N m");
  text = replaced(text, "driver:", "start: {settle: 0 s}\ndriver:");
  const RunSummary s = run(f.write("coast.yaml", text), f.path() / "out", "rigid", 2);
  const RunFile r(f.path() / "out/run.h5");
  EXPECT_EQ(s.energy_yardstick, "height energy given up");
  EXPECT_GT(s.energy_yardstick_J, 10);
  EXPECT_NEAR(s.energy_yardstick_J, -last(r, "energy.potential"), 1e-9);
  EXPECT_LT(s.energy_residual_ratio, 0.005);
}

std::string assumptions(const Folder& f, const std::string& terrain) {
  std::string t = shipped("robot_sinusoid.yaml");
  const auto a = t.find("terrain:"), b = t.find("ground:");
  t.replace(a, b - a, "terrain: " + terrain + "\n");
  std::string keys;
  for (const Assumption& x : load_scenario(f.write("s.yaml", t), all_models()).assumptions)
    if (x.key.find("unloading") != std::string::npos) keys += x.key + " = " + x.value + ": " + x.why + "\n";
  return keys;
}

TEST(Assumptions, AnUnloadingSlopeThatNobodyMeasuredIsListed) {
  const Folder f;
  const std::string soils = (examples / "soils").string() + "/", model = "{model: bekker.soil_node, soil: " + soils;
  const std::string assumed =
      "terrain.options.bekker.soil_node.unloading_rebound = 0.02: soil 'Sandy loam' has no measured unloading slope "
      "(`repetitive`)\n";
  EXPECT_EQ(assumptions(f, model + "sandy_loam.yaml}"), assumed);
  EXPECT_EQ(assumptions(f, model + "sandy_loam.yaml, options: {bekker.soil_node: {closure: local}}}"), assumed);
  EXPECT_EQ(assumptions(f, model + "sandy_loam.yaml, options: {bekker.soil_node: {unloading_rebound: 0.1}}}"), "");
  EXPECT_EQ(assumptions(f, "{model: bekker.steady, soil: " + soils + "sandy_loam.yaml}"), "");
  EXPECT_EQ(assumptions(f, model + "dry_sand_wong_loose.yaml}"), "") << "measured by Wong";
}

TEST(Playback, ASmoothWheelIsDrawnRound) {
  const Folder f;
  run(examples / "02_robot_rough_ground/robot_sinusoid.yaml", f.path() / "out", "rigid", 0.01);
  const std::vector<double> v = RunFile(f.path() / "out/run.h5").read("mesh.front_left.vertices");
  std::set<long> angles;
  double least = 1, most = 0;
  for (std::size_t i = 0; i + 2 < v.size(); i += 3) {
    const double r = std::hypot(v[i], v[i + 2]);
    if (r < 1e-9) continue;  // centre of a side
    least = std::min(least, r);
    most = std::max(most, r);
    angles.insert(std::lround(1e6 * std::atan2(v[i + 2], v[i])));
  }
  EXPECT_NEAR(least, most, 1e-12);
  EXPECT_NEAR(most, 0.11, 1e-12);
  // Between two corners the chord lies below the circle by r (1 - cos(pi/n)): a tenth of a millimetre is less than a pixel.
  EXPECT_LT(most * (1 - std::cos(pi / static_cast<double>(angles.size()))), 1e-4);
}

}  // namespace
}  // namespace grouser::vehicle
