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

TEST(LongRun, VehiclesBrakedOnATenDegreeSlopeOfSoilStayWithinAMillimetreForAMinuteWhateverTheirHeading) {
  // Greatest way from the first frame at any time, not only at the end.
  for (const char* vehicle : {"skid_robot.yaml", "offroad.yaml", "rover.yaml"})
    for (const char* yaw : {"0 deg", "45 deg", "90 deg"}) {
      const Folder f;
      const auto yaml = parked(f.path(), vehicle, yaw);
      run(yaml, f.path() / "out", "bekker.steady", 0);
      const RunFile r(f.path() / "out/run.h5");
      ASSERT_NEAR(r.time().back(), 60, 1e-9);
      EXPECT_LT(greatest_way(r.read("chassis.position")), 1e-3) << vehicle << ", " << yaw;
    }
}

}  // namespace
}  // namespace grouser::vehicle
