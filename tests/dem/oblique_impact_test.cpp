// A sphere thrown at a plate: the measured rebound of Kharaz, Gorham and Salman (2001), and the equations of motion.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "grouser/dem/solver.h"
#include "impact_reference.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

/// Alumina, 5 mm, on thick soda-lime glass at 3.9 m/s (data/kharaz2001_oblique_impact/SOURCE.md). The normal
/// restitution was not published with the data: 0.98, nearly elastic.
constexpr double kSpeed = 3.9, kRadius = 0.0025, kRestitution = 0.98;

GrainState rebound(double angle, TangentialStiffness stiffness = TangentialStiffness::mindlin,
                   double restitution = kRestitution) {
  SolverSettings s;
  s.domain.hi = Vec3(0.03, 0.03, 0.03);
  s.gravity = Vec3::Zero();
  s.dt = 1e-9;
  s.precision = Precision::full;
  s.law.tangential = stiffness;
  s.materials.materials[0] = {"alumina", 380e9, 0.23};
  PairProperties p;
  p.friction = 0.092;
  p.rolling = 0;
  p.restitution = restitution;
  s.materials.add({"glass", 70e9, 0.25}, p);
  GrainState g;
  g.radius = kRadius;
  g.density = 4000;
  g.x = Vec3(0.01, 0.015, kRadius + 1e-9);
  g.v = kSpeed * Vec3(std::sin(angle), 0, -std::cos(angle));
  Solver solver(s, {g});
  solver.add_floor(0, 1);
  for (int k = 0; k < 100; ++k) {
    solver.step(500);
    if (k > 0 && solver.counters().touching == 0) break;
  }
  EXPECT_EQ(solver.counters().touching, 0);
  return solver.grains()[0];
}

struct Row {
  std::string quantity;
  double angle, value;  ///< degrees from the normal; [-] or degrees
};
std::vector<Row> measured() {
  std::ifstream file(GROUSER_SOURCE_DIR "/tests/dem/data/kharaz2001_oblique_impact/rebound.csv");
  std::string line, digitisation, angle, value;
  std::getline(file, line);
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    std::istringstream in(line);
    Row r;
    std::getline(in, r.quantity, ',');
    std::getline(in, digitisation, ',');
    std::getline(in, angle, ',');
    std::getline(in, value, ',');
    r.angle = std::stod(angle);
    r.value = std::stod(value);
    rows.push_back(r);
  }
  return rows;
}
double tangential_restitution(double degrees, TangentialStiffness stiffness = TangentialStiffness::mindlin) {
  const double angle = degrees * pi / 180;
  return rebound(angle, stiffness).v[0] / (kSpeed * std::sin(angle));
}

TEST(ObliqueImpact, ReboundsAsAluminaDoesFromGlassFromTenDegreesOn) {
  ASSERT_EQ(measured().size(), 34u);
  for (const Row& r : measured()) {
    if (r.angle < 9) continue;
    // Readings of the figure differ by 0.001 and 0.25 degrees; a normal restitution of 1 instead of 0.98 would turn the
    // rebound by 0.55 degrees. Below 25 degrees the law, which has no slip at the rim of a contact that sticks, adds 0.03
    // and 0.5 degrees.
    if (r.quantity == "tangential_restitution") {
      EXPECT_NEAR(tangential_restitution(r.angle), r.value, r.angle < 25 ? 0.035 : 0.01) << r.angle;
    } else {
      const Vec3 v = rebound(r.angle * pi / 180).v;
      EXPECT_NEAR(std::atan2(v[0], v[2]) * 180 / pi, r.value, r.angle < 25 ? 1.3 : 0.9) << r.angle;
    }
  }
}

TEST(ObliqueImpact, HardlyDependsOnTheRestitutionThatWasAssumed) {
  // Kharaz e = 1: normal restitution was not published with the data. From 9 degrees on the bounds of the test above hold with it too.
  for (const Row& r : measured()) {
    if (r.angle < 9) continue;
    const double angle = r.angle * pi / 180;
    const Vec3 v = rebound(angle, TangentialStiffness::mindlin, 1).v;
    if (r.quantity == "tangential_restitution")
      EXPECT_NEAR(v[0] / (kSpeed * std::sin(angle)), r.value, r.angle < 25 ? 0.035 : 0.01) << r.angle;
    else
      EXPECT_NEAR(std::atan2(v[0], v[2]) * 180 / pi, r.value, r.angle < 25 ? 1.3 : 0.9) << r.angle;
  }
}

TEST(ObliqueImpact, IsTooElasticWhereTheContactSticksAllTheTime) {
  // A limit of the law, not of the solver: the tangential spring gives back all it took (0.98), the measured contact
  // slips at its rim and keeps 0.75 to 0.79. See the README.
  for (const Row& r : measured())
    if (r.quantity == "tangential_restitution" && r.angle < 5) {
      EXPECT_GT(tangential_restitution(r.angle) - r.value, 0.15) << r.angle;
      EXPECT_LT(tangential_restitution(r.angle), 1) << r.angle;
    }
}

TEST(ObliqueImpact, TellsMindlinsStiffnessFromThePrintedOne) {
  for (const Row& r : measured())
    if (r.quantity == "tangential_restitution" && r.angle > 9 && r.angle < 25) {
      EXPECT_GT(std::fabs(tangential_restitution(r.angle, TangentialStiffness::printed) - r.value),
                1.5 * std::fabs(tangential_restitution(r.angle) - r.value))
          << r.angle;
    }
}

TEST(ObliqueImpact, SlidesThroughoutAtSteepTangentsByCoulombsLaw) {
  // e_t = 1 - mu (1 + e)/tan(angle): impulse of friction, whatever the laws of contact are.
  const double angle = 60 * pi / 180;
  const GrainState after = rebound(angle);
  const double e = after.v[2] / (kSpeed * std::cos(angle));
  EXPECT_NEAR(after.v[0] / (kSpeed * std::sin(angle)), 1 - 0.092 * (1 + e) / std::tan(angle), 2e-4);
  EXPECT_NEAR(e, kRestitution, 0.005);
}

TEST(SphereOnAPlane, ReboundsAsTheEquationsOfMotionSay) {
  // The reference's second sphere, fixed and of 100 m radius, is a plane to a grain of 5 mm (R* differs by 5e-5).
  Impact c;
  c.r[0] = 0.005;
  c.r[1] = 100;
  c.v[0] = {0.1, 0, 0};
  c.fixed_target = true;
  const Outcome exact = solve_impact(c, 1e-12);
  SolverSettings s;
  s.domain.hi = Vec3(0.06, 0.06, 0.06);
  s.gravity = Vec3::Zero();
  s.dt = 2e-9;
  s.precision = Precision::full;
  GrainState g;
  g.radius = 0.005;
  g.x = Vec3(0.03, 0.03, 0.005 + 1e-10);
  g.v = Vec3(0, 0, -0.1);
  Solver solver(s, {g});
  solver.add_floor();
  solver.step(static_cast<long>(1.5 * exact.time / s.dt));
  ASSERT_EQ(solver.counters().touching, 0);
  EXPECT_NEAR(solver.grains()[0].v[2], -exact.v[0][0], 2e-5 * 0.1);
}

}  // namespace
