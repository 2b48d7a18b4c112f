// Static rest: the impulse currency is right for any substep split, precision and up axis; applyForce is not.
#include <gtest/gtest.h>

#include <cmath>

#include "bullet_world.h"

namespace grouser::bullet {
namespace {

struct RestCase {
  UpAxis up;
  int substeps;
  bool implicit;
};
class Rest : public testing::TestWithParam<RestCase> {};

TEST_P(Rest, ThousandKilogramsOnASpringSinkByWeightOverStiffness) {
  const RestCase c = GetParam();
  World w(c.up);
  btRigidBody& mass = w.body(1000, Vec3::Zero());
  // m g / k with 70 % of critical damping: 20 s are 140 time constants.
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 1e5, .c = 1.4e4}),
                       {.up = c.up, .implicit = c.implicit, .warn = {}});
  action.add_wheel(mass, wheel_gear(), "mass");
  const Added added(w, action);
  w.run(20, 1e-3, c.substeps);
  // Double: to rounding. Float: one unit in the last place of 0.0981 m is 7e-9 m; the balance of impulses is only known to the rounding of
  // the velocity, which the spring turns into a few of those.
  EXPECT_NEAR(w.at(mass).z(), -1000 * g / 1e5, double_precision ? 1e-9 : 2e-6);
  EXPECT_NEAR(action.applied(0).f.z(), 1000 * g * 1e-3, double_precision ? 1e-6 : 2e-3);
  // A float step of 1 ms is 1.00000004749745 ms, and so is the terrain's.
  EXPECT_NEAR(action.time(), 20, double_precision ? 1e-9 : 2e-6);
}
INSTANTIATE_TEST_SUITE_P(AllSplits, Rest,
                         testing::Values(RestCase{UpAxis::z, 1, true}, RestCase{UpAxis::z, 10, true},
                                         RestCase{UpAxis::z, 1, false}, RestCase{UpAxis::z, 10, false},
                                         RestCase{UpAxis::y, 1, true}, RestCase{UpAxis::y, 10, true}),
                         [](const auto& i) {
                           return std::string(i.param.up == UpAxis::z ? "z_up_" : "y_up_") +
                                  std::to_string(i.param.substeps) + (i.param.implicit ? "_implicit" : "_explicit");
                         });

/// What not to do: a force inside an action.
class ForceAction : public btActionInterface {
 public:
  explicit ForceAction(btRigidBody& b) : b_(b) {}
  void updateAction(btCollisionWorld*, btScalar) override {
    const btScalar z = b_.getCenterOfMassPosition().z(), v = b_.getLinearVelocity().z();
    if (z < 0) b_.applyCentralForce(btVector3(0, 0, bt(-1e5) * z - bt(1.4e4) * v));
    b_.activate(true);
  }
  void debugDraw(btIDebugDraw*) override {}

 private:
  btRigidBody& b_;
};

TEST(Rest, ApplyForceInAnActionIsLostWithOneSubstepAndPilesUpWithTen) {
  const auto height_after_2s = [](int substeps) {
    World w;
    btRigidBody& mass = w.body(1000, Vec3::Zero());
    ForceAction action(mass);
    const Added added(w, action);
    w.run(2, 1e-3, substeps);
    return w.at(mass).z();
  };
  const double one = height_after_2s(1), ten = height_after_2s(10);
  RecordProperty("one_substep_m", std::to_string(one));
  RecordProperty("ten_substeps_m", std::to_string(ten));
  // One substep: forces are cleared before anybody uses them, so the mass falls freely, g t^2 / 2 = 19.6 m.
  EXPECT_NEAR(one, -0.5 * g * 4, 0.02);
  // Ten: the force of substep 1 is added again in each later one, 4.5 times the soil on average: far from -0.0981 m.
  EXPECT_GT(std::abs(ten + 0.0981), 0.02);
}

TEST(Rest, AppliedImpulseIsTheChangeOfTheBodysMomentum) {
  World w;
  btRigidBody& mass = w.body(7, {0.02, -0.03, -0.01});
  mass.setLinearVelocity(bt(0.3, 0.1, -0.2));
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 2e4, .c = 50, .kt = 3e3, .ct = 20}));
  action.add_wheel(mass, wheel_gear(), "mass");
  const Added added(w, action);
  Vec3 before = w.axes.to_W(mass.getLinearVelocity());
  for (int i = 0; i < 200; ++i) {
    w.run(1e-3, 1e-3);
    const Vec3 after = w.axes.to_W(mass.getLinearVelocity());
    // Over a step the body gains gravity and the impulse applied at its end. Rounding of velocities of order 1 m/s times 7 kg.
    const Vec3 gained = 7 * (after - before) - Vec3(0, 0, -7 * g * 1e-3);
    EXPECT_LT((gained - action.applied(0).f).norm(), double_precision ? 1e-12 : 1e-5);
    before = after;
  }
}

TEST(Rest, WorldAxesMapTheSameMotionForZAndYUp) {
  const auto path = [](UpAxis up) {
    World w(up);
    btRigidBody& mass = w.body(3, {0.05, 0.02, 0.01});
    mass.setLinearVelocity(w.axes.from_W({0.2, -0.4, 0.1}));
    TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 5e3, .c = 30, .kt = 800, .ct = 10}),
                         {.up = up, .implicit = true, .warn = {}});
    action.add_wheel(mass, wheel_gear(), "mass");
    const Added added(w, action);
    w.run(0.5, 1e-3);
    return w.at(mass);
  };
  // The map only swaps and negates coordinates, so both worlds round alike.
  EXPECT_LT((path(UpAxis::z) - path(UpAxis::y)).norm(), double_precision ? 1e-14 : 1e-6);
}

TEST(Rest, WorksBesideOtherActionsAndAPreTickCallback) {
  World w;
  btRigidBody& mass = w.body(10, Vec3::Zero());
  struct Push : btActionInterface {
    explicit Push(btRigidBody& b) : b_(b) {}
    void updateAction(btCollisionWorld*, btScalar dt) override { b_.applyCentralImpulse(btVector3(0, 0, -50 * dt)); }
    void debugDraw(btIDebugDraw*) override {}
    btRigidBody& b_;
  };
  Push before(mass), after(mass);
  static int ticks;
  ticks = 0;
  w.world->setInternalTickCallback([](btDynamicsWorld*, btScalar) { ++ticks; }, nullptr, true);
  TerrainAction action(*w.world, std::make_shared<SpringTerrain>(SpringSoil{.k = 1e4, .c = 500}));
  action.add_wheel(mass, wheel_gear(), "mass");
  const Added a(w, before), b(w, action), c(w, after);
  w.run(5, 1e-3);
  // Weight and two pushes of 50 N on 1e4 N/m. The push that comes before the soil's turn is seen by the damper as the velocity that it is
  // about to make (50 N * 1 ms / 10 kg = 5 mm/s times 500 N s/m = 2.5 N, 0.25 mm).
  EXPECT_NEAR(w.at(mass).z(), -(10 * g + 100) / 1e4, 3e-4);
  EXPECT_EQ(ticks, 5000);
}

}  // namespace
}  // namespace grouser::bullet
