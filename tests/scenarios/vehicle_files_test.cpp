// Vehicle files: what they say is what is built, and what is wrong in them is named with line and column.
#include <algorithm>
#include <cmath>

#include "grouser/vehicle/vehicle_loader.h"
#include "support.h"

namespace grouser::vehicle {
namespace {

using test::Folder;

std::string robot() {
  std::string t = test::read(test::examples / "vehicles/skid_robot.yaml");
  for (std::size_t at = 0; (at = t.find("../", at)) != std::string::npos;)
    t.replace(at, 3, test::examples.string() + "/");
  return t;
}

std::string rover() {
  std::string t = test::read(test::examples / "vehicles/rover.yaml");
  for (std::size_t at = 0; (at = t.find("../", at)) != std::string::npos;)
    t.replace(at, 3, test::examples.string() + "/");
  return t;
}

/// All error lines of a vehicle, file names without their folder.
std::string errors_of(const std::string& text, const std::string& name = "v.yaml",
                      const std::string& extras = "x: 1\n") {
  const Folder f;
  InputLog log;
  const ConfigDocument e = ConfigDocument::from_text(extras, "scenario.yaml", f.path());
  load_vehicle(f.write(name, text), e.root(), log);
  try {
    log.check();
  } catch (const ConfigError& err) {
    std::string all = err.what();
    for (std::size_t at; (at = all.find(f.path().string() + "/")) != std::string::npos;)
      all.erase(at, f.path().string().size() + 1);
    return all;
  }
  return "";
}

int line_of(const std::string& text, const std::string& what) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n'));
}

TEST(VehicleFiles, ShippedVehiclesHaveTheirMassAndSize) {
  struct Case {
    const char* file;
    double mass, track, wheelbase;
    std::size_t wheels;
  };
  for (const Case& c : {Case{"skid_robot.yaml", 30, 0.40, 0.45, 4}, Case{"rover.yaml", 172, 1.06, 1.40, 6},
                        Case{"offroad.yaml", 1200, 1.50, 2.40, 4}}) {
    InputLog log;
    const VehicleSpec v = load_vehicle(test::examples / "vehicles" / c.file, {}, log);
    ASSERT_NO_THROW(log.check()) << c.file;
    EXPECT_NEAR(v.total_mass(), c.mass, 1e-9) << c.file;
    EXPECT_NEAR(v.track(), c.track, 1e-9) << c.file;
    EXPECT_NEAR(v.wheelbase(), c.wheelbase, 1e-9) << c.file;
    EXPECT_EQ(v.wheels.size(), c.wheels) << c.file;
  }
}

TEST(VehicleFiles, UnknownCarrierIsNamedWithItsPlaceAndTheNearestName) {
  const std::string t = test::replaced(robot(), "carrier: chassis", "carrier: chasis");
  const int line = line_of(t, "carrier: chasis");
  EXPECT_EQ(errors_of(t),
            "v.yaml:" + std::to_string(line) +
                ":14: wheels.front_left.carrier: unknown body 'chasis'; did you mean 'chassis'? known: chassis");
}

TEST(VehicleFiles, UnknownMotorIsNamed) {
  const std::string t = test::replaced(robot(), "motor: drive", "motor: drvie");
  EXPECT_EQ(errors_of(t),
            "v.yaml:" + std::to_string(line_of(t, "motor: drvie")) +
                ":12: wheels.front_left.motor: unknown motor 'drvie'; did you mean 'drive'? known: drive");
}

TEST(VehicleFiles, ZeroMassIsRefused) {
  const std::string t = test::replaced(robot(), "{assumed: 22 kg,", "{assumed: 0 kg,");
  const std::string e = errors_of(t);
  EXPECT_NE(e.find("v.yaml:" + std::to_string(line_of(t, "assumed: 0 kg"))), std::string::npos) << e;
  EXPECT_NE(e.find("mass"), std::string::npos) << e;
}

TEST(VehicleFiles, MissingWheelFileIsNamed) {
  const std::string t = test::replaced(robot(), "wheels/robot_wheel.yaml", "wheels/robot_wheeel.yaml");
  const std::string e = errors_of(t);
  EXPECT_NE(e.find("v.yaml:" + std::to_string(line_of(t, "robot_wheeel"))), std::string::npos) << e;
  EXPECT_NE(e.find("robot_wheeel.yaml"), std::string::npos) << e;
}

TEST(VehicleFiles, AnInertiaThatNoBodyHasIsRefused) {
  const std::string t =
      test::replaced(robot(), "{box: {assumed: [0.60 m, 0.28 m, 0.16 m], why: \"solid box of the hull's size\"}}",
                     "{moments: [1 kg m^2, 1 kg m^2, 3 kg m^2]}");
  const std::string e = errors_of(t);
  EXPECT_EQ(
      e,
      "v.yaml:" + std::to_string(line_of(t, "  chassis:")) +
          ":3: inertia of body 'chassis' belongs to no body: principal moments 1, 1, 3 kg m^2 must be positive and the "
          "largest at most the sum of the others");
}

TEST(VehicleFiles, TwoParentsAreALoop) {
  const std::string t = test::replaced(rover(), "joints:\n",
                                       "joints:\n  extra: {type: revolute, parent: chassis, child: left_bogie, "
                                       "anchor: [0 m, 0 m, 0 m], axis: [0, 1, 0]}\n");
  const std::string e = errors_of(t);
  EXPECT_NE(e.find("body 'left_bogie' has two parents: joints 'extra' and 'left_bogie_pivot'"), std::string::npos) << e;
}

constexpr const char* urdf_extras =
    "motors:\n  drive: {stall_torque: 20 N m, no_load_speed: 12 rad/s, speed_gain: 4 N m s/rad}\n"
    "wheels:\n  wheel: {wheel: WHEEL, motor: drive}\n";
std::string extras() {
  return test::replaced(urdf_extras, "WHEEL", (test::examples / "wheels/robot_wheel.yaml").string());
}

constexpr const char* urdf =
    "<robot name=\"r\">\n"
    "  <link name=\"base\"><inertial><mass value=\"10\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial></link>\n"
    "  <link name=\"wheel\"><inertial><mass value=\"2\"/><inertia ixx=\"0.01\" iyy=\"0.01\" "
    "izz=\"0.01\"/></inertial></link>\n"
    "  <joint name=\"axle\" type=\"continuous\">\n"
    "    <parent link=\"base\"/><child link=\"wheel\"/>\n"
    "    <axis xyz=\"0 1 0\"/>\n"
    "  </joint>\n"
    "</robot>\n";

TEST(Urdf, SmallestRobotLoads) { EXPECT_EQ(errors_of(urdf, "r.urdf", extras()), ""); }

TEST(Urdf, UnknownParentIsNamedWithItsPlace) {
  EXPECT_EQ(errors_of(test::replaced(urdf, "parent link=\"base\"", "parent link=\"bse\""), "r.urdf", extras()),
            "r.urdf:5:5: unknown parent link 'bse'; did you mean 'base'? known: base, wheel");
}

TEST(Urdf, ALinkWithoutMassIsNamed) {
  EXPECT_EQ(errors_of(test::replaced(urdf, "mass value=\"2\"", "mass value=\"0\""), "r.urdf", extras()),
            "r.urdf:3:3: body 'wheel' has no mass: every body that is not fixed to another needs a positive mass and "
            "an inertia");
}

TEST(Urdf, ANumberThatIsNoneIsNamed) {
  EXPECT_EQ(errors_of(test::replaced(urdf, "mass value=\"10\"", "mass value=\"ten\""), "r.urdf", extras()),
            "r.urdf:2:31: attribute 'value' of <mass> must be a number alone, in SI units, of at most 1e12, got 'ten'");
}

TEST(Urdf, AMisspeltElementIsNamed) {
  EXPECT_EQ(errors_of(test::replaced(urdf, "<axis xyz=\"0 1 0\"/>", "<axes xyz=\"0 1 0\"/>"), "r.urdf", extras()),
            "r.urdf:6:5: unknown element in <joint> 'axes'; did you mean 'axis'? known: origin, parent, child, axis, "
            "calibration, "
            "dynamics, limit, mimic, safety_controller");
}

TEST(Urdf, RobotIsTheSameAsFromYaml) {
  InputLog log;
  const VehicleSpec a = load_vehicle(test::examples / "vehicles/skid_robot.yaml", {}, log);
  const ConfigDocument scenario =
      ConfigDocument::from_file(test::examples / "02_robot_rough_ground/robot_urdf_sinusoid.yaml");
  const VehicleSpec b = load_vehicle(test::examples / "vehicles/skid_robot.urdf", scenario.root(), log);
  ASSERT_NO_THROW(log.check());
  ASSERT_EQ(a.links.size(), b.links.size());
  for (std::size_t i = 0; i < a.links.size(); ++i) {
    EXPECT_NEAR(a.links[i].mass, b.links[i].mass, 1e-12);
    EXPECT_LT((a.links[i].X_VB.p - b.links[i].X_VB.p).norm(), 1e-12) << a.links[i].name;
    // The URDF file states 12 digits.
    EXPECT_LT((a.links[i].inertia - b.links[i].inertia).norm(), 1e-11) << a.links[i].name;
  }
}

TEST(Motor, GivesItsTorqueSpeedCurve) {
  MotorSpec m;
  m.speed = {0, 10, 12};
  m.torque = {20, 10, 0};
  EXPECT_DOUBLE_EQ(m.limit(5, 1), 15);  // half way down the first leg
  EXPECT_DOUBLE_EQ(m.limit(11, 1), 5);
  EXPECT_DOUBLE_EQ(m.limit(15, 1), 0);    // faster than no load: cannot drive
  EXPECT_DOUBLE_EQ(m.limit(15, -1), 20);  // but can brake
  EXPECT_DOUBLE_EQ(m.limit(-5, -1), 15);
}

TEST(Merge, TwoBallsMakeADumbbell) {
  // Solid balls, 2 m apart: about the long axis 2 * 2/5 m r^2, across it that plus m d^2/4 each.
  LinkSpec a, b;
  const double m = 3, r = 0.1, ball = 0.4 * m * r * r;
  a.mass = b.mass = m;
  a.inertia = b.inertia = Mat3::Identity() * ball;
  a.X_VB.p = Vec3(1, 0, 0);
  b.X_VB.p = Vec3(-1, 0, 0);
  b.X_VB.q = Quat(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()));
  merge_fixed(a, b);
  EXPECT_DOUBLE_EQ(a.mass, 2 * m);
  EXPECT_LT(a.X_VB.p.norm(), 1e-15);
  EXPECT_NEAR(a.inertia(0, 0), 2 * ball, 1e-12);
  EXPECT_NEAR(a.inertia(1, 1), 2 * ball + 2 * m, 1e-12);
  EXPECT_NEAR(a.inertia(2, 2), 2 * ball + 2 * m, 1e-12);
}

}  // namespace
}  // namespace grouser::vehicle
