// A minute of driving and of standing still.
#include <cmath>

#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

TEST(LongRun, JointsDriftLessThanATenthOfAMillimetreInAMinuteOfClassE) {
  for (const char* scenario : {"robot_iso_e.yaml", "rover_rocks.yaml", "offroad_iso_e.yaml"}) {
    const Folder f;
    const RunSummary s = run(examples / "02_robot_rough_ground" / scenario, f.path() / "out", "bekker.steady", 60);
    EXPECT_LT(s.joint_drift_m, 1e-4) << scenario;
    EXPECT_LT(s.energy_residual_ratio, 0.005) << scenario;
  }
}

TEST(LongRun, ABrakedRobotOnATenDegreeSlopeOfSoilCreepsLessThanAMillimetreInAMinute) {
  const Folder f;
  run(examples / "02_robot_rough_ground/robot_slope_parked.yaml", f.path() / "out", "bekker.steady", 0);
  const RunFile r(f.path() / "out/run.h5");
  ASSERT_NEAR(r.time().back(), 60, 1e-9);
  const std::vector<double> p = r.read("chassis.position");
  const std::size_t n = p.size() - 3;
  EXPECT_LT(std::hypot(p[n] - p[0], p[n + 1] - p[1], p[n + 2] - p[2]), 1e-3);
}

}  // namespace
}  // namespace grouser::vehicle
