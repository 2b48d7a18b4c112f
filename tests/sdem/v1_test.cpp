// sdem.v1 as a terrain.
#include "grouser/sdem/v1.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <filesystem>

#include "grouser/dem/soil_config.h"
#include "grouser/terrain/loaders.h"
#include "literal.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSoil = R"(soil: grains of Table 5.3
source: none
dem:
  diameter: [2.5 mm, 10 mm]
  density: 3.2 g/cm^3
  bulk_density: 1.6 g/cm^3
  young_modulus: 70 MPa
  poisson_ratio: 0.35
  friction: 0.86
  rolling: {law: rate, coefficient: 6.75e8 s^2/m^2}
  restitution: 0.06
  wall: {friction: 0, restitution: 0.06}
)";

class V1 : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("sdem_v1_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(sdem::Tables t, const std::string& name = "tables.h5") const {
    const ConfigDocument soil = ConfigDocument::from_text(kSoil, "soil.yaml");
    t.soil = sdem::soil_text(soil.root().map("dem"));
    t.write(folder_ / name);
    return folder_ / name;
  }
  /// "" or all errors.
  std::unique_ptr<Terrain> make(const std::string& options, std::string* errors = nullptr,
                                GroundPtr ground = flat_ground(), const std::string& soil_text = kSoil) const {
    const ConfigDocument file = ConfigDocument::from_text(soil_text, "soil.yaml");
    const Soil soil = load_soil(file.root());
    const ConfigDocument given = ConfigDocument::from_text("options: {" + options + "}", "options.yaml", folder_);
    auto t = sdem::v1_model().make({soil, std::move(ground), given.root().map("options"), 9.81});
    if (errors) {
      errors->clear();
      for (const Diagnostic& d : given.diagnostics()) *errors += d.text() + "\n";
    } else {
      given.check();
    }
    return t;
  }
  static RunningGear wheel(double radius = kRadius) { return {"wheel", SmoothCylinder{radius, kWidth}}; }
  std::unique_ptr<Terrain> with_wheel(const std::string& options, GroundPtr ground = flat_ground(), int n = 1) const {
    auto t = make(options, nullptr, std::move(ground));
    for (int i = 0; i < n; ++i) t->add_body({"wheel" + std::to_string(i), wheel(), {}});
    return t;
  }
  fs::path folder_;
};

/// Rolling at constant velocity along a heading, sinking.
struct Roll {
  double vx = 0.02, vz = -0.004, w = 0.3, yaw = 0, depth = 0.005;
  Vec3 start = Vec3::Zero();
  BodyMotion between(double a, double b) const {
    const Vec3 forward(std::cos(yaw), std::sin(yaw), 0), axis(-std::sin(yaw), std::cos(yaw), 0);
    const auto pose = [&](double t) {
      return Pose{
          start + Vec3(0, 0, kRadius - depth + vz * t) + vx * t * forward,
          Quat(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(w * t, Eigen::Vector3d::UnitY()))};
    };
    return {pose(a), pose(b), {vx * forward + vz * Vec3::UnitZ(), w * axis}, {}};
  }
};

BodyResult step_one(Terrain& t, double time, double dt, const BodyMotion& m) {
  BodyResult r;
  t.step(time, dt, {&m, 1}, {&r, 1});
  return r;
}

TEST_F(V1, AnswersLikeTheLiteralProcedure) {
  sdem::Tables t = random_tables(11, true);
  for (std::size_t p = 0; p < 6; ++p)
    for (auto* values : {&t.parts[p].x, &t.parts[p].z})
      for (float& f : *values) f *= p < 4 ? 4e-3F : 3e3F;
  write(t);
  const auto terrain = with_wheel("table: tables.h5");
  Literal literal{t, {}, -kBed};
  for (int i = -120; i <= 400; ++i) literal.points.push_back({2.5e-3 * i, 0});
  const Roll roll;
  const double dt = 7e-4;
  const auto V = literal.velocity(roll.w, roll.vx, roll.vz);
  double fz = 0;
  for (int k = 0; k < 400; ++k) {
    const BodyMotion m = roll.between(k * dt, (k + 1) * dt);
    const BodyResult r = step_one(*terrain, k * dt, dt, m);
    literal.move(m.X_WB_end.p.x(), m.X_WB_end.p.z(), V, dt, fz > 0);  // nobody tells a weight
    const auto f = literal.force(m.X_WB_end.p.x(), m.X_WB_end.p.z(), V, kWidth);
    fz = f[1];
    ASSERT_NEAR(r.impulse.x(), f[0] * dt, 2e-4 * dt) << k;
    ASSERT_NEAR(r.impulse.z(), f[1] * dt, 2e-4 * dt) << k;
    ASSERT_NEAR(r.angular_impulse.y(), -f[2] * dt, 2e-5 * dt) << k;
    ASSERT_EQ(r.impulse.y(), 0);
  }
}

TEST_F(V1, IsSilentClearOfTheSoil) {
  write(random_tables(12, true));
  const auto terrain = with_wheel("table: tables.h5");
  Roll roll;
  roll.depth = -0.01;
  roll.vz = 0.001;
  for (int k = 0; k < 20; ++k) {
    BodyMotion m = roll.between(k * 1e-3, (k + 1) * 1e-3);
    m.hub = HubDynamics{0.55, Mat3::Identity(), {{0, 0, -5.4}, Vec3::Zero()}};
    const BodyResult r = step_one(*terrain, k * 1e-3, 1e-3, m);
    EXPECT_EQ(r.impulse, Vec3(Vec3::Zero()));
    EXPECT_FALSE(r.report.in_contact);
  }
  EXPECT_EQ(terrain->energy().dissipated, 0);
}

TEST_F(V1, DoesNotDependOnHeading) {
  write(random_tables(13, true));
  const auto a = with_wheel("table: tables.h5"), b = with_wheel("table: tables.h5");
  Roll straight, turned;
  turned.yaw = 2.1;
  turned.start = {3, -5, 0};
  const Mat3 R = Eigen::AngleAxisd(turned.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (int k = 0; k < 200; ++k) {
    const double t = 1e-3 * k;
    const Vec3 f = step_one(*a, t, 1e-3, straight.between(t, t + 1e-3)).impulse,
               g = step_one(*b, t, 1e-3, turned.between(t, t + 1e-3)).impulse;
    ASSERT_LT((R * f - g).norm(), 1e-9);
  }
}

/// A host as Bullet: weight, then motion, then the soil's impulse; it tells what it knows of the hub.
struct Host {
  double mass = 0.55, vx = 0.014, w = 0.2, dt = 7e-4;
  Vec3 p{0, 0, kRadius};
  double vz = 0, t = 0, angle = 0;
  BodyResult advance(Terrain& terrain) {
    vz -= 9.81 * dt;
    const auto pose = [&] { return Pose{p, Quat(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()))}; };
    BodyMotion m;
    m.X_WB_begin = pose();
    p += dt * Vec3(vx, 0, vz);
    angle += w * dt;
    m.X_WB_end = pose();
    m.V_WB_end = {{vx, 0, vz}, {0, w, 0}};
    m.hub = HubDynamics{mass, Mat3::Identity(), {{0, 0, -9.81 * mass}, Vec3::Zero()}};
    const BodyResult r = step_one(terrain, t, dt, m);
    vz += r.impulse.z() / mass;
    t += dt;
    return r;
  }
};

TEST_F(V1, AWheelUnderAHostRestsWhereQuadratureSays) {
  // Pressure k depth normal to the rim, damped by vz. Forces of the arc from the rear end (0.5 mm deep points) to the front.
  const double k = 1e6;
  write(bekker_tables(k, 0.05, true));
  for (const double dt : {7e-4, 2e-3}) {  // one and three inner steps
    const auto terrain = with_wheel("table: tables.h5, outside: nearest, dead_band: 0, spacing: 0.5 mm");
    Host host;
    host.dt = dt;
    double sinkage = 0, load = 0;
    int n = 0;
    while (host.t < 8) {
      const BodyResult r = host.advance(*terrain);
      if (host.t < 4) continue;
      sinkage += r.report.sinkage;
      load += r.report.normal_force;
      ++n;
    }
    sinkage /= n;
    load /= n;
    const double front = std::acos(1 - sinkage / kRadius), rear = -std::acos(1 - 0.0005 / kRadius);
    const double carried = boost::math::quadrature::gauss_kronrod<double, 31>::integrate(
        [&](double a) { return k * (sinkage - kRadius + kRadius * std::cos(a)) * std::cos(a) * kRadius * kWidth; },
        rear, front);
    EXPECT_NEAR(load, 0.55 * 9.81, 0.01 * 0.55 * 9.81) << dt;
    EXPECT_NEAR(carried, 0.55 * 9.81, 0.02 * 0.55 * 9.81) << dt;
  }
}

TEST_F(V1, TheDeadBandStopsTheWheelAndTheLedgerSaysWhatThatTook) {
  write(bekker_tables(1e6, 0.05, true));
  const auto terrain = with_wheel("table: tables.h5, outside: nearest");
  Host host;
  double last = 0;
  int stopped = 0;
  for (int k = 0; k < 4000; ++k) {
    host.advance(*terrain);
    if (k > 2000 && host.p.z() == last) ++stopped;
    last = host.p.z();
  }
  EXPECT_GT(stopped, 1500);
  const EnergyLedger& e = terrain->energy();
  EXPECT_NEAR(e.residual(), 0, 1e-9 * e.gross);
}

TEST_F(V1, SavedLoadedContinuedIsBitEqualForAnyThreads) {
  write(random_tables(14, true));
  const auto run = [&](int threads, bool interrupted) {
    auto t = with_wheel("table: tables.h5", flat_ground(), 3);
    t->set_threads(threads);
    for (int k = 0; k < 150; ++k) {
      if (interrupted && k == 70) {
        State s;
        t->traverse(s);
        auto other = with_wheel("table: tables.h5", flat_ground(), 3);
        s.rewind(State::Mode::load);
        other->traverse(s);
        s.finish();
        t = std::move(other);
        t->set_threads(threads);
      }
      std::vector<BodyMotion> m;
      for (int i = 0; i < 3; ++i) {
        Roll roll;
        roll.yaw = 0.4 * i;
        roll.vx = 0.01 + 0.01 * i;
        roll.start = {1.0 * i, 0, 0};
        m.push_back(roll.between(1e-3 * k, 1e-3 * (k + 1)));
      }
      std::vector<BodyResult> r(3);
      t->step(1e-3 * k, 1e-3, m, r);
    }
    State s;
    t->traverse(s);
    return s.hash_text();
  };
  const std::string once = run(1, false);
  EXPECT_EQ(run(2, false), once);
  EXPECT_EQ(run(4, true), once);
}

TEST_F(V1, SurfaceShowsTheRut) {
  write(bekker_tables(1e6, 0.05, true));
  const auto terrain = with_wheel("table: tables.h5");
  Roll roll;
  roll.vz = 0;
  roll.depth = 0.008;
  for (int k = 0; k < 8000; ++k) step_one(*terrain, 1e-3 * k, 1e-3, roll.between(1e-3 * k, 1e-3 * (k + 1)));
  // 160 mm on: the soil behind lies where the rim passed, less the 0.5 mm that points may be in it.
  EXPECT_NEAR(terrain->surface(0.06, 0).height, -0.0075, 2e-4);
  EXPECT_EQ(terrain->surface(0.06, 0.02).height, 0);
  EXPECT_EQ(terrain->surface(0.24, 0).height, 0);
}

TEST_F(V1, RefusesByNameWhatTheTablesAreNotMadeFor) {
  write(bekker_tables(1e6, 0.05, true));
  std::string errors;
  const auto refused = [&](Terrain& t, const BodySpec& body) {
    try {
      t.add_body(body);
    } catch (const TerrainError& e) {
      return std::string(e.what());
    }
    return std::string("taken");
  };
  const auto t = make("table: tables.h5", &errors);
  EXPECT_EQ(errors, "");
  EXPECT_EQ(
      refused(*t, {"left", wheel(0.08), {}}),
      "sdem.v1 cannot carry body 'left': its radius is 0.08 m, and the tables are of a wheel of 0.065 m ('wheel')");
  EXPECT_NE(refused(*make(""), {"left", wheel(), {}}).find("it has no tables; name a file"), std::string::npos);

  std::string other = kSoil;
  other.replace(other.find("0.86"), 4, "0.60");
  make("table: tables.h5", &errors, flat_ground(), other);
  EXPECT_NE(
      errors.find("options.yaml:1:18: options.table: is of another soil than 'grains of Table 5.3' (tables | soil "
                  "file): pair_friction 0.85999999999999999 | pair_friction 0.59999999999999998"),
      std::string::npos)
      << errors;
  make("table: tables.h5, other_soil: accept", &errors, flat_ground(), other);
  EXPECT_EQ(errors, "");
  make("table: tables.h5", &errors, flat_ground(), "soil: none\nsource: none\n");
  EXPECT_NE(errors.find("has no section 'dem:'"), std::string::npos) << errors;
  make("table: tabels.h5", &errors);
  EXPECT_NE(errors.find("tabels.h5"), std::string::npos) << errors;
  make("table: tables.h5, dead_bnad: 0", &errors);
  EXPECT_NE(errors.find("did you mean 'dead_band'"), std::string::npos) << errors;

  const auto driven = with_wheel("table: tables.h5");
  Roll fast;
  fast.vx = 0.05;
  try {
    step_one(*driven, 0, 1e-3, fast.between(0, 1e-3));
    FAIL();
  } catch (const TerrainError& e) {
    EXPECT_NE(std::string(e.what()).find("sdem.v1: wheel 'wheel0' at t = 0.000000 s: the wheel's velocity lies outside "
                                         "the tables: vx = 0.05 m/s, tables hold 0 to 0.035"),
              std::string::npos)
        << e.what();
  }
  const auto loose = with_wheel("table: tables.h5, outside: nearest");
  step_one(*loose, 0, 1e-3, fast.between(0, 1e-3));
  EXPECT_GT(loose->field("outside", 0, 0), 0);
}

}  // namespace
}  // namespace grouser::test
