// Whole scenarios, short: loads, energy, drift, drivers, errors.
#include <algorithm>
#include <cmath>

#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

struct Case {
  const char *scenario, *terrain;
};
std::string name_of(const testing::TestParamInfo<Case>& i) {
  std::string n = std::string(i.param.scenario) + "_" + i.param.terrain;
  for (char& c : n)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return n;
}

class Shipped : public testing::TestWithParam<Case> {};

TEST_P(Shipped, StaticWheelLoadsSumToTheWeight) {
  const Folder f;
  const RunSummary s =
      run(examples / "02_robot_rough_ground" / GetParam().scenario, f.path() / "out", GetParam().terrain, 0.02);
  const RunFile file(f.path() / "out/run.h5");
  double sum = 0;
  std::string wheels = file.attribute("wheels") + ",";
  for (std::size_t at; (at = wheels.find(',')) != std::string::npos; wheels.erase(0, at + 1))
    sum += file.read(wheels.substr(0, at) + ".force").at(2);
  // First frame, at rest after settling.
  const double weight = s.total_mass * file.number("gravity", 0);
  EXPECT_NEAR(sum, weight, 1e-3 * weight);
}

TEST_P(Shipped, EnergyClosesAndJointsHold) {
  const Folder f;
  const RunSummary s =
      run(examples / "02_robot_rough_ground" / GetParam().scenario, f.path() / "out", GetParam().terrain, 3);
  EXPECT_LT(s.energy_residual_ratio, 0.005);
  EXPECT_LT(s.joint_drift_m, 1e-4);
  const RunFile file(f.path() / "out/run.h5");
  EXPECT_EQ(file.attribute("status"), "finished");
  EXPECT_EQ(file.attribute("end_state_hash"), s.end_state_hash);
}

INSTANTIATE_TEST_SUITE_P(Examples, Shipped,
                         testing::Values(Case{"robot_iso_e.yaml", "rigid"}, Case{"robot_iso_e.yaml", "bekker.steady"},
                                         Case{"robot_belgian_block.yaml", "bekker.steady"},
                                         Case{"rover_rocks.yaml", "rigid"}, Case{"rover_rocks.yaml", "bekker.steady"},
                                         Case{"offroad_iso_e.yaml", "rigid"},
                                         Case{"offroad_iso_e.yaml", "bekker.steady"}),
                         name_of);

TEST(Scenario, SpeedHoldHolds) {
  const Folder f;
  run(examples / "02_robot_rough_ground/robot_sinusoid.yaml", f.path() / "out", "rigid", 6);
  const RunFile file(f.path() / "out/run.h5");
  const std::vector<double> t = file.time(), v = file.read("vehicle.speed");
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] > 3) sum += v[i], ++n;
  // Mean over whole bumps of the sinusoid: 1 % of 0.5 m/s.
  EXPECT_NEAR(sum / n, 0.5, 0.005);
}

TEST(Scenario, PathFollowerReachesItsWaypoints) {
  for (const char* terrain : {"rigid", "bekker.steady"}) {
    const Folder f;
    run(examples / "02_robot_rough_ground/robot_path.yaml", f.path() / "out", terrain, 0);
    const RunFile file(f.path() / "out/run.h5");
    const std::vector<double> p = file.read("chassis.position");
    for (const auto& [x, y] : {std::pair{2.0, 0.0}, {3.5, 1.5}, {3.5, 3.5}}) {
      double nearest = 1e9;
      for (std::size_t i = 0; i + 2 < p.size(); i += 3) nearest = std::min(nearest, std::hypot(p[i] - x, p[i + 1] - y));
      EXPECT_LT(nearest, 0.36) << terrain << " waypoint " << x << ", "
                               << y;  // tolerance of the path: half the look-ahead, 0.35 m
    }
    EXPECT_LT(std::abs(last(file, "vehicle.speed")), 0.02) << terrain;  // and stops at the last one
  }
}

TEST(Scenario, SteeredVehicleReachesItsWaypoints) {
  const Folder f;
  std::string t = shipped("offroad_iso_e.yaml");
  t = t.substr(0, t.find("ground:")) +
      "driver: {type: path, speed: 3 m/s, ramp: 2 s, waypoints: [[10 m, 0 m], [18 m, 6 m]], lookahead: 3 m, tolerance: "
      "1 m}\n";
  const fs::path file = f.write("path.yaml", replaced(t, "duration: 10 s", "duration: 11 s"));
  run(file, f.path() / "out", "rigid", 0);
  const RunFile r(f.path() / "out/run.h5");
  const std::vector<double> p = r.read("chassis.position");
  for (const auto& [x, y] : {std::pair{10.0, 0.0}, {18.0, 6.0}}) {
    double nearest = 1e9;
    for (std::size_t i = 0; i + 2 < p.size(); i += 3) nearest = std::min(nearest, std::hypot(p[i] - x, p[i + 1] - y));
    EXPECT_LT(nearest, 1.05) << x << ", " << y;
  }
}

TEST(Scenario, ABrakedRobotAcrossASlopeStaysWithinATenthOfAMillimetre) {
  // Ten seconds; a minute of every vehicle and heading is in the slow set.
  for (const char* model : {"bekker.steady", "rigid"}) {
    const Folder f;
    run(parked(f.path(), "skid_robot.yaml", "90 deg"), f.path() / "out", model, 10);
    EXPECT_LT(greatest_way(RunFile(f.path() / "out/run.h5").read("chassis.position")), 1e-4) << model;
  }
}

TEST(Scenario, ARobotDrivenUpASlopeAndBrakedStaysWithinATenthOfAMillimetre) {
  // From two seconds after braking, six seconds; a minute and the other vehicles are in the slow set.
  for (const char* soil : {"dry_sand.yaml", "lunar_soil_nominal.yaml", "mojave_martian_simulant.yaml"}) {
    const Folder f;
    run(braked(f.path(), "skid_robot.yaml", soil, "0.5 m/s", 12), f.path() / "out", "bekker.steady", 0);
    EXPECT_LT(greatest_way(RunFile(f.path() / "out/run.h5").read("chassis.position"), 120), 1e-4) << soil;
  }
}

TEST(Scenario, UrdfAndYamlRobotSettleAtTheSameLoads) {
  const Folder f;
  run(examples / "02_robot_rough_ground/robot_sinusoid.yaml", f.path() / "yaml", "bekker.steady", 0.02);
  run(examples / "02_robot_rough_ground/robot_urdf_sinusoid.yaml", f.path() / "urdf", "bekker.steady", 0.02);
  const RunFile a(f.path() / "yaml/run.h5"), b(f.path() / "urdf/run.h5");
  for (const char* w : {"front_left", "front_right", "rear_left", "rear_right"}) {
    const double load = a.read(std::string(w) + ".force").at(2);
    EXPECT_NEAR(b.read(std::string(w) + ".force").at(2), load, 1e-6 * load) << w;
  }
}

TEST(Scenario, TerrainIsSwappedByNameAlone) {
  const Folder f;
  for (const char* terrain : {"rigid", "bekker.steady"}) {
    run(examples / "02_robot_rough_ground/robot_iso_e.yaml", f.path() / terrain, terrain, 0.1);
    EXPECT_EQ(RunFile(f.path() / terrain / "run.h5").attributes().terrain, terrain);
  }
}

TEST(Scenario, AVehicleThatFallsOffTheMapIsReportedByName) {
  // The map ends 1 m ahead: a cliff.
  const Folder f;
  std::string t = shipped("robot_iso_e.yaml");
  t = t.substr(0, t.find("ground:")) +
      "ground: {shape: step, height: -20 m, start: 0.8 m}\ndriver: {type: speed_hold, speed: 0.8 m/s}\n";
  const fs::path file = f.write("cliff.yaml", t);
  try {
    run(file, f.path() / "out", "rigid", 8);
    FAIL() << "the fall was not noticed";
  } catch (const SimulationError& e) {
    const std::string m = e.what();
    EXPECT_NE(m.find("stopped at t = "), std::string::npos) << m;
    EXPECT_NE(m.find("lost wheel"), std::string::npos) << m;
    EXPECT_NE(m.find("body 'front_"), std::string::npos) << m;
    EXPECT_NE(m.find("last good checkpoint: t = "), std::string::npos) << m;
  }
  const RunFile r(f.path() / "out/run.h5");
  EXPECT_GT(r.frames(), 50u);
  EXPECT_EQ(r.attribute("status").substr(0, 8), "stopped:");
}

TEST(Scenario, NotANumberIsReportedByName) {
  // A terrain that answers with nonsense after a while.
  struct Broken : Terrain {
    explicit Broken(GroundPtr g) : Terrain(std::move(g)) {}
    std::string id() const override { return "broken"; }
    Capabilities capabilities() const override { return {}; }
    void do_step(const StepContext& c, std::span<const BodyMotion> m, std::span<BodyResult> r) override {
      for (std::size_t i = 0; i < m.size(); ++i) {
        const double z = m[i].X_WB_end.p.z() - 0.11;
        r[i] = {};
        r[i].impulse.z() = c.dt * std::max(0.0, -2e5 * z - 1e3 * m[i].V_WB_end.v.z());
        if (c.t > 0.5 && i == 2 && c.commit) r[i].impulse.x() = std::nan("");
      }
    }
    void do_traverse(State&) override {}
  };
  Registry registry;
  registry.add({"broken", "", "", "", "", [](const TerrainArgs& a) { return std::make_unique<Broken>(a.ground); }});
  const Folder f;
  std::string t = shipped("robot_iso_e.yaml");
  t = replaced(t.substr(0, t.find("ground:")), "model: bekker.steady", "model: broken") +
      "start: {settle: 0.1 s}\ndriver: {type: speed_hold, speed: 0.5 m/s}\n";
  RunOptions o;
  o.out = f.path() / "out";
  try {
    run_scenario(f.write("broken.yaml", t), registry, o);
    FAIL() << "not a number went unnoticed";
  } catch (const SimulationError& e) {
    const std::string m = e.what();
    EXPECT_NE(m.find("'rear_left'"), std::string::npos) << m;
    EXPECT_NE(m.find("not finite"), std::string::npos) << m;
  }
  EXPECT_EQ(RunFile(f.path() / "out/run.h5").attribute("status").substr(0, 8), "stopped:");
}

TEST(Scenario, AllErrorsOfAllFilesComeAtOnce) {
  const Folder f;
  std::string vehicle = read(examples / "vehicles/skid_robot.yaml");
  for (std::size_t at = 0; (at = vehicle.find("../", at)) != std::string::npos;)
    vehicle.replace(at, 3, examples.string() + "/");
  f.write("bad_vehicle.yaml", replaced(vehicle, "motor: drive", "motr: drive"));
  std::string t =
      replaced(shipped("robot_iso_e.yaml"), (examples / "vehicles/skid_robot.yaml").string(), "bad_vehicle.yaml");
  t = replaced(t, "time_step: 1 ms", "time_step: 1");
  t = replaced(t, "model: bekker.steady", "model: beker.steady");
  const fs::path file = f.write("bad.yaml", t);
  try {
    check_scenario(file, all_models());
    FAIL() << "the errors were not noticed";
  } catch (const ConfigError& e) {
    const std::string m = e.what();
    EXPECT_EQ(e.diagnostics().size(), 3u) << m;
    EXPECT_NE(m.find("bad_vehicle.yaml:"), std::string::npos) << m;
    EXPECT_NE(m.find("unknown key 'motr'"), std::string::npos) << m;
    EXPECT_NE(m.find("time_step"), std::string::npos) << m;
    EXPECT_NE(m.find("beker.steady"), std::string::npos) << m;
  }
}

}  // namespace
}  // namespace grouser::vehicle
