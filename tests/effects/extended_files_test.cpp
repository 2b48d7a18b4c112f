// What grouser diagnose leaves: the rig file repeats the wheel on the extended model.
#include <gmock/gmock.h>

#include "grouser/bekker/effect_wheel.h"
#include "grouser/diagnosis/extended_file.h"
#include "grouser/vehicle/rig.h"
#include "scenarios/support.h"

namespace grouser::diagnosis {
namespace {

using testing::HasSubstr;
using vehicle::test::Folder;

struct Found {
  const char* id;
  double shown;  ///< as a person reads it
  const char* unit;
};

Diagnosis diagnosis(const std::vector<Found>& found, int pass) {
  Diagnosis d;
  d.verdict = "named";
  d.sentence = "A \"quoted\" sentence: 30 % too high";
  const auto value = [&](const char* name, double v) { d.extended.parameters[name] = {v, 0.1 * v, 0.5, ""}; };
  value("k", 300e3), value("n", 1.2), value("c", 200), value("phi", 0.58), value("K", 4e-3), value("a0", 0.2),
      value("a1", 0.3);
  for (const Found& f : found)
    d.parameters[f.id] = {f.shown, 0.1 * f.shown, 0.9 * f.shown, 1.1 * f.shown, f.unit, false};
  for (const double slip : {-0.2, 0.3})
    for (const double load : {80.0}) {
      Run r;
      r.slip = slip, r.load = load, r.omega = 0.5, r.pass = pass;
      d.runs.push_back(r);
    }
  Run locked;
  locked.slip = -1, locked.load = 80;
  d.runs.push_back(locked);
  return d;
}

DiagnosisCase given() {
  DiagnosisCase c;
  c.file = "wheel_case.yaml";
  c.model = "bekker.steady";
  c.wheel = {0.13, 0.16, 0.16, {}};
  return c;
}

class ExtendedFiles : public testing::TestWithParam<int> {};

const std::vector<std::vector<Found>>& found() {
  static const std::vector<std::vector<Found>> all{{{"slip_sinkage_exponent", 0.77, "1"}},
                                                   {{"hard_pan", 0.15, "m"}, {"bulldozing", 1.2, "1"}},
                                                   {{"repetitive_loading", 1.5, "1"}, {"slip_digging", 0.002, "m"}},
                                                   {{"flexible_wheel", 0.1, "1"}, {"torque_offset", 0.3, "N m"}},
                                                   {}};
  return all;
}

// The rig integrates the wheel in Bullet; the expected values are the quasi-static equilibrium of effect_wheel.h, with other pieces and
// another rule. Within 0.1 % of the load (the average of a wheel that still settles), torque of load times radius, sinkage 1 %.
TEST_P(ExtendedFiles, RepeatTheWheelInTheRig) {
  const Folder f;
  const auto& list = found()[static_cast<std::size_t>(GetParam())];
  const Diagnosis d = diagnosis(list, 2);
  for (const ExtendedFile& file : extended_files(d, given())) f.write(file.name, file.text);
  vehicle::RigOptions options;
  options.out = f.path() / "out";
  const vehicle::RigSummary s = vehicle::run_rig(f.path() / "extended.yaml", all_models(), options);
  ASSERT_EQ(s.rows.size(), 2U);
  for (const vehicle::RigRow& row : s.rows) {
    bekker::WheelState<double> q{300e3, 1.2, 200, 0.58, 4e-3, 0.2, 0.3, row.slip_symmetric, 80, bekker::no_effects(),
                                 0};
    for (const Found& e : list) {
      const auto id = bekker::effect_of(e.id);
      if (!id) continue;
      const auto i = static_cast<std::size_t>(*id);
      q.effect[i] = bekker::effect_table()[i].inverse ? 1 / e.shown : e.shown;
      q.active |= 1U << i;
    }
    double theta = 0;
    bekker::WheelAnswer<double> a{};
    ASSERT_EQ(bekker::effect_equilibrium(given().wheel, {0.5 * 0.13, 2, 0}, q, 0, theta, a), bekker::ForceStatus::ok);
    EXPECT_NEAR(row.drawbar_pull.mean, a.drawbar, 0.08);
    EXPECT_NEAR(row.driving_torque.mean, a.torque, 0.08 * 0.13);
    EXPECT_NEAR(row.sinkage.mean, a.sinkage, 0.01 * a.sinkage);
  }
}
INSTANTIATE_TEST_SUITE_P(Each, ExtendedFiles, testing::Range(0, 5));

TEST(ExtendedFileTexts, KeepUncertaintyAsSourceAndMeasurementOutOfThePhysics) {
  const auto files = extended_files(diagnosis({{"hard_pan", 0.2, "m"}, {"torque_offset", 0.3, "N m"}}, 1), given());
  ASSERT_EQ(files.size(), 5U);
  const std::string& rig = files[0].text;
  EXPECT_EQ(files[0].name, "extended.yaml");
  EXPECT_THAT(rig, HasSubstr("hard_pan: {value: 5 1/m, source: \"0.2 +- 0.02 m, 90 % in 0.18 to 0.22 m"));
  EXPECT_THAT(rig, HasSubstr("# of the rig, not of the soil, and so not simulated: torque_offset 0.3 +- 0.03 N m"));
  EXPECT_THAT(rig, HasSubstr("# 1 runs without rolling or without travel are left out"));
  for (const ExtendedFile& f : files)
    if (f.name != "extended.yaml" && f.name != "extended_case.yaml") {
      EXPECT_THAT(f.text, testing::Not(HasSubstr("torque_offset"))) << f.name;
    }
}

TEST(ExtendedFileTexts, AModelWithoutAddedPhysicsHasNoFileOfEffects) {
  const auto files = extended_files(diagnosis({}, 1), given());
  for (const ExtendedFile& f : files) {
    EXPECT_NE(f.name, "extended_effects.yaml");
    EXPECT_THAT(f.text, testing::Not(HasSubstr("effects:")));
  }
}

TEST(ExtendedFileTexts, RepeatsWithNearlyTheSameLoadAndSlipAreOneConditionOfTheRig) {
  Diagnosis d = diagnosis({}, 1);
  d.runs.clear();
  for (const double slip : {0.296, 0.3, 0.304, 0.5})
    for (const double load : {78.0, 80.0, 82.0, 160.0}) {
      diagnosis::Run r;
      r.slip = slip, r.load = load, r.omega = 0.5;
      d.runs.push_back(r);
    }
  const std::string rig = extended_files(d, given())[0].text;
  EXPECT_THAT(rig, HasSubstr("load: [80 N, 160 N]"));
  EXPECT_THAT(rig, HasSubstr("slips: [0.3, 0.5]"));
}

}  // namespace
}  // namespace grouser::diagnosis
