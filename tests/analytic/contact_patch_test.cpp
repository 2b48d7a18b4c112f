#include "grouser/terrain/contact_patch.h"

#include <gtest/gtest.h>

#include "helpers.h"

namespace grouser {
namespace {

using test::ground_of;

WheelPose pose(const Vec3& hub, double yaw = 0, double camber = 0, double r = 0.13, double b = 0.16) {
  const Quat q = Quat(Eigen::AngleAxisd(yaw, Vec3::UnitZ())) * Quat(Eigen::AngleAxisd(camber, Vec3::UnitX()));
  return {hub, q * Vec3::UnitY(), r, b};
}

TEST(ContactPatch, SegmentAngleInvertsTheSegmentArea) {
  for (double a : {1e-5, 1e-3, 0.05, 0.0999, 0.1001, 0.4, 1.0, 1.57, 2.0, 3.0}) {
    const double q =
        a < 0.02 ? a * a * a * (2.0 / 3 - a * a * (2.0 / 15 - a * a * 4.0 / 315)) : a - 0.5 * std::sin(2 * a);
    EXPECT_NEAR(segment_angle(q), a, 1e-12 * a) << a;
  }
  EXPECT_EQ(segment_angle(0), 0);
}

TEST(ContactPatch, FlatGroundGivesTheExactSinkageAtAnyYawAndPosition) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> u(0, 1);
  const GroundPtr ground = flat_ground(0.25);
  PatchFinder finder;
  for (int i = 0; i < 200; ++i) {
    const double h = 0.12 * std::pow(u(rng), 3) + 1e-7;
    const ContactPatch p = finder.find(pose({50 * u(rng), -30 * u(rng), 0.25 + 0.13 - h}, 6 * u(rng)), *ground);
    ASSERT_TRUE(p.contact);
    EXPECT_NEAR(p.sinkage, h, 1e-10);
    EXPECT_NEAR((p.normal_W - Vec3::UnitZ()).norm(), 0, 1e-9);
    EXPECT_NEAR(p.length_ratio, 1, 1e-9);
    EXPECT_NEAR(p.g.tail<3>().norm(), 0, 1e-9);
  }
}

TEST(ContactPatch, FinelySampledPlaneIsAsExactAsACoarseOne) {
  // resolution 1 mm forces 5.4 mm samples: every segment is cut at the circle
  const GroundPtr ground = ground_of([](double, double) { return 0.0; }, 1e-3);
  PatchFinder finder;
  for (double h : {1e-6, 1e-4, 0.003, 0.03}) {
    const ContactPatch p = finder.find(pose({0.377, 0, 0.13 - h}), *ground);
    EXPECT_NEAR(p.sinkage, h, 1e-10);
  }
}

TEST(ContactPatch, TiltedPlaneGivesItsNormalAndItsPerpendicularSinkage) {
  // grade along and side slope; wheel upright in the plane's own axes, so the sinkage is r - distance(hub, plane)
  const Quat tilt = Quat(Eigen::AngleAxisd(0.2, Vec3::UnitX())) * Quat(Eigen::AngleAxisd(-0.15, Vec3::UnitY()));
  const Vec3 n = tilt * Vec3::UnitZ();
  const GroundPtr ground = ground_of([n](double x, double y) { return -(n.x() * x + n.y() * y) / n.z(); });
  PatchFinder finder;
  WheelPose w;
  w.hub_W = n * (0.13 - 0.008);
  w.axis_W = tilt * Vec3::UnitY();
  w.radius = 0.13;
  w.width = 0.16;
  const ContactPatch p = finder.find(w, *ground);
  ASSERT_TRUE(p.contact);
  EXPECT_NEAR(p.sinkage, 0.008, 1e-10);
  EXPECT_NEAR((p.normal_W - n).norm(), 0, 1e-9);
  EXPECT_NEAR(p.length_ratio, 1, 1e-9);
  EXPECT_NEAR(p.arm_W.norm(), 0, 1e-9);
}

TEST(ContactPatch, ClearWheelHasNoPatch) {
  PatchFinder finder;
  EXPECT_FALSE(finder.find(pose({0, 0, 0.1300001}), *flat_ground()).contact);
}

TEST(ContactPatch, WallCutsTheCircularSegmentBeyondIt) {
  // ground far below, a wall taller than the wheel at x = d: overlap = circular segment of half angle acos(d/r).
  const double r = 0.13;
  for (double d : {0.06, 0.1, 0.125}) {
    const GroundPtr ground = ground_of([d](double x, double) { return x < d ? -1.0 : 1.0; }, 1e-4);
    PatchFinder finder({1, 400});
    const ContactPatch p = finder.find(pose({0, 0, 0}), *ground);
    const double a = std::acos(d / r), exact = r * r * (a - std::sin(a) * std::cos(a));
    // the step is smeared over one sample spacing, r/400: area off by less than spacing times chord
    EXPECT_NEAR(p.area, exact, r / 400 * 2 * r * std::sin(a)) << d;
    EXPECT_LT(p.normal_W.x(), -0.99);
  }
}

TEST(ContactPatch, CircleOverASymmetricRoofHasTheAnalyticArea) {
  // roof z = h - m |x| under the hub: area = 2 * integral of (h - m x + sqrt(r^2 - x^2)) from 0 to the edge, in closed form
  const double r = 0.13, m = 0.5, z = -0.12;  // apex relative to the hub
  const GroundPtr ground = ground_of([=](double x, double) { return z - m * std::abs(x); }, 1e-4);
  // edge: x^2 + (z - m x)^2 = r^2
  const double A = 1 + m * m, B = -2 * m * z, C = z * z - r * r;
  const double e = (-B + std::sqrt(B * B - 4 * A * C)) / (2 * A);
  const double arc = 0.5 * (e * std::sqrt(r * r - e * e) + r * r * std::asin(e / r));
  PatchFinder finder({1, 130});  // spacing 1 mm: the apex is a sample
  const ContactPatch p = finder.find(pose({0, 0, 0}), *ground);
  EXPECT_NEAR(p.area, 2 * (z * e - m * e * e / 2 + arc), 1e-12);
}

TEST(ContactPatch, SinkageRateIsMinusTheGeneralisedNormalTimesTheTwist) {
  // (P3) by central differences, on a plane with grade and side slope, camber included, for all six motions of the hub
  const GroundPtr ground = ground_of([](double x, double y) { return 0.11 * x - 0.07 * y; });
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> u(-1, 1);
  PatchFinder finder;
  for (int i = 0; i < 50; ++i) {
    const WheelPose w = pose({u(rng), u(rng), 0}, 3 * u(rng), 0.05 * u(rng));
    WheelPose at = w;
    at.hub_W.z() = ground->height(w.hub_W.x(), w.hub_W.y()) + 0.117;
    const ContactPatch p = finder.find(at, *ground);
    ASSERT_TRUE(p.contact);
    Twist V{{u(rng), u(rng), u(rng)}, {u(rng), u(rng), u(rng)}};
    const double d = 1e-6;
    const auto sinkage = [&](double s) {
      WheelPose moved = at;
      moved.hub_W += s * V.v;
      moved.axis_W = Quat(Eigen::AngleAxisd(s * V.w.norm(), V.w.normalized())) * at.axis_W;
      return finder.find(moved, *ground).sinkage;
    };
    Vec6 V6;
    V6 << V.v, V.w;
    EXPECT_NEAR((sinkage(d) - sinkage(-d)) / (2 * d), -p.g.dot(V6), 1e-6);
  }
}

// The sinkage at two places a micrometre apart against g: ground whose slope differs from strip to strip, upright and rolled wheels. Allowed:
// 1e-4 of a unit slope, what is left of the difference over the strip's own kinks; one slope for all strips was up to 0.1 off.
TEST(ContactPatch, SinkageRateHoldsWhereTheGroundVariesAcrossTheWheel) {
  const GroundPtr ground = ground_of(
      [](double x, double y) { return 0.02 * std::sin(2 * pi * y / 0.4) + 0.004 * std::sin(31 * x + 11 * y); }, 2e-3);
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(0, 1);
  PatchFinder finder;
  int seen = 0;
  for (int i = 0; i < 200; ++i) {
    Vec3 hub(u(rng), u(rng), 0);
    hub.z() = ground->height(hub.x(), hub.y()) + 0.13 - 0.004 - 0.012 * u(rng);
    const double yaw = 0.3 * u(rng);
    const ContactPatch p = finder.find(pose(hub, yaw), *ground);
    if (!p.contact) continue;
    ++seen;
    const double d = 1e-6;
    for (const Vec3& way : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
      const double ahead = finder.find(pose(hub + d * way, yaw), *ground).sinkage;
      const double behind = finder.find(pose(hub - d * way, yaw), *ground).sinkage;
      EXPECT_NEAR((ahead - behind) / (2 * d), -p.g.head<3>().dot(way), 1e-4) << "pose " << i << " along " << way.transpose();
    }
  }
  EXPECT_GT(seen, 150);
}

TEST(ContactPatch, ForceFromThePotentialDoesNoNetWorkAroundAClosedLoopOnRoughGround) {
  const GroundPtr ground = ground_of(
      [](double x, double) {
        return 0.012 * std::sin(31 * x) + 0.006 * std::sin(83 * x + 1) + 0.002 * std::sin(190 * x);
      },
      1e-3);
  PatchFinder finder;
  const double k = 2e5;
  double work = 0, gross = 0;
  const int n = 20000;
  Vec3 f_old = Vec3::Zero(), p_old = Vec3::Zero();
  for (int i = 0; i <= n; ++i) {
    const double a = 2 * pi * i / n;
    const Vec3 hub(0.5 + 0.15 * std::cos(a), 0, 0.126 + 0.01 * std::sin(2 * a));
    const ContactPatch p = finder.find(pose(hub), *ground);
    const Vec3 f = p.contact ? Vec3(k * p.sinkage * p.g.head<3>()) : Vec3(Vec3::Zero());
    if (i > 0) {
      work += 0.5 * (f + f_old).dot(hub - p_old);
      gross += std::abs(0.5 * (f + f_old).dot(hub - p_old));
    }
    f_old = f;
    p_old = hub;
  }
  // trapezoid over 20000 points: its own error is of the order of 1e-6 of the gross work
  EXPECT_GT(gross, 1);
  EXPECT_LT(std::abs(work), 1e-5 * gross);
}

TEST(ContactPatch, ForceIsContinuousWhenTheWheelRollsOverAnEdge) {
  const GroundPtr ground = ground_of([](double x, double) { return x < 0.013 ? 0.0 : 0.03; }, 1e-3);
  PatchFinder finder;
  double last = -1, jump = 0;
  for (int i = 0; i < 4000; ++i) {
    const ContactPatch p = finder.find(pose({-0.1 + 5e-5 * i, 0, 0.125}), *ground);
    if (last >= 0) jump = std::max(jump, std::abs(p.sinkage - last));
    last = p.sinkage;
  }
  EXPECT_LT(jump, 6e-5);  // no more than about the travel itself
}

TEST(ContactPatch, DiscThatTouchesChangesTheForceWithAFiniteSlope) {
  // 10 degrees across: the discs touch one after another. Over 1 um of depth length_ratio may change by 1 um times the steepest slope,
  // 300/m, not with the root of the depth of the disc that touches (3e-3 at once).
  const GroundPtr ground = ground_of([](double, double y) { return std::tan(10 * pi / 180) * y; });
  PatchFinder finder;
  double last = -1, jump = 0;
  for (int i = 0; i < 14000; ++i) {
    const ContactPatch p = finder.find(pose({0, 0, 0.133 - 1e-6 * i}), *ground);
    if (last >= 0) jump = std::max(jump, std::abs(p.length_ratio - last));
    last = p.length_ratio;
  }
  EXPECT_GT(last, 0.8);
  EXPECT_LT(jump, 3e-4);
}

TEST(ContactPatch, DoublingSamplesAndStripsChangesTheSinkageLittleOnRoughGround) {
  // a 390 mm sinusoid of 10 mm: the default spacing against one four times finer, strips 3 against 7
  const GroundPtr ground =
      ground_of([](double x, double y) { return 0.01 * std::sin(16.1 * x) + 0.004 * std::sin(9 * y); }, 1e-3);
  PatchFinder coarse, fine({7, 96});
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    const double x = 0.01 * i, y = 0.003 * i;
    const WheelPose w = pose({x, y, ground->height(x, y) + 0.122});
    worst = std::max(worst, std::abs(coarse.find(w, *ground).sinkage - fine.find(w, *ground).sinkage));
  }
  RecordProperty("worst_mm", std::to_string(1e3 * worst));
  EXPECT_LT(worst, 2e-4);
}

}  // namespace
}  // namespace grouser
