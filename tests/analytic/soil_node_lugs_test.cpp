// Lugs: as a mean over tips and tread against an independent integral and against bounds; one by one where the grid sees them.
#include <gtest/gtest.h>

#include "grouser/bekker/steady.h"
#include "grouser/terrain/loaders.h"
#include "soil_node_support.h"

namespace grouser::test {
namespace {

constexpr double v = 0.1;

/// Wheel of the Mars Exploration Rover (dissertation Table 3.3).
LuggedCylinder mer(double tread_radius = 0.219) {
  LuggedCylinder w;
  w.radius = 0.125;
  w.width = 0.16;
  w.lug_height = 5.55e-3;
  w.lug_width = 2.1e-3;
  w.lug_count = 30;
  w.lug_ratio = 30 * 2.1e-3 / (2 * pi * 0.125);
  w.tread_radius = tread_radius;
  return w;
}

Soil lunar() {
  Soil s;
  s.name = "lunar";
  s.bekker = mojave();
  s.bekker->pressure = {PressureSinkage::Law::kc_kphi, 1400, 820000, 0, 1.0, 0};
  s.bekker->shear = {ShearLaw::Type::A, 170, 35 * pi / 180, 0.018, 0, 1};
  return s;
}

struct Mean {
  double Fx = 0, Fz = 0, T = 0, sd = 0;  ///< sd of the drawbar
};

/// Equations of closure local with eq 2.15, integrated over the travel by 200000 trapezoids: tips at r_s, flat tread.
Mean integral(const LuggedCylinder& w, double h, double slip) {
  const BekkerSoil s = mojave();
  const double k = 2.541e5 / std::pow(0.05, 1.387), n = 1.387, rs = w.radius + w.lug_height, mu = w.lug_ratio;
  const auto part = [&](double share, double z) { return z > 0 ? share * k * std::pow(z, n) : 0.0; };
  const double p1 = part(mu, h), p2 = part(1 - mu, h - w.lug_height), pu = p1 + p2,
               back = 0.02 * (p1 * h + p2 * (h - w.lug_height)) / pu, zs = h - back;  // springs back by 2 % of each
  const double ratio = slip >= 0 ? 1 / (1 - slip) : 1 + slip, tan_phi = std::tan(s.shear.friction_angle);
  const double front = std::sqrt(rs * rs - (rs - h) * (rs - h)), rear = -std::sqrt(rs * rs - (rs - back) * (rs - back));
  const int N = 200000;
  const double dx = (front - rear) / N;
  Mean a;
  double u = 0, J = 0;
  for (int i = 0; i <= N; ++i) {
    const double x = front - i * dx, root = std::sqrt(rs * rs - x * x), cosine = root / rs, sine = x / rs;
    const double z = root - (rs - h), tread = std::sqrt(w.radius * w.radius - x * x) - (rs - h);
    const double p = x >= 0 ? part(mu, z) + part(1 - mu, tread) : std::max(0.0, pu * (z - zs) / back);
    if (i > 0) {
      const double trial = u + (ratio * rs / w.radius - cosine) * dx, y = s.shear.K * (1 - std::exp(-J / s.shear.K));
      u = trial;
      if (std::abs(trial) > y) {
        J += std::abs(trial) - y;
        u = std::copysign(s.shear.K * (1 - std::exp(-J / s.shear.K)), trial);
      }
    }
    const double tau = p > 0 ? (s.shear.cohesion + p * tan_phi) * u / s.shear.K : 0,
                 b = (i == 0 || i == N ? 0.5 : 1) * w.width * dx;
    a.Fx += b * (-p * sine / cosine + tau);
    a.Fz += b * (p + tau * sine / cosine);
    a.T += b * rs * tau / cosine;
  }
  return a;
}

/// Rolled over `length` after 0.1 m: at a fixed sinkage of the tips, or under a load (mass on the soil, linearly implicit in z).
Mean roll(std::unique_ptr<Terrain> terrain, const LuggedCylinder& w, double sinkage, double load, double slip,
          double dt, double length, double speed = v) {
  Mover m(std::move(terrain), RunningGear{"mer", w}, Vec3(0, 0, w.radius + w.lug_height - sinkage));
  const double spin = (slip >= 0 ? speed / (1 - slip) : speed * (1 + slip)) / w.radius, mass = load / 9.81;
  const int first = static_cast<int>(std::lround(0.1 / speed / dt)),
            n = static_cast<int>(std::lround(length / speed / dt));
  Mean a;
  double vz = 0, square = 0;
  for (int i = 0; i < first + n; ++i) {
    const ContactReport& c = m.move(Vec3(speed, 0, vz), spin, dt);
    if (load > 0) {
      const auto& l = m.result.linearisation;
      const double K = l ? l->dF_dx(2, 2) : 0, D = l ? l->dF_dv(2, 2) : 0;
      vz += dt * (m.result.impulse.z() / dt - load + dt * K * vz) / (mass - dt * D - dt * dt * K);
    }
    if (i < first) continue;
    a.Fx += c.drawbar_pull / n;
    a.Fz += c.normal_force / n;
    a.T += c.driving_torque / n;
    square += c.drawbar_pull * c.drawbar_pull / n;
  }
  a.sd = std::sqrt(std::max(0.0, square - a.Fx * a.Fx));
  return a;
}

TEST(SoilNodeLugs, MeanTendsToTheIntegralOfEquation2_15WithSpacingAndStep) {
  const LuggedCylinder w = mer(0);
  for (const double h : {0.004, 0.012})  // tips alone; tips and tread
    for (const double slip : {-0.3, 0.1, 0.5}) {
      const Mean truth = integral(w, h, slip);
      const double size = std::hypot(truth.Fx, truth.Fz);
      const auto error = [&](double spacing, double dt) {
        const Mean m =
            roll(soil_nodes(mojave_soil(), "{lugs: mean, spacing: " + std::to_string(1e3 * spacing) + " mm}"), w, h, 0,
                 slip, dt, 0.0495);
        return std::max({std::abs(m.Fx - truth.Fx), std::abs(m.Fz - truth.Fz), std::abs(m.T - truth.T) / 0.13}) / size;
      };
      const double coarse = error(6.6e-3, 2e-3), usual = error(3.3e-3, 1e-3), fine = error(1.65e-3, 5e-4);
      std::printf("mean lugs, tips %.0f mm deep, slip %4.1f: error %.3f, %.3f, %.3f %% at 6.6, 3.3, 1.65 mm\n", 1e3 * h,
                  slip, 100 * coarse, 100 * usual, 100 * fine);
      EXPECT_LT(usual, 0.01) << h << ", slip " << slip;
      EXPECT_LT(fine, 0.003) << h << ", slip " << slip;
    }
}

TEST(SoilNodeLugs, MerWheelPullsNoMoreThanTheSoilCanBearAndRunsSmoothly) {
  // 80 N at 3.3 mm: lugs of 2.1 mm are carried as a mean. Bound: tan phi plus cohesion over chord times width.
  for (const double speed : {0.1, 0.01})
    for (const double slip : {0.05, 0.3, 0.55}) {
      const Mean a = roll(soil_nodes(lunar(), ""), mer(), 0.004, 80, slip, speed > 0.05 ? 1e-3 : 4e-3, 0.1, speed);
      const Mean s =
          roll(bekker::steady_model().make({lunar(), flat_ground(), {}, 9.81}), mer(), 0.004, 80, slip, 1e-3, 0.1);
      std::printf("MER 80 N, slip %.2f, %.2f m/s: drawbar %.2f +- %.3f N, torque %.3f N m (steady %.2f N, %.3f N m)\n",
                  slip, speed, a.Fx, a.sd, a.T, s.Fx, s.T);
      EXPECT_NEAR(a.Fz, 80, 0.5);
      EXPECT_LT(a.Fx / a.Fz, std::tan(35 * pi / 180) + 170 * 0.16 * 0.1 / 80);
      EXPECT_LT(a.sd, 1);
    }
}

TEST(SoilNodeLugs, PressedAndReleasedTheyGiveBackLessThanWasPutIn) {
  for (const bool soft : {false, true}) {
    Soil soil = mojave_soil();
    if (soft) soil.bekker->repetitive = RepetitiveLoading{1.0, 0};  // the floor of N2 has to hold for tips and tread
    Mover m(soil_nodes(soil, "lugs: mean"), RunningGear{"mer", mer()}, Vec3(0, 0, 0.1306));
    for (const int depth : {60, 100, 140}) {
      for (int i = 0; i < depth; ++i) m.move(Vec3(0, 0, -0.1), 0, 1e-3);
      for (int i = 0; i < depth; ++i) m.move(Vec3(0, 0, 0.1), 0, 1e-3);
      const EnergyLedger& e = m.terrain->energy();
      EXPECT_LE(e.work_on_bodies, 0);
      EXPECT_NEAR(e.residual(), 0, 1e-3 * e.gross);  // trapezoids of 0.1 mm
    }
  }
}

TEST(SoilNodeLugs, HitWheelRunsSmoothlyAtTenMillimetresPerSecond) {
  const std::string folder = std::string(GROUSER_SOURCE_DIR) + "/examples";
  const Soil soil = load_soil_file(folder + "/soils/hit_lss1.yaml");
  const auto w = std::get<LuggedCylinder>(load_running_gear_file(folder + "/wheels/ding_wheel.yaml").shape);
  for (const double slip : {0.075, 0.375}) {
    const Mean a = roll(soil_nodes(soil, ""), w, 0.004, 80, slip, 1e-3, 0.05, 0.01);
    std::printf("HIT 80 N, slip %.3f: drawbar %.2f +- %.3f N, torque %.3f N m\n", slip, a.Fx, a.sd, a.T);
    EXPECT_LT(a.Fx / a.Fz,
              std::tan(soil.bekker->shear.friction_angle) + soil.bekker->shear.cohesion * w.width * 0.12 / 80);
    EXPECT_LT(a.sd, 1);
  }
}

TEST(SoilNodeLugs, ResolvedLugsPullNoMoreThanTheSoilCanBear) {
  // 1 mm between nodes sees a tip of 2.1 mm twice, and 4 K of the simulant are 2.06 mm: `auto` resolves it.
  for (const double slip : {0.05, 0.3, 0.55}) {
    const Mean a = roll(soil_nodes(mojave_soil(), "spacing: 1 mm"), mer(), 0.006, 80, slip, 1e-3, 0.05, 0.2),
               b = roll(soil_nodes(mojave_soil(), "{spacing: 1 mm, lugs: mean}"), mer(), 0.006, 80, slip, 1e-3, 0.05,
                        0.2);
    std::printf(
        "resolved at 1 mm, slip %.2f: drawbar %.2f +- %.2f N, torque %.3f N m, load %.1f N (mean: %.2f N, %.3f N m)\n",
        slip, a.Fx, a.sd, a.T, a.Fz, b.Fx, b.T);
    EXPECT_LT(a.Fx / a.Fz, std::tan(0.606) + 139.28 * 0.16 * 0.1 / 80);
  }
}

TEST(SoilNodeLugs, AutoCarriesALugAsAMeanWhereNodesOrShearDoNotSeeIt) {
  const auto last = [](const Soil& soil, const std::string& options) {
    return roll(soil_nodes(soil, options), mer(), 0.008, 0, 0.3, 1e-3, 0.01, 1).Fx;
  };
  EXPECT_EQ(last(mojave_soil(), ""), last(mojave_soil(), "lugs: mean"));
  EXPECT_EQ(last(lunar(), "spacing: 1 mm"), last(lunar(), "{spacing: 1 mm, lugs: mean}"));
  EXPECT_EQ(last(mojave_soil(), "spacing: 1 mm"), last(mojave_soil(), "{spacing: 1 mm, lugs: resolved}"));
  EXPECT_NE(last(mojave_soil(), "spacing: 1 mm"), last(mojave_soil(), "{spacing: 1 mm, lugs: mean}"));
}

}  // namespace
}  // namespace grouser::test
