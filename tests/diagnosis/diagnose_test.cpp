// The whole way from a case and a table to a verdict, on small series; and what is said of tables with mistakes.
#include <gmock/gmock.h>

#include "support.h"

namespace grouser::diagnosis {
namespace {

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
  ASSERT_TRUE(d.gain->has_interval);
  EXPECT_LT(d.gain->high, 1) << d.sentence;
  EXPECT_THAT(d.sentence, ::testing::HasSubstr("the error falls to"));
}

// What works at 0.1 and 0.9 rad/s alike: nothing hidden, so nothing may be gained.
TEST_F(DiagnoseTest, NoGainIsClaimedWhereTheIntervalHoldsOne) {
  const Diagnosis d = diagnose(given(), table(series([](auto&, double, double, double) {}, 3)), {"load_N=140"});
  ASSERT_TRUE(d.gain.has_value());
  EXPECT_THAT(d.sentence, ::testing::Not(::testing::HasSubstr("falls")));
}

// Three conditions: a bootstrap over them has no 95 %.
TEST_F(DiagnoseTest, OfFewConditionsEachIsToldAndNoInterval) {
  std::string text = series([](auto& y, double, double, double w) { y[1] += 1.2 * w; }, 5);
  const Diagnosis d = diagnose(given(), table(text), {"order=1..3"});
  ASSERT_TRUE(d.gain.has_value());
  EXPECT_EQ(d.gain->of_conditions.size(), 3U);
  EXPECT_FALSE(d.gain->has_interval);
  EXPECT_THAT(d.sentence, ::testing::HasSubstr("interval"));
  EXPECT_THAT(d.sentence, ::testing::Not(::testing::HasSubstr("falls")));
}

TEST_F(DiagnoseTest, TheSameTableGivesTheSameBits) {
  const RunTable t = table(series([](auto& y, double, double, double) { y[0] -= 6; }, 6));
  const Diagnosis a = diagnose(given(), t, {}), b = diagnose(given(), t, {});
  EXPECT_EQ(a.verdict, b.verdict);
  for (const auto& [id, p] : a.posterior) EXPECT_EQ(p, b.posterior.at(id)) << id;
}

TEST_F(DiagnoseTest, TheExtendedCaseIsReadAgainAsACase) {
  const Diagnosis d = diagnose(given(), table(series([](auto&, double, double, double) {}, 3)), {});
  const std::string text = extended_case_text(d, given());
  EXPECT_THAT(text, ::testing::HasSubstr("reference_width: 0.16 m"));
  std::ofstream(folder_ / "extended.yaml") << text;
  EXPECT_NO_THROW(read_case(folder_ / "extended.yaml"));
}

// Eight rows of one condition that disagree among themselves say nothing of the model.
TEST_F(DiagnoseTest, OneConditionIsUndecidable) {
  std::string text = "slip,slip_radius_m,load_N,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,torque_sd_Nm,sinkage_sd_m\n";
  for (int i = 0; i < 8; ++i) {
    char line[120];
    std::snprintf(line, sizeof line, "0.3,0.13,80,%g,%g,%g,1,0.1,0.0005\n", 10 + 4 * (i % 3 - 1.0), 5 + 0.4 * (i % 2),
                  0.010 + 0.002 * (i % 4));
    text += line;
  }
  EXPECT_EQ(diagnose(given(), table(text), {}).verdict, "undecidable");
}

// The stated sd is a quarter of the scatter, and four repeats of each run show that scatter: the sensor's sheet is wrong, not the model.
TEST_F(DiagnoseTest, NoiseThatRepeatsShowIsNoMisfit) {
  std::string text;
  for (int repeat = 0; repeat < 4; ++repeat) {
    std::string more = series([](auto&, double, double, double) {}, 40 + repeat);
    if (repeat > 0) more.erase(0, more.find('\n') + 1);
    text += more;
  }
  for (const auto& [from, to] : {std::pair<std::string, std::string>{",2,0.2,0.0015", ",0.5,0.05,0.000375"}})
    for (std::size_t at = text.find(from + "\n"); at != std::string::npos; at = text.find(from + "\n", at + 1))
      text.replace(at, from.size(), to);
  const Diagnosis d = diagnose(given(), table(text), {});
  EXPECT_GT(d.noise_scale[0], 2.5);
  EXPECT_EQ(d.verdict, "adequate") << d.sentence;
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
