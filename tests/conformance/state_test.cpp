// What the registry says of each model.
#include "conformance/conformance.h"

namespace grouser::test {
namespace {

class Registered : public Conformance {};

TEST_P(Registered, DescribesItself) {
  const ModelInfo& m = tested_models().get(GetParam());
  EXPECT_FALSE(m.summary.empty());
  EXPECT_FALSE(m.can.empty());
  EXPECT_FALSE(m.cannot.empty());
  EXPECT_EQ(make()->id(), m.id.substr(0, m.id.find(':')));
}

TEST_P(Registered, AnnotatedDefaultsAreTheDefaults) {
  // The printed defaults, given as options, are read without an error and change nothing.
  const ModelInfo& m = tested_models().get(GetParam());
  const ConfigDocument document = ConfigDocument::from_text(m.annotated_defaults, "defaults");
  auto printed = m.make({soil(), flat_ground(), document.root(), 9.81});
  EXPECT_NO_THROW(document.check());
  ASSERT_TRUE(printed);
  printed->add_body({"wheel0", gear(), {}});
  const auto plain = make();
  for (int i = 0; i < 50; ++i) {
    const BodyMotion b = arriving(Rolling{}.at(1e-3 * (i + 1)), 1e-3);
    EXPECT_EQ(step_one(*printed, 1e-3 * i, 1e-3, b).impulse, step_one(*plain, 1e-3 * i, 1e-3, b).impulse);
  }
}

TEST_P(Registered, UnknownOptionIsAnErrorAtItsLine) {
  const ConfigDocument document = ConfigDocument::from_text("# one\nno_such_option: 1\n", "options.yaml");
  try {
    tested_models().get(GetParam()).make({soil(), flat_ground(), document.root(), 9.81});
    document.check();
    ADD_FAILURE() << "no error";
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), testing::StartsWith("options.yaml:2:1: unknown key 'no_such_option'"));
  }
}

GROUSER_EVERY_MODEL(Registered);

TEST(Registry, UnknownModelIsNamedWithTheNearest) {
  try {
    tested_models().get("rigit");
    FAIL();
  } catch (const std::out_of_range& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("unknown terrain model 'rigit'; did you mean 'rigid'?"));
  }
}

}  // namespace
}  // namespace grouser::test
