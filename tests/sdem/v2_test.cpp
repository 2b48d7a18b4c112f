// sdem.v2: its law, its rut, and the terrain.
#include "grouser/sdem/v2.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "grouser/sdem/direction_wheel.h"
#include "grouser/sdem/v1.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

const fs::path kExample = fs::path(GROUSER_SOURCE_DIR) / "examples/17_surrogate_by_direction";
constexpr double kRadius = 0.065, kWidth = 0.03, kLoad = 5.4, kGravity = 9.81;

std::shared_ptr<const sdem::Direction> law() {
  static const auto read = std::make_shared<const sdem::Direction>(sdem::Direction::read(kExample / "law.h5"));
  return read;
}
sdem::DirectionSettings quiet() { return {0, 1, 0, true, true}; }
double level(double) { return 0; }

/// A wheel under a load whose height is free, as a host moves it.
struct Carrier {
  explicit Carrier(const sdem::DirectionSettings& s = quiet()) : wheel(law(), s) {}
  sdem::DirectionWheel wheel;
  double load = kLoad, x = 0, z = kRadius + 2e-3, vz = 0;
  sdem::PlaneForce f;
  void go(double vx, double rim, double dt) {
    const double m = load / kGravity;
    vz = (m * vz + dt * (f.fz - load)) / (m + dt * dt * f.normal_slope);
    f = wheel.step({x, z, x + vx * dt, z + vz * dt, rim * dt, 0, dt}, level);
    x += vx * dt;
    z += vz * dt;
  }
};

TEST(Rut, KeepsTheVolumeOfSoil) {
  // Ploughing through and over its own heaps, both ways, deep and shallow; what is laid on the way is fresh and counted.
  sdem::Rut rut(2e-3, kRadius);
  rut.lay(-0.2, 1.3, level);
  const double before = rut.volume();
  double way = 0;
  for (int k = 0; k < 4000; ++k) {
    const double s = 0.5 + 0.5 * std::sin(k * 2e-3), z = kRadius - 0.004 - 0.003 * std::sin(k * 0.05);
    way += std::abs(0.5 * std::cos(k * 2e-3) * 2e-3);
    rut.displace(s, z, {0.4, 0.3, (k % 3 - 1) * 1e-6, k % 2 ? 1.0 : -1.0});
  }
  EXPECT_GT(rut.compacted(), 1e-4);
  // Rounding of sums of a thousand columns.
  EXPECT_LT(std::abs(rut.volume() - before) / way, 1e-15 * 1e3);
}

TEST(Rut, ColumnsUnderTheWheelFollowTheRim) {
  sdem::Rut rut(2e-3, kRadius);
  rut.lay(-0.2, 0.3, level);
  for (int k = 0; k < 100; ++k) rut.displace(1e-3 * k, kRadius - 0.005, {0.5, 0.5, 0, 1});
  for (double d = -0.015; d < 0.015; d += 1e-3) {
    const double i = std::round((0.099 + d) / 2e-3 - 0.5), s = (i + 0.5) * 2e-3, u = s - 0.099;
    EXPECT_LE(rut.height(s), kRadius - 0.005 - std::sqrt(kRadius * kRadius - u * u) + kRadius * 1e-12 + 1e-12) << s;
  }
}

TEST(Rut, OverlapIsThatOfTheCircle) {
  sdem::Rut rut(2e-3, kRadius);
  rut.lay(-0.2, 0.2, level);
  for (const double depth : {1e-4, 1e-3, 5e-3, 0.02}) {
    const double a = std::acos(1 - depth / kRadius), exact = kRadius * kRadius * (a - std::sin(a) * std::cos(a));
    const sdem::Overlap o = rut.overlap(0.0123, kRadius - depth);
    // Pieces of the rim are parabolas over 2 mm.
    EXPECT_NEAR(o.area / exact, 1, 2e-4) << depth;
    EXPECT_NEAR(o.length, 2 * kRadius * std::sin(a), 1e-6);
    EXPECT_NEAR(o.slope, 0, 1e-9);
    EXPECT_NEAR(std::asin(o.front / kRadius), a, 1e-6);
  }
}

TEST(DirectionLaw, ForcesDoNotDependOnSpeed) {
  for (const double slow : {0.1, 0.01}) {
    sdem::DirectionWheel fast(law(), quiet()), other(law(), quiet());
    for (int k = 0; k < 200; ++k) {
      // The same way in other times: displacements are all that counts.
      const sdem::PlaneMotion m{
          k * 5e-4, kRadius - 0.002 - 1e-5 * k, (k + 1) * 5e-4, kRadius - 0.002 - 1e-5 * (k + 1), 7e-4, 0, 1e-2};
      const auto f = fast.step(m, level);
      sdem::PlaneForce g;
      const int parts = static_cast<int>(std::lround(1 / slow));
      for (int i = 0; i < parts; ++i) {
        const double u = static_cast<double>(i) / parts, v = static_cast<double>(i + 1) / parts;
        g = other.step({m.s0 + u * 5e-4, m.z0 - u * 1e-5, m.s0 + v * 5e-4, m.z0 - v * 1e-5, 7e-4 / parts, 0, 1}, level);
      }
      if (k < 20) continue;
      EXPECT_NEAR(g.fz, f.fz, 0.03 * f.fz) << k;
      EXPECT_NEAR(g.torque, f.torque, 0.03 * f.fz * kRadius) << k;
    }
  }
}

TEST(DirectionLaw, BackwardTravelMirrorsForwardTravel) {
  const sdem::Direction& d = *law();
  for (const double rim : {0.5, 0.8, 1.0, 1.3, 2.0}) {
    const sdem::Level a = d.level(1, rim, 4e-3, 0.2), b = d.level(-1, -rim, 4e-3, -0.2);
    EXPECT_NEAR(a.force, b.force, 1e-12 * a.force);
    EXPECT_NEAR(a.mu, -b.mu, 1e-12);
    EXPECT_NEAR(a.tau, -b.tau, 1e-12);
  }
  // Continuous all around.
  sdem::Level last = d.level(1, 0, 3e-3, 0);
  for (double angle = 0; angle < 2 * 3.14159; angle += 1e-3) {
    const sdem::Level now = d.level(std::cos(angle), std::sin(angle), 3e-3, 0);
    EXPECT_NEAR(now.mu, last.mu, 0.02) << angle;
    EXPECT_NEAR(now.force / last.force, 1, 0.02) << angle;
    last = now;
  }
}

TEST(DirectionLaw, SlidingAsideOnlyLoses) {
  sdem::DirectionSettings s = quiet();
  s.side_friction = 0.5;
  s.side_turn = 0.2;
  for (const double slip : {-0.5, -0.2, 0.0, 0.2, 0.6})
    for (const double angle : {-1.3, -0.4, 0.1, 0.4, 0.8, 1.3}) {
      sdem::DirectionWheel wheel(law(), s);
      const double dx = 2e-4 * (slip > 0 ? 1 - slip : 1), rim = 2e-4 / (slip > 0 ? 1 : 1 - slip),
                   side = dx * std::tan(angle);
      sdem::PlaneForce f;
      for (int k = 0; k < 300; ++k)
        f = wheel.step({k * dx, kRadius - 3e-3, (k + 1) * dx, kRadius - 3e-3, rim, side, 1e-2}, level);
      // Of the motor and of what drags the hub, over a step, against N times the way.
      const double spent = f.torque / kRadius * rim - f.fs * dx - f.side * side;
      EXPECT_GT(spent, 0.02 * f.normal * std::hypot(side, rim - dx)) << slip << " " << angle;
    }
}

TEST(DirectionLaw, AWheelThatRestsDoesNotCreep) {
  // Issue: hold creep below 1e-3 mm/s.
  Carrier c;
  for (int k = 0; k < 4000; ++k) c.go(0, 0, 1e-3);
  const double x = c.z;
  EXPECT_NEAR(c.f.fz, kLoad, 1e-3 * kLoad);
  for (int k = 0; k < 60000; ++k) c.go(0, 0, 1e-3);
  EXPECT_LT(std::abs(c.z - x) / 60, 1e-6 * 1e-3);
}

TEST(DirectionLaw, ReloadingFollowsTheSpringUpToWhereItYielded) {
  sdem::DirectionWheel w(law(), quiet());
  double z = kRadius + 3e-3;
  sdem::PlaneForce last;
  const auto move = [&](double dz) {
    last = w.step({0, z, 0, z + dz, 0, 0, 1e-3}, level);
    z += dz;
    return last.fz;
  };
  double f = 0;
  while (f < 10) f = move(-1e-5);
  const double deep = z, spring = last.normal / std::exp(law()->at(sdem::Coefficient::ln_k)) / last.normal_z;
  while (f > 0) f = move(1e-5);
  const double lifted = z;
  // k = N/d of the law, not a fitted number of this test.
  EXPECT_NEAR(lifted - deep, spring, 0.03 * spring + 1e-5);
  while (z > deep) f = move(-1e-5);
  EXPECT_NEAR(f, 10, 0.3);
  const double more = move(-2e-4);
  EXPECT_LT(more - f, 2e-4 * std::exp(law()->at(sdem::Coefficient::ln_k)) * 0.9) << "yields again";
}

TEST(DirectionLaw, SinkageGrowsWithSlipAndLoadAndStopsGrowing) {
  double last = 1;
  for (const double s : {-0.5, 0.0, 0.3, 0.6}) {
    Carrier c;
    for (int k = 0; k < 300; ++k) c.go(0, 0, 1e-3);
    const double rim = 0.06, vx = rim * (1 - s);
    double early = 0, late = 0;
    const int n = static_cast<int>(0.3 / vx / 1e-3);
    for (int k = 0; k < n; ++k) {
      c.go(vx, rim, 1e-3);
      if (k > n / 2) (k < 3 * n / 4 ? early : late) += c.z / (n / 4.0);
    }
    EXPECT_LT(late, last);
    EXPECT_NEAR(early, late, 4e-4) << s;
    last = late;
  }
}

/// Longitudinal force and height over 0.3 m of level way after 50 mm; every millisecond.
struct Series {
  std::vector<double> force, height, normal;
};
Series level_way(double slip, double grain_noise, std::uint64_t seed, double speed = 0.06) {
  sdem::DirectionSettings s = quiet();
  s.grain_noise = grain_noise;
  s.seed = seed;
  Carrier c(s);
  // The greater of rim and travel is the speed.
  const double rim = speed * std::min(1.0, 1 / (1 - slip)), vx = rim * (1 - slip);
  Series out;
  while (c.x < 0.35) {
    c.go(vx, rim, 1e-3);
    if (c.x < 0.05) continue;
    out.force.push_back(c.f.fs);
    out.height.push_back(c.z);
    out.normal.push_back(c.f.fz);
  }
  return out;
}
double mean_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

TEST(DirectionLaw, FluctuationKeepsTheMeanOverSeeds) {
  constexpr int kSeeds = 24;
  for (const double slip : {-0.3, 0.0, 0.3}) {
    const Series still = level_way(slip, 0, 1);
    std::vector<double> force, height;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const Series s = level_way(slip, 1, static_cast<std::uint64_t>(seed));
      force.push_back(mean_of(s.force) - mean_of(still.force));
      height.push_back(mean_of(s.height) - mean_of(still.height));
    }
    const auto error = [](const std::vector<double>& v) {
      double sum = 0;
      for (const double x : v) sum += (x - mean_of(v)) * (x - mean_of(v));
      return std::sqrt(sum / (kSeeds - 1) / kSeeds);
    };
    // Three standard errors, and what the law's curvature shifts: 1 % of the load, 0.2 mm.
    EXPECT_LT(std::abs(mean_of(force)), 3 * error(force) + 0.01 * kLoad) << slip;
    EXPECT_LT(std::abs(mean_of(height)), 3 * error(height) + 2e-4) << slip;
    EXPECT_GT(error(force), 0) << slip;
  }
}

/// Way over which half of the fluctuation of the drawbar pull is forgotten. Grains (validation of examples/17_surrogate_by_direction, five packings
/// each; none is a training run): 6.6 mm at slip 0, 4.4 mm at -0.41, 1.6 mm at 0.7; sampled at 0.3 mm of way, single packings 0.6 to 1.5 times that.
TEST(DirectionLaw, FluctuationIsForgottenAsThatOfGrains) {
  const std::vector<std::pair<double, double>> grains{{0.0, 6.6e-3}, {-0.7, 4.4e-3}, {0.7, 1.6e-3}};
  for (const auto& [slip, way] : grains) {
    double half = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const std::vector<double> f = level_way(slip, 1, seed).force;
      const double mean = mean_of(f), step = 0.3 / static_cast<double>(f.size());
      const auto covariance = [&](std::size_t lag) {
        double sum = 0;
        for (std::size_t i = lag; i < f.size(); ++i) sum += (f[i] - mean) * (f[i - lag] - mean);
        return sum;
      };
      std::size_t lag = 1;
      while (covariance(lag) > 0.5 * covariance(0)) ++lag;
      half += static_cast<double>(lag) * step / 10;
    }
    EXPECT_GT(half, 0.6 * way) << slip;
    EXPECT_LT(half, 1.5 * way) << slip;
  }
}

/// Standard deviations of the vertical force of grains that carry a free wheel (results/speeds.csv and fresh.csv of the example, three packings and five;
/// none was fitted to): faster wheels are shaken harder, since what shakes them lies along the way.
TEST(DirectionLaw, ShakesFasterWheelsHarderAsGrainsDo) {
  struct Measured {
    double slip, speed, sd;
  };
  double slow = 0;
  for (const Measured& m : {Measured{0.0, 0.06, 0.29}, Measured{0.0, 0.15, 0.59}, Measured{0.0, 0.3, 0.97},
                            Measured{0.3, 0.06, 0.30}, Measured{0.3, 0.15, 0.59}, Measured{0.3, 0.3, 1.07},
                            Measured{-0.3, 0.06, 0.61}, Measured{-0.3, 0.15, 1.05}, Measured{-0.3, 0.3, 2.12}}) {
    double sd = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const std::vector<double> f = level_way(m.slip, 1, seed, m.speed).normal;
      const double mean = mean_of(f);
      double sum = 0;
      for (const double x : f) sum += (x - mean) * (x - mean);
      sd += std::sqrt(sum / static_cast<double>(f.size())) / 10;
    }
    // Within a factor of two, as is asked of what is fitted.
    EXPECT_GT(sd, 0.5 * m.sd) << m.slip << " at " << m.speed;
    EXPECT_LT(sd, 2.0 * m.sd) << m.slip << " at " << m.speed;
    if (m.speed > 0.06) {
      EXPECT_GT(sd, slow);
    }
    slow = sd;
  }
}

TEST(DirectionLaw, NeighbouringSeedsShareNothing) {
  // Wheels of a vehicle have neighbouring seeds.
  double together = 0, own = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<double> a = level_way(0, 1, seed).height, b = level_way(0, 1, seed + 1).height;
    const double ma = mean_of(a), mb = mean_of(b);
    for (std::size_t i = 0; i < a.size(); ++i) {
      together += (a[i] - ma) * (b[i] - mb);
      own += 0.5 * ((a[i] - ma) * (a[i] - ma) + (b[i] - mb) * (b[i] - mb));
    }
  }
  // 20 ways of some ten independent waves: 0.07 is one standard error.
  EXPECT_LT(std::abs(together / own), 0.25);
}

class V2 : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("sdem_v2_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    fs::copy_file(kExample / "law.h5", folder_ / "law.h5", fs::copy_options::overwrite_existing);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::unique_ptr<Terrain> make(const std::string& options, std::string* errors = nullptr,
                                const std::string& young = "70 MPa") const {
    const std::string text =
        "soil: grains\nsource: none\ndem:\n  diameter: [5 mm, 10 mm]\n  density: 3.26 g/cm^3\n"
        "  bulk_density: 1.6 g/cm^3\n  young_modulus: " +
        young +
        "\n  poisson_ratio: 0.35\n"
        "  friction: 0.86\n  rolling: {law: constant, coefficient: 0.3}\n  restitution: 0.06\n"
        "  wall: {friction: 0, restitution: 0.06}\n";
    const ConfigDocument file = ConfigDocument::from_text(text, "soil.yaml");
    const Soil soil = load_soil(file.root());
    const ConfigDocument given = ConfigDocument::from_text("options: {" + options + "}", "options.yaml", folder_);
    auto t = sdem::v2_model().make({soil, flat_ground(), given.root().map("options"), kGravity});
    if (errors) {
      errors->clear();
      for (const Diagnostic& d : given.diagnostics()) *errors += d.text() + "\n";
    } else {
      given.check();
    }
    return t;
  }
  fs::path folder_;
};

TEST_F(V2, RefusesWhatIsNotItsLaw) {
  std::string e;
  make("law: law.h5", &e);
  EXPECT_EQ(e, "");
  make("law: law.h5", &e, "71 MPa");
  EXPECT_NE(e.find("of another soil"), std::string::npos) << e;
  make("law: nothing.h5", &e);
  EXPECT_NE(e.find("nothing.h5"), std::string::npos) << e;
  make("lax: law.h5", &e);
  EXPECT_NE(e.find("did you mean 'law'"), std::string::npos) << e;
  // Cut short.
  fs::resize_file(folder_ / "law.h5", fs::file_size(folder_ / "law.h5") / 2);
  make("law: law.h5", &e);
  EXPECT_NE(e.find("law.h5"), std::string::npos) << e;
  EXPECT_NE(e, "");
  // Another kind.
  fs::copy_file(fs::path(GROUSER_SOURCE_DIR) / "examples/14_surrogate/coarse_tables.h5", folder_ / "law.h5",
                fs::copy_options::overwrite_existing);
  make("law: law.h5", &e);
  EXPECT_NE(e.find("not a law of sdem.v2"), std::string::npos) << e;
}

TEST_F(V2, RefusesALawWhoseContentDoesNotMatchItsHash) {
  std::ifstream in(folder_ / "law.h5", std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  // The stored radius 0.065 as it lies in the file; one bit of its last byte but one.
  const double radius = law()->radius;
  const std::string pattern(reinterpret_cast<const char*>(&radius), sizeof radius);
  const std::size_t at = bytes.find(pattern);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 2] = static_cast<char>(bytes[at + 2] ^ 1);
  std::ofstream(folder_ / "law.h5", std::ios::binary) << bytes;
  std::string e;
  make("law: law.h5", &e);
  EXPECT_NE(e.find("does not match its stored hash"), std::string::npos) << e;
}

TEST_F(V2, RefusesAnotherWheel) {
  const auto t = make("law: law.h5");
  try {
    t->add_body({"big", {"big", SmoothCylinder{0.13, 0.1}}, {}});
    FAIL();
  } catch (const TerrainError& e) {
    EXPECT_NE(std::string(e.what()).find("its radius is 0.13 m"), std::string::npos) << e.what();
  }
  EXPECT_THROW(make("")->add_body({"wheel", {"wheel", SmoothCylinder{kRadius, kWidth}}, {}}), TerrainError);
}

TEST_F(V2, CountsWhatLiesOutsideTheTraining) {
  for (const bool far : {false, true}) {
    const auto t = make("law: law.h5, grain_noise: 0");
    t->add_body({"wheel", {"wheel", SmoothCylinder{kRadius, kWidth}}, {}});
    // A wheel that spins backward while it goes forward, 20 mm deep, was never trained.
    const double depth = far ? 0.02 : 0.002, spin = far ? -2 : 1.1;
    const double dt = 1e-3, vx = 0.06;
    for (int k = 0; k < 500; ++k) {
      const auto pose = [&](int i) {
        return Pose{Vec3(vx * dt * i, 0, kRadius - depth), Quat(Eigen::AngleAxisd(spin * dt * i, Vec3::UnitY()))};
      };
      BodyMotion m{pose(k), pose(k + 1), {Vec3(vx, 0, 0), Vec3(0, spin, 0)}, {}};
      BodyResult r;
      t->step(dt * k, dt, {&m, 1}, {&r, 1});
    }
    if (far)
      EXPECT_GT(t->field("outside", 0, 0), 0.9);
    else
      EXPECT_LT(t->field("outside", 0, 0), 0.1);
    EXPECT_GT(t->field("drawbar_sd", 0, 0), 0);
  }
}

}  // namespace
}  // namespace grouser::test
