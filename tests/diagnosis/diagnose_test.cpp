// The whole way from a case and a table to a verdict, on small series; and what is said of tables with mistakes.
#include "grouser/diagnosis/diagnose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "grouser/bekker/forces.h"
#include "grouser/terrain/config.h"

namespace grouser::diagnosis {
namespace {

namespace fs = std::filesystem;

constexpr const char* case_text = R"(model: bekker.steady
wheel: {radius: 0.13 m, width: 0.16 m, mass: 3.2 kg}
soil:
  pressure: {law: k_ref, reference_width: 0.16 m, k: {value: 254.1 kPa, ln_sd: 0.30}, n: {value: 1.387, sd: 0.14}}
  shear: {type: A, c: {value: 139.28 Pa, sd: 415 Pa}, phi: {value: 0.606 rad, sd: 0.0502 rad}, K: {value: 0.5151 mm, ln_sd: 1.0}}
  angles: {a0: {value: 0.18, sd: 0.2}, a1: {value: 0.32, sd: 0.2}}
  density: {value: 1600 kg/m^3}
effects: all
)";

class DiagnoseTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("grouser_diagnose_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "case.yaml") << case_text;
  }
  void TearDown() override { fs::remove_all(folder_); }
  DiagnosisCase given() { return read_case(folder_ / "case.yaml"); }
  RunTable table(const std::string& text) {
    std::ofstream(folder_ / "data.csv") << text;
    return read_runs(folder_ / "data.csv", given());
  }
  std::string refusal(const std::string& text) {
    try {
      table(text);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path folder_;
};

/// Runs by the library's own solver, not by the one with effects; `change` alters what the rig shows.
template <class Change>
std::string series(Change change, int seed) {
  BekkerSoil b;
  b.pressure = {PressureSinkage::Law::k_b, 0, 0, 280e3, 1.42, 0.16};
  b.shear.cohesion = 250, b.shear.friction_angle = 0.59, b.shear.K = 0.7e-3;
  b.angles = {0.25, 0.3, 0, 0};
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> noise;
  std::string out =
      "slip,slip_definition,slip_radius_m,load_N,omega_rad_s,pass,order,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,"
      "torque_sd_Nm,sinkage_sd_m\n";
  int order = 0;
  for (const double omega : {0.1, 0.9})
    for (const double slip : {-0.5, -0.1, 0.1, 0.3, 0.6})
      for (const double load : {60.0, 140.0, 225.0}) {
        bekker::LoadCase c;
        c.wheel = {0.13, 0.16, 0, 0};
        c.soil = bekker::SoilLaw::of(b, 0.16);
        c.load = load, c.slip = slip;
        const bekker::Solution s = bekker::solve(c, bekker::Method::nonlinear, 1e-8);
        std::array<double, 3> y{s.wrench.Fx, -s.wrench.My, s.sinkage};
        change(y, slip, load, omega);
        char line[240];
        std::snprintf(line, sizeof line, "%g,larger,0.13,%g,%g,1,%d,%.6f,%.7f,%.9f,2,0.2,0.0015\n", slip, load, omega,
                      (++order * 7) % 31, y[0] + 2 * noise(random), y[1] + 0.2 * noise(random),
                      y[2] + 0.0015 * noise(random));
        out += line;
      }
  return out;
}

TEST_F(DiagnoseTest, RunsOfThePlainModelAreAdequate) {
  const Diagnosis d = diagnose(given(), table(series([](auto&, double, double, double) {}, 3)), {});
  EXPECT_EQ(d.verdict, "adequate") << d.sentence;
  EXPECT_GT(d.posterior.at("none"), 0.3);
}

// 1.2 N m per rad/s at 0.1 and 0.9 rad/s: eight noise sd between the speeds, and no soil value depends on speed.
TEST_F(DiagnoseTest, AFrictionThatGrowsWithSpeedIsNamed) {
  const Diagnosis d =
      diagnose(given(), table(series([](auto& y, double, double, double w) { y[1] += 1.2 * w; }, 4)), {});
  EXPECT_EQ(d.verdict, "named") << d.sentence;
  EXPECT_EQ(d.cause, "torque_viscous");
  ASSERT_EQ(d.parameters.count("torque_viscous"), 1U);
  const Interval& i = d.parameters.at("torque_viscous");
  EXPECT_NEAR(i.value, 1.2, 3 * i.sd);
  EXPECT_EQ(i.unit, "N m s/rad");
}

TEST_F(DiagnoseTest, TheGainIsMeasuredOnRunsNeverUsed) {
  const RunTable t = table(series([](auto& y, double, double, double w) { y[1] += 1.2 * w; }, 5));
  const Diagnosis d = diagnose(given(), t, {"load_N=140"});
  ASSERT_TRUE(d.gain.has_value());
  EXPECT_EQ(d.gain->runs, 10);
  EXPECT_EQ(d.runs.size(), 20U);
  EXPECT_LT(d.gain->high, 1) << d.sentence;
}

TEST_F(DiagnoseTest, TheSameTableGivesTheSameBits) {
  const RunTable t = table(series([](auto& y, double, double, double) { y[0] -= 6; }, 6));
  const Diagnosis a = diagnose(given(), t, {}), b = diagnose(given(), t, {});
  EXPECT_EQ(a.verdict, b.verdict);
  for (const auto& [id, p] : a.posterior) EXPECT_EQ(p, b.posterior.at(id)) << id;
}

TEST_F(DiagnoseTest, OneRunIsUndecidable) {
  const Diagnosis d = diagnose(given(), table("slip,slip_radius_m,load_N,drawbar_N\n0.3,0.13,115,20\n"), {});
  EXPECT_EQ(d.verdict, "undecidable");
}

TEST_F(DiagnoseTest, TheExtendedCaseIsReadAgainAsACase) {
  const Diagnosis d = diagnose(given(), table(series([](auto&, double, double, double) {}, 3)), {});
  const std::string text = extended_case_text(d, given());
  EXPECT_THAT(text, ::testing::HasSubstr("reference_width: 0.16 m"));
  std::ofstream(folder_ / "extended.yaml") << text;
  EXPECT_NO_THROW(read_case(folder_ / "extended.yaml"));
}

TEST_F(DiagnoseTest, MistakesOfATableAreNamedWithPlaceAndRemedy) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal("slip,slip_radius_m,load,drawbar_N\n0.1,0.13,115,3\n"),
              AllOf(HasSubstr("data.csv:1:20"), HasSubstr("has no unit"), HasSubstr("load_N")));
  EXPECT_THAT(refusal("slip,load_N,drawbar_N\n0.1,115,3\n"),
              AllOf(HasSubstr("slip_radius_m"), HasSubstr("two meanings")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n0.1,0.13,115,nan\n"),
              AllOf(HasSubstr("data.csv:2:14"), HasSubstr("not a finite number"), HasSubstr("leave the cell empty")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n30,0.13,115,3\n"),
              AllOf(HasSubstr("outside -1..1"), HasSubstr("fraction")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_kg\n0.1,0.13,115,3\n"),
              AllOf(HasSubstr("data.csv:1:"), HasSubstr("not a unit of drawbar")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N\n0.1,0.13,115\n"), HasSubstr("nothing was measured"));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,batch,replicate,drawbar_N\n0.1,0.13,115,a,1,3\n0.1,0.13,115,a,1,3\n"),
              AllOf(HasSubstr("data.csv:3:"), HasSubstr("already in line 2")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n"), HasSubstr("no runs below the header"));
}

TEST_F(DiagnoseTest, MillimetresAreAcceptedByTheirName) {
  const RunTable t = table("slip,slip_radius_m,load_N,sinkage_mm\n0.1,0.13,115,12.5\n");
  EXPECT_DOUBLE_EQ(t.runs[0].value[2], 0.0125);
}

// s = (R w - v)/(R w) by R = 0.14 m of lugs: v/w = 0.112 m, by r = 0.13 m s = 1 - 0.112/0.13.
TEST_F(DiagnoseTest, SlipIsCarriedToTheWheelsOwnRadius) {
  const RunTable t = table("slip,slip_definition,slip_radius_m,load_N,drawbar_N\n0.2,rim,0.14,115,3\n");
  EXPECT_NEAR(t.runs[0].slip, 1 - 0.112 / 0.13, 1e-12);
}

TEST_F(DiagnoseTest, WithholdingByAnUnknownColumnIsRefused) {
  const RunTable t = table("slip,slip_radius_m,load_N,drawbar_N\n0.3,0.13,115,20\n");
  EXPECT_THROW(diagnose(given(), t, {"laod_N=115"}), ConfigError);
  EXPECT_THROW(diagnose(given(), t, {"load_N=90"}), ConfigError);
}

}  // namespace
}  // namespace grouser::diagnosis
