// Stiff soil under light wheels: the linearly implicit impulse, alone and under a load carried through joints.
#include <gtest/gtest.h>

#include <cmath>

#include "bullet_world.h"

namespace grouser::bullet {
namespace {

constexpr double dt240 = 1.0 / 240;

double rest_height(UpAxis up, double mass, double k, double dt, double drop, double seconds) {
  World w(up);
  btRigidBody& body = w.body(mass, {0, 0, drop});
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = k}),
                       {.up = up, .implicit = true, .warn = {}});
  action.add_wheel(body, wheel_gear(), "wheel");
  const Added added(w, action);
  w.run(seconds, dt);
  return w.at(body).z();
}

TEST(StiffSoil, OneKilogramOnAMillionNewtonPerMetreRestsAtItsStaticSinkage) {
  const double exact = -1 * g / 1e6;  // -9.81 um
  for (const UpAxis up : {UpAxis::z, UpAxis::y}) {
    const double z = rest_height(up, 1, 1e6, dt240, 0.01, 4);
    // Double: 1 %. Float: the pose is stored near 1e-5 m (resolution 1e-12) but the balance is of impulses m g dt = 0.04 N s, whose rounding
    // is 4e-9 relative to a velocity that k dt^2 = 17 kg makes stiff: within 1 % as well.
    EXPECT_NEAR(z, exact, 0.01 * std::abs(exact));
    RecordProperty(up == UpAxis::z ? "z_up_error_percent" : "y_up_error_percent",
                   std::to_string(100 * (z / exact - 1)));
  }
}

TEST(StiffSoil, RestIsExactUpToThirteenRadiansPerStep) {
  for (const double ratio : {0.5, 1.0, 4.0, 13.0}) {
    const double k = std::pow(ratio / dt240, 2);
    EXPECT_NEAR(rest_height(UpAxis::z, 1, k, dt240, 0.01, 4), -g / k, 0.01 * g / k) << "dt * omega = " << ratio;
  }
}

TEST(StiffSoil, ExplicitImpulsesThrowTheWheelUp) {
  // The same impulse without the correction, written out: this is what the adapter refuses to do.
  World w;
  btRigidBody& body = w.body(1, {0, 0, 0.01});
  struct Explicit : btActionInterface {
    explicit Explicit(btRigidBody& b) : b_(b) {}
    void updateAction(btCollisionWorld*, btScalar dt) override {
      const btScalar z = b_.getCenterOfMassPosition().z();
      if (z < 0) b_.applyCentralImpulse(btVector3(0, 0, bt(-1e6) * z * dt));
      highest = std::max(highest, static_cast<double>(z));
    }
    void debugDraw(btIDebugDraw*) override {}
    btRigidBody& b_;
    double highest = 0;
  } action(body);
  const Added added(w, action);
  w.run(8, dt240);
  RecordProperty("thrown_to_m", std::to_string(action.highest));
  EXPECT_GT(action.highest, 1.0);
}

std::string refusal(SpringSoil soil, bool implicit) {
  World w;
  btRigidBody& body = w.body(1, {0, 0, 0.01});
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(soil),
                       {.up = UpAxis::z, .implicit = implicit, .warn = {}});
  action.add_wheel(body, wheel_gear(), "front_left");
  const Added added(w, action);
  try {
    w.run(1, dt240);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(StiffSoil, ExplicitUseAboveOneIsRefusedByName) {
  const std::string e = refusal({.k = 1e6}, false);
  EXPECT_NE(e.find("wheel 'front_left' on test.spring: stiffness 1e+06 N/m"), std::string::npos) << e;
  EXPECT_NE(e.find("dt * omega = 4.167"), std::string::npos) << e;
  EXPECT_NE(e.find("set Options::implicit = true or use dt <= 0.001 s"), std::string::npos) << e;
}

TEST(StiffSoil, AModelWithoutLinearisationIsProbedAndRefusedByName) {
  for (const bool implicit : {true, false}) {
    const std::string e = refusal({.k = 1e6, .linearises = false}, implicit);
    EXPECT_NE(e.find("stiffness 1e+06 N/m"), std::string::npos) << e;
    EXPECT_NE(e.find("use a model that linearises its contact"), std::string::npos) << e;
  }
  EXPECT_EQ(refusal({.k = 1e4, .linearises = false}, true), "");  // dt * omega = 0.42
}

TEST(StiffSoil, DampingTooStiffForExplicitUseIsRefusedToo) {
  EXPECT_NE(refusal({.k = 100, .c = 1000}, false), "");  // dt c / m = 4.2
}

TEST(StiffSoil, AnAntiRestoringLinearisationIsRefusedByName) {
  const std::string e = refusal({.k = 1e6, .anti_restoring = true}, true);
  EXPECT_NE(e.find("wheel 'front_left'"), std::string::npos) << e;
  EXPECT_NE(e.find("anti-restoring"), std::string::npos) << e;
}

TEST(StiffSoil, GroundDoesNotPullAWheelThatLeaves) {
  World w;
  btRigidBody& body = w.body(1, {0, 0, -1e-5});
  body.setLinearVelocity(bt(0, 0, 1));
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 1e6}));
  action.add_wheel(body, wheel_gear(), "wheel");
  const Added added(w, action);
  for (int i = 0; i < 20; ++i) {
    w.run(1e-3, 1e-3);
    EXPECT_GE(action.applied(0).f.z(), 0);
  }
  EXPECT_GT(w.axes.to_W(body.getLinearVelocity()).z(), 1 - 0.021 * g);
}

// A 1 kg wheel that carries 7 kg through one joint. The wheel's own mass would make dt^2 k / m = 1 at 1e6 N/m and 1 ms, its load 1/8.
enum class Joint { hinge, slider, fixed, spring2 };
class Loaded : public testing::TestWithParam<std::tuple<Joint, double>> {};

TEST_P(Loaded, WheelUnderSevenKilogramsRestsAtTheSinkageOfBoth) {
  const auto [kind, k] = GetParam();
  World w;
  btRigidBody& wheel = w.body(1, {0, 0, 1e-3});
  btRigidBody& load = w.body(7, {0, 0, 0.3});
  load.setAngularFactor(0);
  if (kind == Joint::hinge)
    w.joint<btHingeConstraint>(load, wheel, bt(0, 0, -0.299), bt(0, 0, 0), bt(0, 1, 0), bt(0, 1, 0));
  if (kind == Joint::fixed || kind == Joint::spring2) {
    btTransform a = btTransform::getIdentity();
    a.setOrigin(bt(0, 0, -0.299));
    if (kind == Joint::fixed)
      w.joint<btFixedConstraint>(load, wheel, a, btTransform::getIdentity());
    else {
      auto& j = w.joint<btGeneric6DofSpring2Constraint>(load, wheel, a, btTransform::getIdentity());
      j.setLimit(2, 1, -1);  // free along z: sprung
      j.enableSpring(2, true);
      j.setStiffness(2, bt(2e4));
      j.setDamping(2, bt(300));
      j.setEquilibriumPoint(2, bt(0));
    }
  }
  if (kind == Joint::slider) {
    // Slides along x of its frames; the load is held vertically.
    btTransform a = btTransform::getIdentity();
    a.setOrigin(bt(0, 0, -0.299));
    auto& s = w.joint<btSliderConstraint>(load, wheel, a, btTransform::getIdentity(), true);
    s.setLowerLinLimit(0);
    s.setUpperLinLimit(0);
  }
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = k, .kt = 1e4, .ct = 100}));
  action.add_wheel(wheel, wheel_gear(), "wheel");
  const Added added(w, action);
  w.run(20, 1e-3);
  const double exact = -8 * g / k, z = w.at(wheel).z();
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    w.run(1e-3, 1e-3);
    worst = std::max(worst, std::abs(w.at(wheel).z() - z));
  }
  RecordProperty("relative_error", std::to_string(z / exact - 1));
  RecordProperty("ripple_relative", std::to_string(worst / std::abs(exact)));
  EXPECT_NEAR(z, exact, 0.01 * std::abs(exact));
  EXPECT_LT(worst, 0.01 * std::abs(exact));
}
std::string loaded_name(const testing::TestParamInfo<std::tuple<Joint, double>>& test) {
  const std::vector<std::string> joints{"hinge", "slider", "fixed", "spring2"};
  return joints[static_cast<std::size_t>(std::get<0>(test.param))] + "_1e" +
         std::to_string(static_cast<int>(std::round(std::log10(std::get<1>(test.param)))));
}
INSTANTIATE_TEST_SUITE_P(Joints, Loaded,
                         testing::Combine(testing::Values(Joint::hinge, Joint::slider, Joint::fixed, Joint::spring2),
                                          testing::Values(1e5, 1e6, 1e7)),
                         loaded_name);

TEST(Mobility, RefreshOfEightStepsCanBeHalvedOrDoubled) {
  // A cart of 20 kg with four 1 kg wheels, driven by hinge motors in a curve (one side faster) on stiff soil: joints turn all the time.
  const auto drive = [](int refresh) {
    World w;
    btRigidBody& chassis = w.body(20, {0, 0, 0.2});
    TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 1e6, .c = 500, .ct = 200}),
                         {.up = UpAxis::z, .implicit = true, .mobility_refresh = refresh, .warn = {}});
    for (int i = 0; i < 4; ++i) {
      const Vec3 hub(i < 2 ? 0.3 : -0.3, i % 2 == 0 ? 0.25 : -0.25, -0.2);
      btRigidBody& wheel = w.body(1, Vec3(0, 0, 0.2) + hub);
      auto& hinge = w.joint<btHingeConstraint>(chassis, wheel, bt(hub.x(), hub.y(), hub.z()), bt(0, 0, 0), bt(0, 1, 0),
                                               bt(0, 1, 0));
      hinge.enableAngularMotor(true, bt(i % 2 == 0 ? -3 : -5), bt(0.02));
      action.add_wheel(wheel, wheel_gear(), "wheel_" + std::to_string(i));
    }
    chassis.setAngularVelocity(bt(0, 0, 0.5));
    chassis.setLinearVelocity(bt(1, 0, 0));
    const Added added(w, action);
    w.run(3, 1e-3);
    return std::pair{w.at(chassis), action.applied(0).f.z()};
  };
  const auto [each, load_each] = drive(1);
  const auto [eight, load_eight] = drive(8);
  const auto [sixteen, load_sixteen] = drive(16);
  RecordProperty("change_8_um", std::to_string(1e6 * (eight - each).norm()));
  RecordProperty("change_16_um", std::to_string(1e6 * (sixteen - each).norm()));
  // The path is some decimetres long; a tenth of a millimetre is far below what a soil law knows.
  EXPECT_LT((eight - each).norm(), 1e-4);
  EXPECT_LT((sixteen - each).norm(), 2e-4);
  EXPECT_NEAR(load_eight, load_each, 0.01 * load_each);
  EXPECT_NEAR(load_sixteen, load_each, 0.02 * load_each);
}

}  // namespace
}  // namespace grouser::bullet
