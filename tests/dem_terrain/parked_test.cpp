// A wheel at rest under its weight: with a constant rolling coefficient the soil holds it, with eq 3.20 it creeps, as that coefficient vanishes
// with the speed (dissertation eq 3.20: mu_r v_t^2).
#include <gtest/gtest.h>

#include <string>

#include "coarse.h"

namespace grouser::test {
namespace {

/// Height of the hub [m] each 0.5 s of a wheel of 5 kg that only falls, from clear of the soil, over 2 s. A damper to the world of 500 N s/m ends its bounces;
/// at 0.1 mm/s it carries a thousandth of the weight.
std::vector<double> rest(const std::string& soil) {
  auto t = coarse_terrain(flat_ground(), 1, kCoarseOptions, coarse_wheel(), soil);
  const double mass = 5, damper = 500, dt = 2e-4;
  double z = kRadius + 1e-3, v = 0;
  std::vector<double> out;
  for (int i = 0; i < 10000; ++i) {
    const BodyMotion m{{Vec3(0, 0, z), Quat::Identity()},
                       {Vec3(0, 0, z + v * dt), Quat::Identity()},
                       {Vec3(0, 0, v), Vec3::Zero()},
                       {}};
    z += v * dt;
    v = (v + step_one(*t, i * dt, dt, m).impulse.z() / mass - 9.81 * dt) / (1 + damper / mass * dt);
    if ((i + 1) % 2500 == 0) out.push_back(z);
  }
  return out;
}

TEST(Parked, ConstantRollingCoefficientHoldsAWheel) {
  const std::vector<double> z = rest(kCoarseSoil);
  EXPECT_LT(z[1], kRadius - 1e-4);  // in the soil
  EXPECT_NEAR(z[3], z[1], 1e-6);    // 1e-3 mm/s over a second
}

TEST(Parked, CoefficientByTheSquareOfSpeedLetsItCreep) {
  std::string soil = kCoarseSoil;
  const std::string law = "{law: constant, coefficient: 0.2}";
  soil.replace(soil.find(law), law.size(), "{law: rate, coefficient: 6.75e8 s^2/m^2}");
  const std::vector<double> z = rest(soil);
  EXPECT_LT(z[3], z[2] - 2e-5);  // 0.04 mm/s after two seconds
  EXPECT_LT(z[2], z[1] - 2e-5);
}

}  // namespace
}  // namespace grouser::test
