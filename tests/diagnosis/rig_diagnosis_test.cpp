// From runs of `grouser rig` (Bullet, finer nodes and steps) to a verdict with bekker.soil_node as the nominal model.
#include <gmock/gmock.h>

#include "grouser/diagnosis/extended_file.h"
#include "rig_support.h"

namespace grouser::diagnosis {
namespace {

/// A soil within its priors that is not their mean.
std::array<double, soil_count> true_soil() { return {std::log(285e3), 1.33, 280, 0.585, std::log(0.8e-3), 0.18, 0.32}; }

class RigDiagnosisTest : public RigTest {
 protected:
  Diagnosis of(const Sweep& s, int seed) {
    const DiagnosisCase c = rolled("bekker.soil_node");
    return diagnose(c, measured(sweep(s, true_soil()), c, seed), {});
  }
  static Sweep coarse() {
    Sweep s;
    s.options = "spacing: 6.6 mm", s.time_step = "2 ms";
    return s;
  }
};

TEST_F(RigDiagnosisTest, RunsOfTheModelItselfAreAdequate) {
  const Diagnosis d = of(coarse(), 3);
  EXPECT_EQ(d.verdict, "adequate") << d.sentence;
}

TEST_F(RigDiagnosisTest, AHiddenSlipSinkageIsNamedAndItsExtendedModelRunsInTheRig) {
  Sweep s = coarse();
  s.effects = "slip_sinkage_exponent: 0.8";
  const DiagnosisCase c = rolled("bekker.soil_node");
  const Diagnosis d = diagnose(c, measured(sweep(s, true_soil()), c, 4), {});
  EXPECT_THAT(d.members, ::testing::Contains("slip_sinkage_exponent")) << d.sentence;
  ASSERT_EQ(d.parameters.count("slip_sinkage_exponent"), 1U) << d.sentence;
  const Interval& i = d.parameters.at("slip_sinkage_exponent");
  EXPECT_NEAR(i.value, 0.8, 3 * i.sd);
  for (const ExtendedFile& f : extended_files(d, c)) std::ofstream(folder_ / f.name) << f.text;
  EXPECT_NO_THROW(vehicle::check_rig(folder_ / "extended.yaml", all_models()));
  EXPECT_NO_THROW(read_case(folder_ / "extended_case.yaml", &all_models()));
}

// Soil that springs back by 30 % of its depth: an option of the model, no entry of the list. No name is right.
TEST_F(RigDiagnosisTest, WhatTheListDoesNotHaveIsNotNamed) {
  Sweep s = coarse();
  s.options += ", unloading_rebound: 0.3";
  const Diagnosis d = of(s, 5);
  EXPECT_NE(d.verdict, "named") << d.sentence;
}

}  // namespace
}  // namespace grouser::diagnosis
