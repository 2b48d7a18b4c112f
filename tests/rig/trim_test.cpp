#include "grouser/vehicle/trim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "grouser/terrain/rigid.h"

using namespace grouser;
using namespace grouser::vehicle;

namespace {

class FunctionGround final : public Ground {
 public:
  explicit FunctionGround(std::function<double(double, double)> f) : f_(std::move(f)) {}
  double height(double x, double y) const override { return f_(x, y); }
  double resolution() const override { return 0.02; }
  std::string describe() const override { return "test"; }

 private:
  std::function<double(double, double)> f_;
};

constexpr double k = 2e5, radius = 0.1;

std::unique_ptr<Terrain> hard(GroundPtr ground, int wheels) {
  Soil soil;
  soil.rigid = RigidSoil{k, 1e3, 0.8, 0, 0};
  auto t = rigid_model().make({soil, std::move(ground), ConfigNode(), 9.81});
  for (int i = 0; i < wheels; ++i)
    t->add_body({"wheel" + std::to_string(i), {"w", SmoothCylinder{radius, 0.05}}, Pose()});
  return t;
}

TEST(Trim, EquilibriumOfAKnownSystem) {
  // x^2 + y^2 = 4, x y = 1: the root near (1.93, 0.52) is x = sqrt(2 + sqrt 3).
  const Residual r = [](std::span<const double> x, std::span<double> f) {
    f[0] = x[0] * x[0] + x[1] * x[1] - 4;
    f[1] = x[0] * x[1] - 1;
  };
  const auto e = solve_equilibrium(r, {2, 1}, {{1, 1}, {4, 1}, 1e-12, 50});
  ASSERT_TRUE(e.ok) << e.why;
  EXPECT_NEAR(e.x[0], std::sqrt(2 + std::sqrt(3.0)), 1e-10);
}

TEST(Trim, SearchWithoutARootSaysSo) {
  const Residual r = [](std::span<const double> x, std::span<double> f) { f[0] = 1 + x[0] * x[0]; };
  const auto e = solve_equilibrium(r, {1}, {{1}, {1}, 1e-9, 50});
  EXPECT_FALSE(e.ok);
  EXPECT_NE(e.why.find("largest scaled residual"), std::string::npos) << e.why;
}

TEST(Trim, WheelSinksUntilTheSpringCarriesIt) {
  const auto t = hard(flat_ground(0.25), 1);
  // Spring k over the load: exact to the solver's tolerance (1e-10 of the load).
  EXPECT_NEAR(trim_wheel(*t, 0, {}, 120), 0.25 + radius - 120 / k, 1e-12);
}

TEST(Trim, StartInTheAirOrDeepInTheGroundMakesNoDifference) {
  const auto t = hard(flat_ground(), 1);
  Pose high, low;
  high.p.z() = 3;
  low.p.z() = -0.5;
  EXPECT_NEAR(trim_wheel(*t, 0, high, 50), trim_wheel(*t, 0, low, 50), 1e-12);
}

TEST(Trim, TrimmingAdvancesNothing) {
  const auto t = hard(flat_ground(), 1);
  State before, after;
  t->traverse(before);
  trim_wheel(*t, 0, {}, 120);
  t->traverse(after);
  EXPECT_EQ(before.hash(), after.hash());
}

TEST(Trim, LoadThatTheGroundCannotCarryIsNamed) {
  const auto t = hard(flat_ground(), 1);
  try {
    trim_wheel(*t, 0, {}, 1e9);
    FAIL();
  } catch (const TrimError& e) {
    EXPECT_NE(std::string(e.what()).find("trim of wheel 'wheel0': the terrain carries only"), std::string::npos)
        << e.what();
  }
  EXPECT_THROW(trim_wheel(*t, 0, {}, 0), TrimError);
  EXPECT_THROW(trim_wheel(*t, 1, {}, 10), TrimError);
}

const std::vector<Pose> corners{{{0.3, 0.2, 0}, Quat::Identity()},
                                {{0.3, -0.2, 0}, Quat::Identity()},
                                {{-0.3, 0.2, 0}, Quat::Identity()},
                                {{-0.3, -0.2, 0}, Quat::Identity()}};

// Four equal springs at (+-a, +-b) under a load off centre: f = W/4 (1 + dx x/a^2 + dy y/b^2).
TEST(Trim, WheelLoadsOfAnOffCentreVehicle) {
  const auto t = hard(flat_ground(), 4);
  const Vec3 cog(0.06, -0.03, 0.1);
  const auto r = trim_vehicle(*t, corners, 30, cog, 9.81, {});
  ASSERT_TRUE(r.ok) << r.why;
  const double W = 30 * 9.81;
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& p = corners[i].p;
    const double f = W / 4 * (1 + cog.x() * p.x() / 0.09 + cog.y() * p.y() / 0.04);
    // Tilt of 0.3 mm over 0.6 m moves the centre of gravity (0.1 m high) by 0.1 mm: 1e-3 of the lever.
    EXPECT_NEAR(r.wheels[i].f.z(), f, 2e-3 * W);
    sum += r.wheels[i].f.z();
  }
  EXPECT_NEAR(sum, W, 1e-8 * W);
  EXPECT_GT(r.pitch, 0) << "load ahead of the centre: nose down";
  EXPECT_GT(r.roll, 0) << "load right of the centre: left side up";
}

// One wheel 20 mm higher on hard ground (spring deflection 0.4 mm): the vehicle rocks onto three wheels or two and a corner.
TEST(Trim, VehicleOnUnevenHardGroundFindsItsWheels) {
  const auto t =
      hard(std::make_shared<FunctionGround>([](double x, double y) { return x > 0 && y > 0 ? 0.02 : 0.0; }), 4);
  const auto r = trim_vehicle(*t, corners, 30, {0.06, -0.03, 0.05}, 9.81, {});
  ASSERT_TRUE(r.ok) << r.why;
  double sum = 0;
  int carrying = 0;
  for (const Wrench& w : r.wheels) sum += w.f.z(), carrying += w.f.z() > 1e-6;
  EXPECT_NEAR(sum, 30 * 9.81, 1e-6);
  EXPECT_EQ(carrying, 3);
}

TEST(Trim, VehicleOnASlopeTakesItsAngle) {
  const auto t = hard(std::make_shared<FunctionGround>([](double x, double) { return 0.1 * x; }), 4);
  const auto r = trim_vehicle(*t, corners, 30, {0, 0, 0}, 9.81, {});
  ASSERT_TRUE(r.ok) << r.why;
  EXPECT_NEAR(r.pitch, -std::atan(0.1), 2e-3);
  EXPECT_NEAR(r.roll, 0, 1e-9);
}

TEST(Trim, VehicleThatTipsOverSaysSo) {
  const auto t = hard(flat_ground(), 4);
  const auto r = trim_vehicle(*t, corners, 30, {0.5, 0, 0}, 9.81, {});
  EXPECT_FALSE(r.ok);
  EXPECT_NE(r.why.find("centre of gravity"), std::string::npos) << r.why;
}

}  // namespace
