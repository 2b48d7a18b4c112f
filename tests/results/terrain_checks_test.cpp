// The argument checks that the base class makes for every model, seen with a model of one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grouser/terrain/terrain.h"
#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::message_of;
using testing::HasSubstr;

/// A weightless spring of 1 N/m with a counter as its state.
class TinyTerrain : public Terrain {
 public:
  TinyTerrain() : Terrain(flat_ground()) {
    declare_effect({"pull", "a constant pull", "N", 0, 10, 0, ""});
    declare_effect({"push", "a constant push", "N", 0, 1, 0, ""});
  }
  std::string id() const override { return "tiny"; }
  Capabilities capabilities() const override { return {}; }
  double result_factor = 1;
  int steps = 0, told = 0;

 protected:
  void do_step(const StepContext& c, std::span<const BodyMotion> m, std::span<BodyResult> r) override {
    ++steps;
    for (std::size_t i = 0; i < m.size(); ++i)
      r[i].impulse = Vec3(0, 0, -c.dt * m[i].X_WB_end.p.z() * result_factor + effects()[0].amplitude);
    ledger().stored = 0.5 * steps;
  }
  void do_traverse(State& s) override { s.field("steps", steps); }
  void do_set_effect(std::size_t, double) override { ++told; }
};

struct TerrainChecks : testing::Test {
  TinyTerrain terrain;
  std::vector<BodyMotion> motions;
  std::vector<BodyResult> results;

  void SetUp() override {
    terrain.add_body({"left", {"wheel", SmoothCylinder{0.1, 0.1}}, {}});
    terrain.add_body({"right", {"wheel", SmoothCylinder{0.1, 0.1}}, {}});
    motions.resize(2);
    results.resize(2);
  }
  std::string step_error(double t, double dt) {
    return message_of<TerrainError>([&] { terrain.step(t, dt, motions, results); });
  }
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

TEST_F(TerrainChecks, StepLengthMustBePositiveAndFinite) {
  for (const double dt : {0.0, -1e-3, nan, inf})
    EXPECT_THAT(step_error(0, dt), HasSubstr("dt must be positive and finite")) << dt;
  EXPECT_THAT(step_error(nan, 1e-3), HasSubstr("t is not finite"));
  EXPECT_FALSE(terrain.started());
}

TEST_F(TerrainChecks, TimeMayStartAnywhereAndMustThenBeContiguous) {
  EXPECT_EQ(step_error(5, 0.5), "");
  EXPECT_EQ(step_error(5.5, 0.5), "");
  EXPECT_EQ(step_error(5.5, 0.5),
            "time must be contiguous: the last step ended at t = 6.000000 s, this one begins at t = 5.500000 s");
  EXPECT_THAT(step_error(6.1, 0.5), HasSubstr("time must be contiguous"));
  EXPECT_EQ(step_error(6 + 1e-10, 0.5), "") << "rounding of a host's clock is allowed";
}

TEST_F(TerrainChecks, SizesMustMatchTheBodies) {
  motions.resize(1);
  EXPECT_EQ(step_error(0, 1e-3), "step got 1 motions and 2 results for 2 bodies");
}

TEST_F(TerrainChecks, MotionMustBeFiniteAndNamesTheBody) {
  for (int what = 0; what < 4; ++what) {
    motions.assign(2, {});
    BodyMotion& m = motions[1];
    if (what == 0) m.X_WB_begin.p.x() = nan;
    if (what == 1) m.X_WB_end.q.x() = inf;
    if (what == 2) m.V_WB_end.v.y() = nan;
    if (what == 3) m.V_WB_end.w.z() = inf;
    EXPECT_EQ(step_error(0.25, 1e-3), "motion of body 'right' is not finite at t = 0.250000 s") << what;
  }
}

TEST_F(TerrainChecks, OrientationMustBeAUnitQuaternion) {
  motions[0].X_WB_end.q = Quat(1.01, 0, 0, 0);
  EXPECT_EQ(step_error(0, 1e-3), "orientation of body 'left' is not a unit quaternion at t = 0.000000 s");
}

TEST_F(TerrainChecks, HubMassMustBePositive) {
  motions[0].hub = HubDynamics{};
  EXPECT_THAT(step_error(0, 1e-3), HasSubstr("hub mass of body 'left' must be positive"));
}

TEST_F(TerrainChecks, ModelWhoseAnswerIsNotFiniteIsStopped) {
  terrain.result_factor = nan;
  EXPECT_EQ(step_error(0.5, 1e-3), "tiny: impulse on body 'left' is not finite at t = 0.500000 s");
}

TEST_F(TerrainChecks, PreviewChecksTooAndChangesNothing) {
  EXPECT_THROW(terrain.preview(0, -1, motions, results), TerrainError);
  motions[0].X_WB_end.p.z() = -0.5;
  terrain.step(0, 0.1, motions, results);
  State before;
  terrain.traverse(before);
  terrain.preview(0.1, 0.1, motions, results);
  State after;
  terrain.traverse(after);
  EXPECT_FALSE(State::first_difference(before, after));
  EXPECT_EQ(terrain.steps, 1);
}

TEST_F(TerrainChecks, WorkOnBodiesIsImpulseTimesVelocity) {
  // 0.5 m deep for 0.1 s gives 0.05 N s on each; at 2 m/s upward that is 0.1 J each.
  for (BodyMotion& m : motions) {
    m.X_WB_end.p.z() = -0.5;
    m.V_WB_end.v.z() = 2;
  }
  motions[1].V_WB_end.v.z() = -2;
  terrain.step(0, 0.1, motions, results);
  EXPECT_NEAR(terrain.energy().work_on_bodies, 0.0, 1e-15);
  EXPECT_NEAR(terrain.energy().gross, 0.2, 1e-15);
}

TEST_F(TerrainChecks, BodiesAreAddedBeforeTheFirstStep) {
  terrain.step(0, 0.1, motions, results);
  EXPECT_EQ(message_of<TerrainError>([&] {
              terrain.add_body({"late", {}, {}});
            }),
            "add_body('late') after the first step: add every wheel before stepping");
}

TEST_F(TerrainChecks, UnknownEffectIsNamedWithTheNearest) {
  EXPECT_EQ(message_of<TerrainError>([&] { terrain.set_effect("pul", 1); }),
            "tiny has no effect 'pul'; did you mean 'pull'?");
  EXPECT_EQ(message_of<TerrainError>([&] { terrain.set_effect("something", 1); }), "tiny has no effect 'something'");
}

TEST_F(TerrainChecks, AmplitudeOutsideItsBoundsIsRefused) {
  for (const double a : {-0.1, 10.1, nan, inf})
    EXPECT_THAT(message_of<TerrainError>([&] { terrain.set_effect("pull", a); }),
                HasSubstr("is outside [0.000000, 10.000000]"));
  EXPECT_EQ(terrain.effects()[0].amplitude, 0);
  terrain.set_effect("pull", 10);
  EXPECT_EQ(terrain.effects()[0].amplitude, 10);
}

TEST_F(TerrainChecks, AmplitudesBelongToTheState) {
  terrain.set_effect("push", 0.5);
  State s;
  terrain.traverse(s);
  TinyTerrain other;
  s.rewind(State::Mode::load);
  other.traverse(s);
  EXPECT_EQ(other.effects()[1].amplitude, 0.5);
  EXPECT_EQ(other.told, 1) << "the model hears of the amplitude that it did not have";
}

TEST_F(TerrainChecks, StateOfAnotherModelIsRefused) {
  State s;
  std::string model = "huge";
  s.field("model", model);
  s.rewind(State::Mode::load);
  EXPECT_EQ(message_of<StateError>([&] { terrain.traverse(s); }), "state belongs to terrain 'huge', not to 'tiny'");
}

TEST_F(TerrainChecks, SurfaceAndThreadsAreChecked) {
  EXPECT_THROW(terrain.surface(nan, 0), TerrainError);
  EXPECT_EQ(terrain.surface(1, 2).height, 0);
  EXPECT_THROW(terrain.set_threads(0), TerrainError);
  EXPECT_THAT(message_of<TerrainError>([&] { terrain.field("moisture", 0, 0); }),
              HasSubstr("tiny has no field 'moisture'"));
}

}  // namespace
}  // namespace grouser
