// A node's own law, seen through a flat plate: pressure and sinkage, unloading and reloading, shear.
#include <gtest/gtest.h>

#include "soil_node_support.h"

namespace grouser::test {
namespace {

// Plate of 50 x 150 mm over nodes of 10 mm laid out at its middle: 5 x 15 nodes whose cells are the plate exactly.
constexpr double kLength = 0.05, kWidth = 0.15, kArea = kLength * kWidth, kUnderside = 0.01;
const char* kSpacing = "spacing: 10 mm";

Mover plate_on(const Soil& soil, const std::string& options = kSpacing) {
  return {soil_nodes(soil, options), plate(kLength, kWidth), Vec3(0, 0, kUnderside + 1e-4)};
}

/// Press to `depth` in one step.
double press_to(Mover& m, double depth) {
  const double dt = 1e-3, now = kUnderside - m.motion.X_WB_end.p.z();
  m.move(Vec3(0, 0, (now - depth) / dt), 0, dt);
  return m.result.impulse.z() / dt / kArea;
}

TEST(SoilNode, PlateFollowsThePressureSinkageLaw) {
  const Soil soil = mojave_soil();
  Mover m = plate_on(soil);
  for (const double z : {1e-4, 1e-3, 5e-3, 2e-2}) {
    // (3.22) with the plate's 50 mm. Depths carry the rounding of a hub height of 10 mm: 1e-15/z of the depth, times n.
    const double p = 2.541e5 * std::pow(z / 0.05, 1.387);
    EXPECT_NEAR(press_to(m, z), p, 1e-10 * p) << z;
  }
}

TEST(SoilNode, UnloadingAndReloadingFollowEquation2_12ToRounding) {
  Soil soil = mojave_soil();
  const double ko = 2e6, Au = 5.03e9;
  soil.bekker->repetitive = RepetitiveLoading{ko, Au};
  Mover m = plate_on(soil);
  const double k = 2.541e5 / std::pow(0.05, 1.387), n = 1.387;
  const auto law = [&](double zu, double z) { return std::max(0.0, k * std::pow(zu, n) - (ko + Au * zu) * (zu - z)); };
  double zu = 0;
  for (const double z : {0.004, 0.0039, 0.0035, 0.0037, 0.001, 0.0036, 0.004, 0.008, 0.0078, 0.0072, 0.0075, 0.009}) {
    zu = std::max(zu, z);
    // Rounding: the difference zu - z of depths that carry 1e-17 m, times the slope of 4e7 Pa/m.
    EXPECT_NEAR(press_to(m, z), law(zu, z), 1e-8 + 1e-10 * law(zu, zu)) << z;
  }
  // Lifted clear the rut stays, at the depth where the pressure has gone.
  press_to(m, -1e-3);
  EXPECT_NEAR(m.terrain->surface(0, 0).sinkage, zu - k * std::pow(zu, n) / (ko + Au * zu), 1e-12);
  EXPECT_NEAR(m.terrain->field("plastic_depth", 0, 0), zu, 1e-15);
  EXPECT_EQ(m.terrain->surface(0.2, 0).sinkage, 0);
}

TEST(SoilNode, NeverGivesBackMoreThanWasPutInWhereTheSlopeOfTheSoilFileIsTooSoft) {
  Soil soil = mojave_soil();
  soil.bekker->repetitive = RepetitiveLoading{1.0, 0};  // a spring that would throw the plate out
  Mover m = plate_on(soil);
  for (int pass = 0; pass < 3; ++pass) {
    for (int i = 1; i <= 100; ++i) press_to(m, 1e-4 * i);
    for (int i = 100; i >= -2; --i) press_to(m, 1e-4 * i);
    const EnergyLedger& e = m.terrain->energy();
    EXPECT_LE(e.work_on_bodies, 0);
    EXPECT_NEAR(e.residual(), 0, 2e-4 * e.gross);  // trapezoids of 0.1 mm
  }
}

TEST(SoilNode, ShearFollowsJanosiAndHanamotoAndUnloadsElastically) {
  const Soil soil = mojave_soil();
  const double K = 5.151e-4, c = 139.28, phi = 0.606, dt = 1e-3, step = 5e-5;
  Mover m = plate_on(soil);
  const double N = press_to(m, 0.005) * kArea;
  const double capacity = c * kArea + N * std::tan(phi);
  double x = 0;
  for (int i = 0; i < 60; ++i) {
    m.move(Vec3(step / dt, 0, 0), 0, dt);
    x += step;
    EXPECT_NEAR(-m.result.impulse.x() / dt, capacity * (1 - std::exp(-x / K)), 1e-9 * capacity) << x;
  }
  // Back by a little: the slope of the beginning, capacity/K.
  const double before = -m.result.impulse.x() / dt;
  m.move(Vec3(-step / dt, 0, 0), 0, dt);
  EXPECT_NEAR(before + m.result.impulse.x() / dt, capacity * step / K, 1e-9 * capacity);
  // Far back: sheared the other way, to the same strength, and sideways too (isotropic).
  for (int i = 0; i < 80; ++i) m.move(Vec3(-step / dt, 0, 0), 0, dt);
  EXPECT_NEAR(m.result.impulse.x() / dt, capacity, 5e-3 * capacity);
  for (int i = 0; i < 80; ++i) m.move(Vec3(0, step / dt, 0), 0, dt);
  EXPECT_NEAR(-m.result.impulse.y() / dt, capacity, 5e-3 * capacity);
}

TEST(SoilNode, ShearIsReleasedWhenTheNodeIsUnloaded) {
  Mover m = plate_on(mojave_soil());
  press_to(m, 0.005);
  for (int i = 0; i < 40; ++i) m.move(Vec3(0.05, 0, 0), 0, 1e-3);
  EXPECT_GT(m.terrain->field("shear_displacement", 0, 0), 4e-4);
  press_to(m, -0.001);
  EXPECT_EQ(m.terrain->field("shear_displacement", 0, 0), 0);
  const double p = press_to(m, 0.005);
  EXPECT_GT(p, 0);
  EXPECT_LT(std::abs(m.result.impulse.x()), 1e-12 * m.result.impulse.z());
}

TEST(SoilNode, OtherShearTypesPeakAndFallAsTheirCurvesSay) {
  for (const auto type : {ShearLaw::Type::B, ShearLaw::Type::C}) {
    Soil soil = mojave_soil();
    ShearLaw& s = soil.bekker->shear;
    s.type = type;
    s.Kw = 1e-3;
    s.Kr = 0.6;
    Mover m = plate_on(soil);
    const double N = press_to(m, 0.005) * kArea, capacity = s.cohesion * kArea + N * std::tan(s.friction_angle),
                 e = std::exp(1.0);
    for (int i = 1; i <= 80; ++i) {
      m.move(Vec3(0.05, 0, 0), 0, 1e-3);
      const double x = 5e-5 * i / s.Kw;  // ERRATA's forms of eq 2.9
      const double f = type == ShearLaw::Type::B
                           ? x * std::exp(1 - x)
                           : s.Kr * (1 + (1 / (s.Kr * (1 - 1 / e)) - 1) * std::exp(1 - x)) * (1 - std::exp(-x));
      EXPECT_NEAR(-m.result.impulse.x() / 1e-3, capacity * f, 1e-6 * capacity) << x;
    }
  }
}

TEST(SoilNode, MeshOfACylinderCarriesLikeTheCylinder) {
  // 720 facets: a sagitta of 1.2 um on 10 mm of sinkage; the mesh's edges do not share the cells that they cut.
  TriangleMesh mesh;
  const int n = 720;
  const double r = 0.13, b = 0.16;
  for (int k = 0; k < n; ++k)
    for (const double y : {-0.5 * b, 0.5 * b})
      mesh.vertices.emplace_back(r * std::sin(2 * pi * k / n), y, -r * std::cos(2 * pi * k / n));
  for (int k = 0; k < n; ++k) {
    const std::int32_t a = 2 * k, c = 2 * ((k + 1) % n);
    mesh.triangles.push_back({a, a + 1, c});
    mesh.triangles.push_back({c, a + 1, c + 1});
  }
  mesh.radius = r;
  mesh.width = b;
  double force[2][3];
  for (int k = 0; k < 2; ++k) {
    // The cells of 49 nodes of 3.265 mm are the width exactly.
    Mover m(soil_nodes(mojave_soil(), "spacing: 3.26530612244898 mm"), k ? RunningGear{"mesh", mesh} : mit_wheel(),
            Vec3(0, 0, r - 0.01));
    ContactReport c;
    for (int i = 0; i < 300; ++i) c = m.move(Vec3(0.2, 0, 0), 0.2 / r / 0.7, 1e-3);
    force[k][0] = c.normal_force;
    force[k][1] = c.drawbar_pull;
    force[k][2] = c.driving_torque;
  }
  // 49 nodes of 3.265 mm are the width exactly, so both cover it alike; what is left is the facets.
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(force[1][k], force[0][k], 0.005 * std::abs(force[0][k])) << k;
}

TEST(SoilNode, LugsThatTurnWithTheWheelMakeTheForceRippleAtTheirPitch) {
  const RunningGear lugged{"lugged", LuggedCylinder{0.12, 0.16, 0.01, 0.003, 12, 0.05, 0, 2, 0}};
  Mover m(soil_nodes(mojave_soil(), "spacing: 1.5 mm"), lugged, Vec3(0, 0, 0.13 - 0.012));
  // Pure rolling on the tips: every lug enters the same soil a pitch further on.
  const double pitch = 2 * pi * 0.13 / 12, dt = 1e-3, v = 0.1;
  const int period = static_cast<int>(std::lround(pitch / v / dt));
  std::vector<double> N;
  for (int i = 0; i < 6 * period; ++i) N.push_back(m.move(Vec3(v, 0, 0), v / 0.13, dt).normal_force);
  double mean = 0, same = 0, half = 0, var = 0;
  for (int i = 4 * period; i < 5 * period; ++i) mean += N[i] / period;
  for (int i = 4 * period; i < 5 * period; ++i) {
    var += (N[i] - mean) * (N[i] - mean);
    same += (N[i] - mean) * (N[i + period] - mean);
    half += (N[i] - mean) * (N[i - period / 2] - mean);
  }
  EXPECT_GT(mean, 0);
  EXPECT_GT(same, 0.6 * var) << "repeats after one pitch";
  EXPECT_LT(half, 0.3 * var) << "and not after half of it";
}

TEST(SoilNode, RegionsHaveTheirOwnSoil) {
  const std::string folder = std::string(GROUSER_SOURCE_DIR) + "/examples/soils/";
  const std::string options =
      "spacing: 10 mm\nregions: [{x: [0.5 m, 2 m], y: [-1 m, 1 m], soil: " + folder + "dry_sand.yaml}]";
  const double kc = 0.9e3, kphi = 1523.4e3, n = 1.1, z = 0.005;
  for (const double x : {0.0, 1.0}) {
    Mover m(soil_nodes(mojave_soil(), options), plate(kLength, kWidth), Vec3(x, 0, kUnderside));
    const double p = x == 0 ? 2.541e5 * std::pow(z / 0.05, 1.387) : (kc / kWidth + kphi) * std::pow(z, n);
    EXPECT_NEAR(press_to(m, z), p, 1e-9 * p);
  }
}

}  // namespace
}  // namespace grouser::test
