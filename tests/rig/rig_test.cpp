#include "grouser/vehicle/rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "grouser/bekker/wheel_forces.h"
#include "grouser/models.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"

using namespace grouser;
using namespace grouser::vehicle;
namespace fs = std::filesystem;

namespace {

const std::string examples = GROUSER_SOURCE_DIR "/examples/";

/// A folder of the test's own and a rig file in it: MIT wheel on Mojave Martian Simulant, 115 N, 17 deg/s, plus `more`.
struct Case {
  fs::path folder, file;
  explicit Case(const std::string& more, const std::string& load = "load: 115 N\nmoving_mass: 11.7 kg\n") {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::path(GROUSER_BINARY_DIR) / "rig_test" / info->name();
    fs::remove_all(folder);
    fs::create_directories(folder);
    file = folder / "rig.yaml";
    std::ofstream(file) << "rig: test\nwheel: " << examples
                        << "wheels/mit_wheel.yaml\nterrain: {model: bekker.steady, soil: " << examples
                        << "soils/mojave_martian_simulant.yaml}\n"
                        << load << more;
  }
  RigSummary run(const std::string& out = "out", int threads = 1, const std::string& integrator = "fixed") const {
    RigOptions o;
    o.out = folder / out;
    o.threads = threads;
    o.integrator = integrator;
    return run_rig(file, all_models(), o);
  }
};

bekker::Equilibrium equilibrium(double load, double kappa) {
  const Soil soil = load_soil_file(examples + "soils/mojave_martian_simulant.yaml");
  const bekker::SoilLaw law = bekker::SoilLaw::of(*soil.bekker, 0.16);
  return bekker::steady_equilibrium({0.13, 0.16}, law, load, bekker::shear_state(kappa), {40, 0});
}

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

std::vector<double> channel(const fs::path& folder, const std::string& name) {
  return RunFile(folder / "run.h5").read(name);
}

// Truth: the pure function that solves Fz(theta_f) = load, without time, Bullet or adapter. The rig must arrive there on its own.
TEST(Rig, SteadyValuesAreThoseOfTheEquilibriumFunction) {
  // The model forgets how the wheel was set down over contact lengths (50 mm) of travel, whatever the time: hence a distance.
  const Case c(
      "angular_speed: 17 deg/s\nslips: [-0.7, -0.1, 0, 0.1, 0.3, 0.7]\nslip_definition: rim\ndistance: 0.7 "
      "m\naverage_over: 20 %\n");
  const auto s = c.run("out", 2);
  ASSERT_EQ(s.rows.size(), 6u);
  for (const RigRow& r : s.rows) {
    const auto e = equilibrium(115, 1 - r.spec.slip);
    ASSERT_EQ(e.status, bekker::Equilibrium::Status::ok);
    SCOPED_TRACE(r.spec.slip);
    EXPECT_TRUE(r.stationary) << r.note;
    EXPECT_NEAR(r.slip_rim, r.spec.slip, 1e-9);
    // 0.1 % of the load (times the radius): the model's quadrature of 10 points against 40 here, and what is left of the transient.
    EXPECT_NEAR(r.drawbar_pull.mean, e.forces.Fx, 1e-3 * 115);
    EXPECT_NEAR(r.driving_torque.mean, -e.forces.My, 1e-3 * 115 * 0.13);
    EXPECT_NEAR(r.sinkage.mean, e.sinkage, 1e-5);
    EXPECT_NEAR(r.sinkage_profile.mean, e.sinkage, 1e-5) << "flat ground, no lugs: both sinkages are the same";
    EXPECT_NEAR(r.normal_force.mean, 115, 1e-4 * 115) << "load balance";
    EXPECT_NEAR(r.side_force.mean, 0, 1e-9);
  }
}

TEST(Rig, BrakingCasesOfBothDefinitionsAreTheirConversions) {
  const Case c("angular_speed: 17 deg/s\nslips: [-0.5, 0.3]\nslip_definition: [rim, symmetric]\nduration: 0.5 s\n");
  const auto s = c.run();
  ASSERT_EQ(s.rows.size(), 4u);
  EXPECT_NEAR(s.rows[0].slip_symmetric, -1.0 / 3, 1e-9);
  EXPECT_NEAR(s.rows[2].slip_symmetric, -0.5, 1e-9);
  EXPECT_EQ(s.rows[1].drawbar_pull.mean, s.rows[3].drawbar_pull.mean);
  EXPECT_EQ(s.rows[0].spec.group, "115 N, rim");
}

// The fixed step (1 ms, Bullet, adapter) against CVODE on the same force law, over the whole run with its ramp.
TEST(Rig, FixedStepFollowsTheIntegratedReference) {
  const Case c(
      "angular_speed: 17 deg/s\nslips: [-0.3, 0.3]\nslip_definition: rim\nduration: 1.5 s\nsettle: 0.2 s\nramp: 0.5 s\n"
      "output: {rate: 200 Hz}\n");
  const auto fixed = c.run("fixed"), exact = c.run("cvode", 1, "cvode");
  for (std::size_t i = 0; i < 2; ++i) {
    SCOPED_TRACE(fixed.rows[i].spec.slip);
    EXPECT_NEAR(fixed.rows[i].drawbar_pull.mean, exact.rows[i].drawbar_pull.mean, 2e-3 * 115);
    EXPECT_NEAR(fixed.rows[i].sinkage.mean, exact.rows[i].sinkage.mean, 1e-5);
    const fs::path name = "case_00" + std::to_string(i);
    for (const auto& [channel_name, allowed] : {std::pair{"wheel.sinkage", 1e-4}, {"wheel.drawbar_pull", 0.02 * 115}}) {
      const auto a = channel(c.folder / "fixed" / name, channel_name),
                 b = channel(c.folder / "cvode" / name, channel_name);
      ASSERT_EQ(a.size(), b.size());
      double squares = 0;
      for (std::size_t k = 0; k < a.size(); ++k) squares += (a[k] - b[k]) * (a[k] - b[k]);
      const double rms = std::sqrt(squares / static_cast<double>(a.size()));
      std::printf("%s at slip %g: fixed against cvode rms %.3g\n", channel_name, fixed.rows[i].spec.slip, rms);
      EXPECT_LT(rms, allowed) << channel_name;
    }
  }
}

// Two measured slips, one on a case and one half-way between two, one outside: the table's figures worked out by hand from the rows.
TEST(Rig, ErrorsAreThoseBetweenTheRowsAndTheMeasuredTable) {
  const Case c(
      "angular_speed: 17 deg/s\nslips: [0.1, 0.3]\nslip_definition: rim\ndistance: 0.1 m\nmeasured: {file: "
      "measured.csv, "
      "source: made up, slip: slip, drawbar_pull: {column: pull_N, unit: N, error: pull_error_N}, "
      "sinkage: {column: depth_mm, unit: mm}}\n");
  std::ofstream(c.folder / "measured.csv")
      << "slip,pull_N,pull_error_N,depth_mm\n0.1,30,1,8\n0.2,50,2,11\n0.6,90,3,15\n";
  const auto s = c.run();
  ASSERT_EQ(s.rows.size(), 2u);
  ASSERT_EQ(s.errors.size(), 2u);
  const auto expect = [&](const RigErrorRow& e, double a, double b, double ma, double mb) {
    const double d0 = a - ma, d1 = (a + b) / 2 - mb;
    EXPECT_EQ(e.points, 2) << "slip 0.6 lies outside the sweep";
    EXPECT_NEAR(e.rmse, std::sqrt((d0 * d0 + d1 * d1) / 2), 1e-9);
    EXPECT_NEAR(e.bias, (d0 + d1) / 2, 1e-9);
    EXPECT_NEAR(e.measured_range, mb - ma, 1e-12);
  };
  const RigRow &first = s.rows[0], &second = s.rows[1];
  expect(s.errors[0], first.drawbar_pull.mean, second.drawbar_pull.mean, 30, 50);
  EXPECT_NEAR(s.errors[0].reading_error, 1.5, 1e-12);
  expect(s.errors[1], 1e3 * first.sinkage.mean, 1e3 * second.sinkage.mean, 8, 11);
  EXPECT_EQ(s.errors[1].unit, "mm");
  EXPECT_TRUE(std::isnan(s.errors[1].reading_error));
  const std::string written = content(c.folder / "out" / "errors.csv");
  EXPECT_EQ(written.rfind("group,channel,unit,points,rmse,bias,measured_range,rmse_over_range,reading_error\n", 0), 0u);
  EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), 3);
}

TEST(Rig, TrimmedStartDoesNotMove) {
  const Case c(
      "angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 0.5 s\nramp: 0.2 s\noutput: {rate: 1000 "
      "Hz}\n");
  const auto s = c.run();
  EXPECT_LT(std::abs(s.rows[0].touch_down_overshoot), 1e-6);
  const auto p = channel(c.folder / "out" / "case_000", "wheel.position");
  double low = 1, high = 0;
  for (std::size_t i = 0; i < 450; ++i) low = std::min(low, p[3 * i + 2]), high = std::max(high, p[3 * i + 2]);
  EXPECT_LT(high - low, 1e-9) << "metres, over the 0.5 s of settling";
}

// Lowered at 10 mm/s the wheel is let go at the first step that carries the load: past it by at most one step's travel (10 um).
TEST(Rig, LoweringTouchesDownWithoutABounce) {
  const Case c(
      "angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 0.5 s\ntouch_down: {by: lowering}\n");
  for (const char* integrator : {"fixed", "cvode"}) {
    const auto s = c.run(integrator, 1, integrator);
    EXPECT_LT(s.rows[0].touch_down_overshoot, 0.01) << integrator;
    EXPECT_GT(s.rows[0].touch_down_overshoot, -0.001) << integrator;
  }
}

TEST(Rig, SweepIsTheSameForOneAndTwoThreads) {
  const Case c("angular_speed: 17 deg/s\nslips: [-0.3, 0, 0.3, 0.6]\nslip_definition: rim\nduration: 0.5 s\n");
  const auto one = c.run("one", 1), two = c.run("two", 2);
  for (std::size_t i = 0; i < one.rows.size(); ++i) EXPECT_EQ(one.rows[i].end_state_hash, two.rows[i].end_state_hash);
  EXPECT_EQ(content(c.folder / "one" / "sweep.csv"), content(c.folder / "two" / "sweep.csv"));
}

// What the soil asks at a held slip, given as motor torque, must give back that slip. At zero slip, where the torque changes quickly
// with slip (8.5 to 9.5 N m up to slip 0.1); above, the curve is too flat to tell.
TEST(Rig, TorqueOfASlipGivesBackTheSlip) {
  const Case held("travel_speed: 100 mm/s\nslips: [0]\nslip_definition: rim\ndistance: 0.7 m\naverage_over: 20 %\n");
  const auto a = held.run("held");
  std::ostringstream more;
  more.precision(17);
  more << "travel_speed: 100 mm/s\ntorque: " << a.rows[0].driving_torque.mean
       << " N m\ndistance: 0.7 m\naverage_over: 20 %\nspin_inertia: 0.05 kg m^2\n";
  const Case driven(more.str());
  for (const char* integrator : {"fixed", "cvode"}) {
    const auto b = driven.run(integrator, 1, integrator);
    EXPECT_NEAR(b.rows[0].slip_symmetric, 0, 1e-3) << integrator;
    EXPECT_NEAR(b.rows[0].driving_torque.mean, a.rows[0].driving_torque.mean, 0.01) << integrator;
  }
}

TEST(Rig, SideForceMirrorsWithTheSlipAngle) {
  const std::string common = "angular_speed: 17 deg/s\nslips: [0.3]\nslip_definition: rim\nduration: 2 s\nslip_angle: ";
  const Case left(common + "10 deg\n");
  const auto a = left.run("left");
  const Case right(common + "-10 deg\n");
  const auto b = right.run("right");
  EXPECT_LT(a.rows[0].side_force.mean, -5) << "moving to the left, the soil pushes to the right";
  EXPECT_NEAR(a.rows[0].side_force.mean, -b.rows[0].side_force.mean, 1e-6);
  EXPECT_NEAR(a.rows[0].drawbar_pull.mean, b.rows[0].drawbar_pull.mean, 1e-6);
}

// The steady model has no soil transport: a wheel that turns on the spot sinks to the sinkage of full slip and stays there; it does not
// dig on as in the experiment. Without travel the contact stays as it was set down, symmetric: half of it slips by +1, half mirrored.
TEST(Rig, DiggingWheelSinksToTheSinkageOfFullSlipAndStaysThere) {
  const Case c("mode: dig\nangular_speed: 0.3 rad/s\nsettle: 0.5 s\nramp: 0.5 s\nduration: 14 s\naverage_over: 20 %\n");
  const auto s = c.run();
  const auto z = channel(c.folder / "out" / "case_000", "wheel.sinkage");
  // The soil is a spring without damping, so the wheel rings where the ramp begins: 0.1 mm is granted to that.
  double deepest = 0;
  for (const double now : z) {
    EXPECT_GT(now, deepest - 1e-4);
    deepest = std::max(deepest, now);
  }
  EXPECT_GT(z.back(), z.front() + 5e-4);
  EXPECT_TRUE(s.rows[0].stationary) << s.rows[0].note;

  const Soil soil = load_soil_file(examples + "soils/mojave_martian_simulant.yaml");
  const bekker::SoilLaw law = bekker::SoilLaw::of(*soil.bekker, 0.16);
  // Fz at full slip from the stresses alone, trapezoidal rule: r b integral (sigma cos + tau sin), slip 1 in theta_m of both halves.
  auto normal_force = [&](double theta_f, double e) {
    const bekker::ContactRange range = bekker::contact_range(law, theta_f, 1.0);
    constexpr int n = 4000;
    double sum = 0;
    for (int i = 1; i < n; ++i) {
      const double theta = range.theta_r + (theta_f - range.theta_r) * i / n;
      const bekker::Stress p = bekker::stress_at({0.13, 0.16}, law, range, {e, 0}, theta);
      sum += p.sigma * std::cos(theta) + p.tau_t * std::sin(theta);
    }
    return 0.13 * 0.16 * sum * (theta_f - range.theta_r) / n;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double theta = 0.5 * (low + high);
    (0.5 * (normal_force(theta, 1) + normal_force(theta, -1)) < 115 ? low : high) = theta;
  }
  EXPECT_NEAR(s.rows[0].sinkage.mean, 0.13 * (1 - std::cos(low)), 3e-5);
}

// ---- messages

void expect_error(const std::string& more, const std::string& wanted, const std::string& load = "load: 115 N\n") {
  const Case c(more, load);
  try {
    check_rig(c.file, all_models());
    FAIL() << "no error";
  } catch (const ConfigError& e) {
    std::string text = e.what();
    for (std::size_t at; (at = text.find(c.file.string())) != std::string::npos;)
      text.replace(at, c.file.string().size(), "rig.yaml");
    EXPECT_EQ(text, wanted);
  }
}

TEST(RigErrors, UnknownSlipDefinition) {
  expect_error("angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: wheel\nduration: 1 s\n",
               "rig.yaml:7:18: slip_definition: 'wheel' is no slip definition; known here: rim, symmetric");
}
TEST(RigErrors, BothSpeedsHeld) {
  expect_error("angular_speed: 17 deg/s\ntravel_speed: 1 m/s\nslips: [0.1]\nslip_definition: rim\nduration: 1 s\n",
               "rig.yaml:1:1: exactly one of 'angular_speed' (for example 17 deg/s) and 'travel_speed' (for example 10 "
               "mm/s) is wanted");
}
TEST(RigErrors, LoadAndMass) {
  expect_error("angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 1 s\n",
               "rig.yaml:1:1: exactly one of 'load' (for example 115 N, the wheel's weight included) and 'mass' (for "
               "example 8.155 kg) is wanted",
               "load: 115 N\nmass: 3 kg\n");
}
TEST(RigErrors, SlipThatATurningWheelCannotHave) {
  expect_error("angular_speed: 17 deg/s\nslips: [-1.5]\nslip_definition: symmetric\nduration: 1 s\n",
               "rig.yaml:6:1: slips: -1.5 by the definition 'symmetric': a turning wheel has no slip of -1 or below by "
               "the symmetric definition; allowed is above -1 and up to 1");
}
TEST(RigErrors, MeasuredColumnThatIsNotThere) {
  const std::string table = examples + "03_single_wheel_rig/data/mit_mms_wheel/wheel_steady.csv";
  expect_error("angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 1 s\nmeasured:\n  file: " +
                   table + "\n  drawbar_pull: {column: drawbar_M, unit: N}\n",
               "rig.yaml:11:26: measured.drawbar_pull.column: the table " + table +
                   " has no column 'drawbar_M'; did you mean 'drawbar_N'?");
}
TEST(RigErrors, TypoInAKey) {
  expect_error("angular_sped: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 1 s\n",
               "rig.yaml:1:1: exactly one of 'angular_speed' (for example 17 deg/s) and 'travel_speed' (for example 10 "
               "mm/s) is wanted\n"
               "rig.yaml:5:1: unknown key 'angular_sped'; did you mean 'angular_speed'?");
}

TEST(RigErrors, CvodeRefusesATerrainThatIntegratesInside) {
  // A model that says it is not continuous: nothing else of it is used.
  class Grains final : public Terrain {
   public:
    explicit Grains(GroundPtr g) : Terrain(std::move(g)) {}
    std::string id() const override { return "grains"; }
    Capabilities capabilities() const override { return {true, true, true, false, false}; }

   private:
    void do_step(const StepContext&, std::span<const BodyMotion>, std::span<BodyResult>) override {}
    void do_traverse(State&) override {}
  };
  Registry registry = all_models();
  registry.add({"grains", "", "", "", "", [](const TerrainArgs& a) { return std::make_unique<Grains>(a.ground); }});
  const Case c(
      "angular_speed: 17 deg/s\nslips: [0.1]\nslip_definition: rim\nduration: 1 s\ntouch_down: {by: lowering}\n");
  RigOptions o;
  o.out = c.folder / "out";
  o.terrain = "grains";
  o.integrator = "cvode";
  try {
    run_rig(c.file, registry, o);
    FAIL();
  } catch (const ConfigError& e) {
    EXPECT_EQ(std::string(e.what()), c.file.string() +
                                         ": terrain 'grains' has no force law that an ODE solver can follow (it "
                                         "integrates inside); use --integrator fixed");
  }
}

}  // namespace
