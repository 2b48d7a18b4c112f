// Left and right, north and east: a packing has neither mirror image nor turned copy, but means over packings may not tell them apart.
#include <gtest/gtest.h>

#include <cmath>

#include "dem_terrain/slab.h"

namespace grouser::test {
namespace {

struct Mean {
  double x = 0, error = 0;  ///< mean over packings and its standard error
};
Mean mean_of(const std::vector<double>& v) {
  Mean m;
  const auto n = static_cast<double>(v.size());
  for (double a : v) m.x += a / n;
  double s = 0;
  for (double a : v) s += (a - m.x) * (a - m.x);
  m.error = std::sqrt(s / (n - 1) / n);
  return m;
}

/// Drawbar pull, side force and normal force of a wheel 12 mm deep that rolls along `heading` at this slip angle; one per packing.
struct Forces {
  std::vector<double> pull, side, load;
};
Forces roll(double heading, double slip_angle) {
  Forces out;
  for (int seed = 1; seed <= 6; ++seed) {
    const auto t =
        coarse_terrain(flat_ground(), 1,
                       "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, period: [0.4 m, 0.4 m], seed: " +
                           std::to_string(seed) + "}");
    const double speed = 0.5, spin = speed * std::cos(slip_angle) / 0.7 / kRadius, depth = 0.012;
    const Vec3 v(speed * std::cos(heading + slip_angle), speed * std::sin(heading + slip_angle), 0);
    const auto pose = [&](double time) {
      // Lowered while it rolls, over 0.1 s.
      const double z = kRadius + 0.02 - (0.02 + depth) * std::min(1.0, time / 0.1);
      return Pose{Vec3(v.x() * time, v.y() * time, z), Quat(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                                                            Eigen::AngleAxisd(spin * time, Eigen::Vector3d::UnitY()))};
    };
    double pull = 0, side = 0, load = 0;
    for (int i = 0; i < 900; ++i) {
      const double a = 1e-3 * i, b = 1e-3 * (i + 1);
      BodyMotion m{pose(a), pose(b), {}, {}};
      m.V_WB_end.v = (m.X_WB_end.p - m.X_WB_begin.p) / 1e-3;
      m.V_WB_end.w = m.X_WB_end.q * Vec3(0, spin, 0);
      const BodyResult r = step_one(*t, a, 1e-3, m);
      if (i < 200) continue;
      pull += r.report.drawbar_pull / 700;
      side += r.report.side_force / 700;
      load += r.report.normal_force / 700;
    }
    out.pull.push_back(pull);
    out.side.push_back(side);
    out.load.push_back(load);
  }
  return out;
}

/// Equal within four standard errors: by chance once in thousands of cases; and these errors are small enough to say something.
void expect_equal(const std::vector<double>& a, const std::vector<double>& b, double scale) {
  const Mean x = mean_of(a), y = mean_of(b);
  const double error = std::hypot(x.error, y.error);
  EXPECT_NEAR(x.x, y.x, 4 * error);
  EXPECT_LT(error, 0.1 * scale);
}

TEST(SphereSymmetry, MirroredSlipAngleGivesTheMirroredSideForceOnAverage) {
  const Forces left = roll(0, 0.35), right = roll(0, -0.35);
  const double load = mean_of(left.load).x;
  std::vector<double> mirrored;
  for (double s : right.side) mirrored.push_back(-s);
  expect_equal(left.side, mirrored, load);
  expect_equal(left.pull, right.pull, load);
  expect_equal(left.load, right.load, load);
  // And it is there: the wheel drifts to its left, the soil pushes it to its right.
  EXPECT_LT(mean_of(left.side).x, -4 * mean_of(left.side).error);
}

TEST(SphereSymmetry, HeadingDoesNotMatterOnAverage) {
  const Forces ahead = roll(0, 0);
  const double load = mean_of(ahead.load).x;
  for (const double heading : {0.5 * pi, 0.8}) {
    const Forces turned = roll(heading, 0);
    expect_equal(ahead.pull, turned.pull, load);
    expect_equal(ahead.load, turned.load, load);
    expect_equal(ahead.side, turned.side, load);
  }
}

TEST(SphereSymmetry, ASlabPushesToNoSide) {
  Forces f;
  for (int seed = 1; seed <= 6; ++seed) {
    const auto t = slab(kSlab, seed);
    const Vec3 force = mean_force(roll_slab(*t, 0, 1200), 200);
    f.side.push_back(force.y());
    f.load.push_back(force.z());
  }
  const Mean side = mean_of(f.side);
  EXPECT_LT(std::abs(side.x), 3 * side.error);
  EXPECT_LT(std::abs(side.x), 0.1 * mean_of(f.load).x);
}

}  // namespace
}  // namespace grouser::test
