// Effects in scenario and rig files: what is refused and where, what a run keeps of them.
#include <gmock/gmock.h>

#include "grouser/vehicle/rig.h"
#include "scenarios/support.h"

namespace grouser::vehicle {
namespace {

using namespace test;
using testing::HasSubstr;

const char* const rig_head = R"(rig: test
wheel: EXAMPLES/wheels/mit_wheel.yaml
load: 60 N
slips: [0.3]
slip_definition: symmetric
angular_speed: 0.5 rad/s
settle: 0.1 s
ramp: 0.2 s
distance: 0.3 m
average_over: 20 %
terrain:
  model: bekker.steady
  soil: EXAMPLES/soils/mojave_martian_simulant.yaml
)";

std::string at_examples(std::string text) {
  for (std::size_t at = 0; (at = text.find("EXAMPLES", at)) != std::string::npos;)
    text.replace(at, 8, examples.string());
  return text;
}

std::string refusal(const fs::path& file) {
  try {
    check_rig(file, all_models());
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

TEST(EffectFiles, MistakesAreNamedWithPlaceAndRemedy) {
  const Folder f;
  const auto told = [&](const std::string& effects) {
    return refusal(f.write("rig.yaml", at_examples(rig_head) + "  effects: {bekker.steady: {" + effects + "}}\n"));
  };
  EXPECT_THAT(told("slip_sinkage_exponant: 0.5"),
              testing::AllOf(HasSubstr("rig.yaml:14:"), HasSubstr("did you mean 'slip_sinkage_exponent'")));
  EXPECT_THAT(told("slip_sinkage_exponent: 2"), testing::AllOf(HasSubstr("rig.yaml:14:"), HasSubstr("1.5")));
  EXPECT_THAT(told("slip_digging: 3"), testing::AllOf(HasSubstr("rig.yaml:14:"), HasSubstr("unit")));
  EXPECT_THAT(told("hard_pan: 0.2 m"), testing::AllOf(HasSubstr("rig.yaml:14:"), HasSubstr("1/m")));
  // All of a file at once, and what the model refuses at its own line.
  EXPECT_THAT(told("lugs: 1 m, shear_rate: 0.5"), testing::AllOf(HasSubstr("lugs"), HasSubstr("shear_rate")));
  EXPECT_THAT(refusal(f.write(
                  "rig.yaml",
                  at_examples(rig_head) +
                      "  options: {bekker.steady: {method: linear}}\n  effects: {bekker.steady: {hard_pan: 5 1/m}}\n")),
              testing::AllOf(HasSubstr("rig.yaml:15:"), HasSubstr("needs 'method: nonlinear'")));
}

TEST(EffectFiles, AFileOfAmplitudesIsReadAndItsMistakesHaveItsName) {
  const Folder f;
  const fs::path rig = f.write("rig.yaml", at_examples(rig_head) + "  effects: found.yaml\n");
  EXPECT_THAT(refusal(rig), HasSubstr("found.yaml"));
  f.write("found.yaml", "effects: found\nsource: a test\namplitudes:\n  bekker.steady: {interface_friction: 0.7}\n");
  EXPECT_EQ(refusal(rig), "no error");
  f.write("found.yaml", "effects: found\namplitudes:\n  bekker.steady: {interface_frction: 0.7}\n");
  EXPECT_THAT(refusal(rig), testing::AllOf(HasSubstr("found.yaml:3:"), HasSubstr("did you mean 'interface_friction'")));
  f.write("found.yaml", "effects: found\namplitude:\n  bekker.steady: {interface_friction: 0.7}\n");
  EXPECT_THAT(refusal(rig), testing::AllOf(HasSubstr("found.yaml:"), HasSubstr("did you mean 'amplitudes'")));
  // Amplitudes of a model that is not in use are read too.
  f.write("found.yaml", "effects: found\namplitudes:\n  bekker.soil_node: {hard_pan: 70 1/m}\n");
  EXPECT_THAT(refusal(rig), testing::AllOf(HasSubstr("found.yaml:3:"), HasSubstr("hard_pan")));
}

TEST(EffectFiles, AVehicleRunSaysWhatIsSwitchedOnAndResumesWithIt) {
  const Folder f;
  std::string text = at_examples(R"(scenario: test
vehicle: EXAMPLES/vehicles/skid_robot.yaml
time_step: 1 ms
output: {rate: 50 Hz, checkpoint_every: 0.5 s}
duration: 1.5 s
terrain:
  model: bekker.steady
  soil: EXAMPLES/soils/mojave_martian_simulant.yaml
  options: {bekker.steady: {pass: {rear_left: 2, rear_right: 2}}}
  effects: found.yaml
driver: {type: speed_hold, speed: 0.2 m/s, ramp: 0.5 s}
)");
  f.write("found.yaml",
          "effects: found\namplitudes:\n  bekker.steady: {repetitive_loading: 1.2, shear_modulus_load: 0.4, hard_pan: "
          "4 1/m}\n");
  const fs::path file = f.write("s.yaml", text);
  const RunSummary s = run(file, f.path() / "out", "bekker.steady", 0);
  ASSERT_THAT(s.notices, testing::Contains(HasSubstr(
                             "effects switched on: repetitive_loading 1.2, hard_pan 4 1/m, shear_modulus_load 0.4")));
  {
    const RunFile record(f.path() / "out/run.h5");
    EXPECT_EQ(record.attribute("effects"), "repetitive_loading 1.2, hard_pan 4 1/m, shear_modulus_load 0.4");
    EXPECT_THAT(record.attributes().scenario, HasSubstr("repetitive_loading: 1.2"));
  }
  EXPECT_LT(s.energy_residual_ratio, 0.005);
  // The file of amplitudes is among the inputs that the run keeps: the run can be done again from them, also from its last checkpoint.
  EXPECT_TRUE(fs::exists(f.path() / "out/inputs"));
  fs::remove(f.path() / "found.yaml");
  EXPECT_EQ(resume_run(f.path() / "out", all_models(), 1).end_state_hash, s.end_state_hash);
}

}  // namespace
}  // namespace grouser::vehicle
