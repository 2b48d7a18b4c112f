// dem.sphere as a slab that is its own neighbour across: places, width, sides, state, threads, what it refuses.
#include "dem_terrain/slab.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/terrain/ground_slope.h"
#include "grouser/terrain/soil_points.h"

namespace grouser::test {
namespace {

TEST(Slab, ForcesDoNotDependOnWhereTheWindowIs) {
  const auto here = slab();
  const std::vector<BodyResult> a = roll_slab(*here, 0, 300);
  // A period on, and anywhere along the axle: a wheel without ends meets the same soil.
  for (const auto& [x, y] : {std::pair(1.0, 0.0), std::pair(0.0, 0.375), std::pair(-1.0, -0.04)}) {
    const auto there = slab();
    const std::vector<BodyResult> b = roll_slab(*there, 0, 300, x, y);
    for (std::size_t k = 0; k < 300; ++k) {
      ASSERT_EQ(a[k].impulse, b[k].impulse) << k << ": " << x << ", " << y;
      ASSERT_EQ(a[k].angular_impulse, b[k].angular_impulse) << k;
    }
  }
  EXPECT_GT(mean_force(a, 100).z(), 5);
}

TEST(Slab, ForcesAreThoseOfTheWheelsWidth) {
  const auto one = slab(0.04), two = slab(0.08), all = slab(kSlab), wider = slab(2 * kSlab);
  const auto a = roll_slab(*one, 0, 200), b = roll_slab(*two, 0, 200), c = roll_slab(*all, 0, 200),
             d = roll_slab(*wider, 0, 200);
  for (std::size_t k = 0; k < 200; ++k) {
    ASSERT_EQ(b[k].impulse, 2 * a[k].impulse) << k;
    ASSERT_EQ(d[k].impulse, 2 * c[k].impulse) << k;
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(a[k].impulse[axis] / 0.04, c[k].impulse[axis] / kSlab, 1e-12 * c[k].impulse.norm() / kSlab) << k;
    // Nothing turns it about another axis than its own.
    ASSERT_NEAR(a[k].angular_impulse.x(), 0, 1e-15);
    ASSERT_NEAR(a[k].angular_impulse.z(), 0, 1e-15);
  }
  EXPECT_NE(a.back().angular_impulse.y(), 0);
  EXPECT_NEAR(two->energy().dissipated, 2 * one->energy().dissipated, 1e-12);
}

TEST(Slab, WorkIsImpulseTimesWayAndMomentTimesAngle) {
  const auto t = slab();
  double before = 0, work = 0;
  for (int k = 0; k < 200; ++k) {
    const BodyResult r = roll_slab(*t, k, k + 1).front();
    const double turned = 0.25 / 0.8 / kRadius;
    work -= 0.25 * r.impulse.x() + turned * r.angular_impulse.y();
    ASSERT_NEAR(t->energy().dissipated - before, -(0.25 * r.impulse.x() + turned * r.angular_impulse.y()), 1e-8) << k;
    before = t->energy().dissipated;
  }
  EXPECT_GT(work, 0.01);
}

TEST(Slab, SoilMovesFromSideToSideWithoutASeam) {
  const auto t = slab();
  roll_slab(*t, 0, 1500);
  // The wheel stirs the track as much at the border between the slab and itself as in its middle; at a seam of frozen grains, one
  // diameter on either side as along x, nothing would move there.
  double border = 0, middle = 0;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 8; ++k) {
      const double stirred = std::abs(t->surface(0.08 + 0.003 * i, 0.016 * k).sinkage);  // 0 and 7 at the border
      (k < 1 || k > 6 ? border : middle) += stirred / (k < 1 || k > 6 ? 120 : 360);
    }
  EXPECT_GT(border, 0.001);
  EXPECT_GT(middle, 0.001);
  EXPECT_NEAR(border, middle, 0.5 * middle);
  // Places repeat across.
  for (double x : {0.05, 0.11, 0.2}) EXPECT_EQ(t->surface(x, 0.01).height, t->surface(x, 0.01 - 3 * kSlab).height);
  // What is shown lies about the hub and nowhere beyond the slab.
  for (const auto& g : dynamic_cast<const SoilPoints&>(*t).soil_points(100000)) EXPECT_LE(std::abs(g[1]), 0.5 * kSlab);
}

TEST(Slab, SavedAndLoadedAcrossATileContinuesBitByBitOnAnyThreads) {
  expect_same_bits_after_load_and_on_two_threads([] { return slab(); }, [](const Terrain&, const Terrain&) {});
}

TEST(Slab, NamesWhatItCannotCarry) {
  using testing::HasSubstr;
  const auto made = [](const std::string& options, int wheels = 1, const RunningGear& gear = coarse_wheel(),
                       GroundPtr ground = flat_ground()) {
    return error_of([&] { coarse_terrain(ground, wheels, options, gear); });
  };
  EXPECT_THAT(made("{slab: 100 mm}"), HasSubstr("must be 108 mm or more: 6 of the soil's largest grains"));
  EXPECT_THAT(made("{slab: 100 mm}"), HasSubstr("options.yaml:1:"));
  EXPECT_THAT(made("{slab: 125 mm, period: [0.5 m, 0.5 m]}"), HasSubstr("its second number is the width of the slab"));
  EXPECT_THAT(made("{slab: 125 mm, reach_across: 60 mm}"), HasSubstr("a slab moves as a whole across"));
  EXPECT_THAT(made(slab_options(), 2),
              HasSubstr("a slab carries one wheel, as wide as itself; 'wheel1' is the second"));
  EXPECT_THAT(made(slab_options(1, ", wheel: mesh")), HasSubstr("a slab carries a smooth cylinder only"));
  LuggedCylinder lugs;
  lugs.radius = kRadius;
  lugs.width = kWidth;
  EXPECT_THAT(made(slab_options(), 1, {"lugged", lugs}), HasSubstr("'lugged' has ends or lugs"));

  const auto moved = [](const Vec3& way, double yaw, GroundPtr ground = flat_ground()) {
    return error_of([&] {
      const auto t = coarse_terrain(std::move(ground), 1, slab_options());
      BodyMotion m;
      m.X_WB_begin = m.X_WB_end = Pose{Vec3(0, 0, kRadius), Quat(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))};
      m.X_WB_end.p += way;
      step_one(*t, 0, kStep, m);
    });
  };
  EXPECT_EQ(moved(Vec3(1e-3, 0, 0), 0), "no error");
  EXPECT_THAT(moved(Vec3(1e-3, 1e-4, 0), 0), HasSubstr("this one went 0.1 mm along its axle"));
  EXPECT_THAT(moved(Vec3(1e-3, 0, 0), 0.1), HasSubstr("turned by 5.73 degrees"));
  SlopeSettings aside;
  aside.angle = 0.1;
  aside.frame.heading = 0.5 * pi;
  EXPECT_THAT(moved(Vec3(1e-3, 0, 0), 0, slope_ground(aside)), HasSubstr("across the slab; a slab wants one profile"));
}

}  // namespace
}  // namespace grouser::test
