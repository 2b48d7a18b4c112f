// Robot and rover on grains: what the conformance suite asks of one wheel, of whole vehicles on coarse soft grains.
#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

/// Stands for `settle`, drives on flat grains.
struct Case {
  const char* vehicle;
  double gravity, speed;  ///< [m/s^2], [m/s]
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.vehicle; }

constexpr double kDuration = 0.6;  // [s]

std::string straight(double speed) {
  std::ostringstream s;
  s << "{type: speed_hold, speed: " << speed << " m/s, ramp: 0.2 s}";
  return s.str();
}
/// Wheels of one side stand.
std::string turning(const Case& c, bool left) {
  const double spin = c.speed / 0.1;
  std::ostringstream s;
  s << "{type: open_loop, table: [{time: 0 s, speed: 0 m/s}, {time: 0.2 s, left: " << (left ? 0 : spin)
    << " rad/s, right: " << (left ? spin : 0) << " rad/s}]}";
  return s.str();
}

/// 2 MPa: the worst of the contacts of a poured layer of 0.2 m overlaps by 1.5 mm; at 1 MPa by 2.3 to 2.6, and from a
/// quarter of the radius on, 2.5 mm, no run begins.
fs::path scenario(const Folder& f, const Case& c, int seed, double time_step, double yaw, const std::string& driver) {
  f.write("grains.yaml",
          "soil: coarse soft grains\nsource: none\ndem:\n  diameter: [20 mm, 25 mm]\n  density: 3.1 g/cm^3\n"
          "  bulk_density: 1.6 g/cm^3\n  young_modulus: 2 MPa\n  poisson_ratio: 0.35\n  friction: 0.6\n"
          "  rolling: {law: constant, coefficient: 0.2}\n  restitution: 0.4\n"
          "  wall: {friction: 0.6, restitution: 0.4}\n");
  std::ostringstream s;
  s << "scenario: " << c.vehicle << " on grains\nvehicle: " << (examples / "vehicles" / c.vehicle).string() << ".yaml\n"
    << "time_step: " << time_step << " s\nduration: " << kDuration << " s\ngravity: " << c.gravity << " m/s^2\n"
    << "output: {rate: 50 Hz, checkpoint_every: 0.2 s}\n"
    << "terrain: {model: dem.sphere, soil: grains.yaml, options: {dem.sphere: {depth: 60 mm, relief: 50 mm, "
    << "brick: 100 mm, reach: 50 mm, datum: 0 m, seed: " << seed << "}}}\n"
    << "ground: [{shape: flat}]\nstart: {settle: 0.3 s, yaw: " << yaw << " rad}\n"
    << "driver: " << driver << "\n";
  return f.write("scenario.yaml", s.str());
}

/// Means over the second half of a run.
struct Drive {
  double load = 0, ahead = 0, aside = 0;  ///< of all wheels [N]; way along and across the heading at the start [m]
  double turn = 0;                        ///< of the heading [rad]
};
Drive drive(const Case& c, int seed, const std::string& driver, double time_step = 1e-3, double yaw = 0) {
  const Folder f;
  run(scenario(f, c, seed, time_step, yaw, driver), f.path() / "out", "dem.sphere", 0);
  const RunFile r(f.path() / "out/run.h5");
  Drive d;
  for (const ChannelSpec& s : r.channels()) {
    if (!s.name.ends_with(".normal_force")) continue;
    const std::vector<double> n = r.read(s.name);
    for (std::size_t i = n.size() / 2; i < n.size(); ++i) d.load += n[i] / static_cast<double>(n.size() - n.size() / 2);
  }
  const std::vector<double> p = r.read("chassis.position");
  const double x = p[p.size() - 3] - p[0], y = p[p.size() - 2] - p[1];
  d.ahead = x * std::cos(yaw) + y * std::sin(yaw);
  d.aside = y * std::cos(yaw) - x * std::sin(yaw);
  d.turn = r.read("vehicle.yaw").back() - yaw;
  return d;
}

struct Spread {
  double mean = 0, error = 0;  ///< over packings, and its standard error
};
Spread over(const std::vector<Drive>& all, double Drive::*of) {
  Spread s;
  const auto n = static_cast<double>(all.size());
  for (const Drive& d : all) s.mean += d.*of / n;
  for (const Drive& d : all) s.error += (d.*of - s.mean) * (d.*of - s.mean) / (n - 1) / n;
  s.error = std::sqrt(s.error);
  return s;
}

class OnGrains : public testing::TestWithParam<Case> {
 protected:
  static constexpr int kPackings = 8;
  static std::vector<Drive> packings(const std::string& driver, double time_step, double yaw) {
    std::vector<Drive> out;
    for (int seed = 1; seed <= kPackings; ++seed) out.push_back(drive(GetParam(), seed, driver, time_step, yaw));
    return out;
  }
  static std::vector<Drive> packings(double time_step, double yaw) {
    return packings(straight(GetParam().speed), time_step, yaw);
  }
  /// Student's t that 1 of 1,000 means of so many packings, and differences of two of them, exceed.
  static constexpr double kOne = 5.41, kTwo = 4.14;
  /// Equal within kTwo standard errors and what is asked besides.
  static void expect_equal(const std::vector<Drive>& a, const std::vector<Drive>& b, double load, double way) {
    for (const auto& [of, bar] : {std::pair{&Drive::load, load}, std::pair{&Drive::ahead, way}}) {
      const Spread x = over(a, of), y = over(b, of);
      const double error = std::hypot(x.error, y.error);
      EXPECT_NEAR(x.mean, y.mean, kTwo * error);
      EXPECT_LT(error, bar) << "packings differ so much that this says nothing";
    }
  }
};

TEST_P(OnGrains, ThreadsAndAResumeGiveTheSameBits) {
  const Folder f;
  const fs::path file = scenario(f, GetParam(), 1, 1e-3, 0, straight(GetParam().speed));
  const std::string whole = run(file, f.path() / "whole", "dem.sphere", 0).end_state_hash;
  EXPECT_EQ(run(file, f.path() / "two", "dem.sphere", 0, 2).end_state_hash, whole);
  // Stopped on the way, after the checkpoint at 0.2 s.
  struct Stop {};
  RunOptions o;
  o.out = f.path() / "stopped";
  o.progress = [&](const Progress& p) {
    if (p.time > 0.25) throw Stop();
  };
  EXPECT_THROW(run_scenario(file, all_models(), o), Stop);
  const RunSummary resumed = resume_run(f.path() / "stopped", all_models(), 1);
  EXPECT_LT(resumed.simulated_s, 0.7 * kDuration) << "begun again instead of continued";
  EXPECT_EQ(resumed.end_state_hash, whole);
}

TEST_P(OnGrains, MeansDoNotDependOnTheHostsStepNorOnTheHeadingAndNoSideIsPreferred) {
  const std::vector<Drive> base = packings(1e-3, 0), fine = packings(0.5e-3, 0), turned = packings(1e-3, 0.5 * pi);
  const double load = over(base, &Drive::load).mean, way = over(base, &Drive::ahead).mean;
  EXPECT_GT(way, 0.02);
  expect_equal(base, fine, 0.1 * load, 0.1 * way);
  expect_equal(base, turned, 0.1 * load, 0.1 * way);
  for (const auto& all : {base, fine, turned}) {
    const Spread aside = over(all, &Drive::aside);
    EXPECT_LT(std::abs(aside.mean), kOne * aside.error);
    EXPECT_LT(std::abs(aside.mean), 0.1 * way);
  }
}

TEST_P(OnGrains, LeftTurnsMirrorRightTurns) {
  std::vector<Drive> left = packings(turning(GetParam(), true), 1e-3, 0),
                     right = packings(turning(GetParam(), false), 1e-3, 0);
  for (Drive& d : right) {
    d.aside = -d.aside;
    d.turn = -d.turn;
  }
  const double load = over(left, &Drive::load).mean, way = over(left, &Drive::ahead).mean;
  expect_equal(left, right, 0.1 * load, 0.2 * way);
  const Spread a = over(left, &Drive::turn), b = over(right, &Drive::turn);
  EXPECT_GT(a.mean, kOne * a.error) << "does not turn";
  EXPECT_NEAR(a.mean, b.mean, kTwo * std::hypot(a.error, b.error));
  EXPECT_LT(std::hypot(a.error, b.error), 0.2 * a.mean) << "packings differ so much that this says nothing";
}

std::string name_of(const testing::TestParamInfo<Case>& i) { return i.param.vehicle; }
constexpr Case kRobot{"skid_robot", 9.81, 0.3}, kRover{"rover", 3.71, 0.15};
INSTANTIATE_TEST_SUITE_P(Vehicles, OnGrains, testing::Values(kRobot, kRover), name_of);

}  // namespace
}  // namespace grouser::vehicle
