// The extended model in the full vehicle (examples/08_extended_robot): what the single-wheel law says beforehand is what the robot does.
#include <cstdio>

#include "grouser/bekker/effect_wheel.h"
#include "scenarios/support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

constexpr double kGravity = 9.81, kMass = 30, kWheelbase = 0.45;
constexpr double kHeight = (22 * 0.16 + 8 * 0.11) / 30;  // of the centre of mass
const std::vector<std::string> kWheels{"front_left", "front_right", "rear_left", "rear_right"};

/// Mean over the last `seconds` and over all wheels, or those whose name begins with `which`.
double mean(const RunFile& f, const std::string& channel, double seconds, const std::string& which = "") {
  const std::vector<double> t = f.time();
  double sum = 0, n = 0;
  for (const std::string& w : kWheels) {
    if (!w.starts_with(which)) continue;
    const std::vector<double> x = f.read(w + "." + channel);
    for (std::size_t i = 0; i < t.size(); ++i)
      if (t[i] > t.back() - seconds) sum += x[i], ++n;
  }
  return sum / n;
}

struct Foretold {
  double pull;         ///< of four wheels [N]
  double front, rear;  ///< sinkage [m]
};

/// Four wheels at one slip on a slope. The soil acts on each as a force through the hub and the moment that the motor gives, so the load
/// moves to the rear by (weight along the slope (height - r) + torques)/wheelbase. Quasi-static, code of the diagnosis.
Foretold foretold(double n1, double slope, double slip) {
  constexpr double radius = 0.11;
  const double weight = kGravity * kMass, along = weight * std::sin(slope);
  const double mean_load = weight * std::cos(slope) / 4;
  const bekker::EffectWheel wheel{radius, 0.09, 0.165, {}};
  Foretold out{0, 0, 0};
  double torques = along * radius;
  for (int i = 0; i < 4; ++i) {  // the torques depend on the loads
    const double shift = (along * (kHeight - radius) + torques) / kWheelbase / 2;
    out = {0, 0, 0};
    torques = 0;
    for (const bool front : {true, false}) {
      bekker::WheelState<double> q{444945,
                                   0.856007,
                                   0,
                                   0.431388,
                                   3.67812e-3,
                                   0.321403,
                                   0.384892,
                                   slip,
                                   front ? mean_load - shift : mean_load + shift,
                                   bekker::no_effects(),
                                   0};
      q.effect[0] = n1;
      q.active = n1 != 0 ? 1 : 0;
      double theta = 0;
      bekker::WheelAnswer<double> a{};
      EXPECT_EQ(bekker::effect_equilibrium(wheel, {0.15, 1, 0}, q, 0, theta, a), bekker::ForceStatus::ok);
      out.pull += 2 * a.drawbar;
      torques += 2 * a.torque;
      (front ? out.front : out.rear) = a.sinkage;
    }
  }
  return out;
}

/// Least slip at which the robot climbs; 1 when there is none.
double climbing_slip(double n1, double slope) {
  const double need = kGravity * kMass * std::sin(slope);
  for (double s = 0; s < 0.9; s += 1e-3)
    if (foretold(n1, slope, s).pull >= need) return s;
  return 1;
}

struct Drive {
  double slip, front, rear, speed;
};
Drive drive(const std::string& name, const Folder& f, double seconds) {
  run(examples / "08_extended_robot" / (name + ".yaml"), f.path() / name, "bekker.steady", 0);
  const RunFile file(f.path() / name / "run.h5");
  const std::vector<double> t = file.time(), v = file.read("vehicle.speed");
  Drive d{mean(file, "slip", seconds), mean(file, "sinkage", seconds, "front"), mean(file, "sinkage", seconds, "rear"),
          0};
  double n = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] > t.back() - seconds) d.speed += v[i], ++n;
  d.speed /= n;
  std::printf("%-16s slip %.3f, sinkage front %.2f mm, rear %.2f mm, speed %.3f m/s\n", name.c_str(), d.slip,
              1e3 * d.front, 1e3 * d.rear, d.speed);
  return d;
}

constexpr double kFound = 0.847;  // slip_sinkage_exponent

// The forecast leaves out the pitch of the robot and the way to the steady state: 0.005 of slip, 2 % of sinkage.
TEST(ExtendedRobot, ClimbsWithMoreSlipAndDeeperAsTheSingleWheelForetells) {
  const Folder f;
  const double slope = 7.8 * pi / 180;
  const Drive nominal = drive("climb_nominal", f, 4), extended = drive("climb_extended", f, 4);
  EXPECT_GT(extended.slip, nominal.slip + 0.01);
  EXPECT_GT(extended.front, 1.2 * nominal.front);
  EXPECT_GT(extended.rear, 1.2 * nominal.rear);
  for (const auto& [n1, seen] : {std::pair{0.0, nominal}, std::pair{kFound, extended}}) {
    const double slip = climbing_slip(n1, slope);
    const Foretold at = foretold(n1, slope, slip);
    std::printf("foretold: slip %.3f, sinkage front %.2f mm, rear %.2f mm\n", slip, 1e3 * at.front, 1e3 * at.rear);
    EXPECT_NEAR(seen.slip, slip, 0.005) << n1;
    EXPECT_NEAR(seen.front, at.front, 0.02 * at.front) << n1;
    EXPECT_NEAR(seen.rear, at.rear, 0.02 * at.rear) << n1;
  }
}

TEST(ExtendedRobot, StopsWhereTheSingleWheelSaysThatNoSlipPullsEnough) {
  const Folder f;
  const double slope = 9 * pi / 180;
  ASSERT_LT(climbing_slip(0, slope), 0.5);
  ASSERT_EQ(climbing_slip(kFound, slope), 1);
  const Drive nominal = drive("steep_nominal", f, 1), extended = drive("steep_extended", f, 1);
  EXPECT_NEAR(nominal.slip, climbing_slip(0, slope), 0.005);
  EXPECT_LT(extended.speed, 0.2 * nominal.speed);
  EXPECT_GT(extended.slip, 0.8);
}

TEST(ExtendedRobot, DigsDeeperRutsPassByPass) {
  double depth[2][3];
  const char* names[2] = {"passes_nominal", "passes_extended"};
  for (int k = 0; k < 2; ++k) {
    const Folder f;
    run(examples / "08_extended_robot" / (std::string(names[k]) + ".yaml"), f.path() / "out", "bekker.soil_node", 0);
    const RunFile file(f.path() / "out/run.h5");
    // Depth of the rear left wheel below the undisturbed slope where its hub passes x = 0.1 m: up, down, up.
    const std::vector<double> p = file.read("rear_left.position");
    const double slope = 5 * pi / 180, radius = 0.11;
    int pass = 0;
    for (std::size_t i = 1; 3 * i < p.size() && pass < 3; ++i) {
      if ((p[3 * i] - 0.1) * (p[3 * i - 3] - 0.1) >= 0) continue;
      depth[k][pass++] = radius - (p[3 * i + 2] - std::tan(slope) * (p[3 * i] + 5)) * std::cos(slope);
    }
    ASSERT_EQ(pass, 3) << names[k];
    std::printf("%-16s rear wheel below the undisturbed ground in passes 2, 3, 6: %.2f, %.2f, %.2f mm\n", names[k],
                1e3 * depth[k][0], 1e3 * depth[k][1], 1e3 * depth[k][2]);
  }
  for (int pass = 0; pass < 3; ++pass) EXPECT_GT(depth[1][pass], depth[0][pass] + 5e-4) << pass;  // half a millimetre
}

}  // namespace
}  // namespace grouser::vehicle
