// Wheels that are links of a btMultiBody (no applyImpulse there), and the drift of maximal-coordinate joints.
#include <gtest/gtest.h>

#include <cmath>

#include "bullet_world.h"

namespace grouser::bullet {
namespace {

std::shared_ptr<SpringTerrain> spring(SpringSoil s) { return std::make_shared<SpringTerrain>(s); }

/// A multibody in a world, with a collider per link (Bullet asks for one to keep it simulated).
struct Machine {
  World& w;
  btMultiBody body;
  Machine(World& world, int links, double base_mass, bool fixed, const Vec3& p_W)
      : w(world), body(links, bt(base_mass), bt(base_mass, base_mass, base_mass), fixed, false) {
    body.setBasePos(w.axes.from_W(p_W));
    body.setHasSelfCollision(false);
    body.setLinearDamping(0);
    body.setAngularDamping(0);
  }
  void finish() {
    body.finalizeMultiDof();
    w.world->addMultiBody(&body);
  }
  ~Machine() { w.world->removeMultiBody(&body); }
  Machine(const Machine&) = delete;
};

class Link : public testing::TestWithParam<std::tuple<UpAxis, double>> {};

TEST_P(Link, WheelLinkRestsLikeARigidBody) {
  const auto [up, k] = GetParam();
  World w(up);
  Machine m(w, 2, 1, true, {0, 0, 0.5});
  const btVector3 z = w.axes.from_W({0, 0, 1}), y = w.axes.from_W({0, 1, 0}), zero(0, 0, 0);
  // A 7 kg carriage slides along z under a fixed base; the 1 kg wheel turns in it.
  m.body.setupPrismatic(0, 7, bt(0.1, 0.1, 0.1), -1, btQuaternion::getIdentity(), z, w.axes.from_W({0, 0, -0.2}), zero,
                        true);
  m.body.setupRevolute(1, 1, bt(0.01, 0.01, 0.01), 0, btQuaternion::getIdentity(), y, w.axes.from_W({0, 0, -0.3}), zero,
                       true);
  m.finish();
  TerrainAction action(*w.world, spring({.k = k, .c = 0.7 * 2 * std::sqrt(8 * k)}),
                       {.up = up, .implicit = true, .warn = {}});
  action.add_wheel(m.body, 1, wheel_gear(), "wheel");
  const Added added(w, action);
  w.run(5, 1e-3);
  const double exact = -8 * g / k;
  // The carriage moves along one line: no approximation but rounding; float carries 0.5 m of offset, resolution 3e-8 m.
  EXPECT_NEAR(action.pose(0).p.z(), exact, double_precision ? 1e-9 : 0.01 * std::abs(exact) + 2e-7);
  EXPECT_NEAR(action.applied(0).f.z(), 8 * g * 1e-3, 1e-3 * 8 * g * 1e-3);
}
std::string link_name(const testing::TestParamInfo<std::tuple<UpAxis, double>>& test) {
  return std::string(std::get<0>(test.param) == UpAxis::z ? "z_up_1e" : "y_up_1e") +
         std::to_string(static_cast<int>(std::round(std::log10(std::get<1>(test.param)))));
}
INSTANTIATE_TEST_SUITE_P(Stiffness, Link,
                         testing::Combine(testing::Values(UpAxis::z, UpAxis::y), testing::Values(1e5, 1e6)), link_name);

TEST(Link, FourWheelsOfAFreeMultibodyShareItsWeight) {
  World w;
  Machine m(w, 4, 10, false, {0, 0, 0.1});
  m.body.setBaseInertia(bt(0.5, 0.8, 1.0));
  int i = 0;
  for (const double x : {-0.3, 0.3})
    for (const double y : {-0.25, 0.25})
      m.body.setupRevolute(i++, 1, bt(0.005, 0.01, 0.005), -1, btQuaternion::getIdentity(), bt(0, 1, 0), bt(x, y, -0.1),
                           bt(0, 0, 0), true);
  m.finish();
  TerrainAction action(*w.world, spring({.k = 1e6, .c = 3000, .kt = 1e5, .ct = 1000}));
  for (int l = 0; l < 4; ++l) action.add_wheel(m.body, l, wheel_gear(), "wheel_" + std::to_string(l));
  const Added added(w, action);
  w.run(5, 1e-3);
  double load = 0;
  for (int l = 0; l < 4; ++l) {
    load += action.applied(l).f.z() / 1e-3;
    EXPECT_NEAR(action.pose(l).p.z(), -14 * g / 4e6, 0.01 * 14 * g / 4e6 + (double_precision ? 0 : 1e-6));
  }
  EXPECT_NEAR(load, 14 * g, 1e-3 * 14 * g);
}

TEST(Link, AnImpulseOnALinkChangesTheMachinesMomentumByItself) {
  // A free chain has no outside support, so its linear momentum changes by the impulse exactly.
  World w;
  w.world->setGravity(bt(0, 0, 0));
  Machine m(w, 1, 3, false, {0, 0, 0});
  m.body.setupRevolute(0, 2, bt(0.02, 0.03, 0.02), -1, btQuaternion::getIdentity(), bt(0, 1, 0), bt(0.2, 0, 0),
                       bt(0.1, 0, 0), true);
  m.finish();
  w.run(1e-3, 1e-3);  // fills the caches that the response needs
  const HostBody link(m.body, 0), base(m.body, -1);
  const LinkRows rows = link.rows();
  const Vec3 f(0.3, -0.2, 0.5), t(0.01, 0.02, -0.03);
  link.apply(w.axes, f, t, &rows);
  const Vec3 momentum = 3 * base.twist_W(w.axes).v + 2 * link.twist_W(w.axes).v;
  EXPECT_LT((momentum - f).norm(), double_precision ? 1e-12 : 1e-6);
}

TEST(Link, ABadLinkIsRefusedByName) {
  World w;
  Machine m(w, 1, 1, true, {0, 0, 0});
  m.body.setupRevolute(0, 1, bt(1, 1, 1), -1, btQuaternion::getIdentity(), bt(0, 1, 0), bt(0, 0, 0), bt(0, 0, 0), true);
  m.finish();
  TerrainAction action(*w.world, spring({.k = 1e4}));
  EXPECT_THROW(action.add_wheel(m.body, 1, wheel_gear(), "wheel"), std::invalid_argument);
}

TEST(Drift, HingesDriftAndMultibodyLinksDoNot) {
  // A 2 kg arm of 0.5 m hinged to the world, a 1 kg wheel hinged to its end that bounces on soil for 10 s. Drift: error of the distance
  // between wheel centre and pivot.
  constexpr double length = 0.5;
  const Vec3 pivot(0, 0, 0.1);
  const SpringSoil soil{.k = 2e4, .c = 5, .kt = 0, .ct = 2};
  const auto worst = [&](const TerrainAction& a, World& w) {
    double d = 0;
    for (int i = 0; i < 10000; ++i) {
      w.run(1e-3, 1e-3);
      d = std::max(d, std::abs((a.pose(0).p - pivot).norm() - length));
    }
    return d;
  };
  double maximal = 0, reduced = 0;
  {
    World w;
    btRigidBody& anchor = w.body(0, pivot);
    btRigidBody& arm = w.body(2, pivot + Vec3(length / 2, 0, 0));
    btRigidBody& wheel = w.body(1, pivot + Vec3(length, 0, 0));
    w.joint<btHingeConstraint>(anchor, arm, bt(0, 0, 0), bt(-length / 2, 0, 0), bt(0, 1, 0), bt(0, 1, 0));
    w.joint<btHingeConstraint>(arm, wheel, bt(length / 2, 0, 0), bt(0, 0, 0), bt(0, 1, 0), bt(0, 1, 0));
    TerrainAction action(*w.world, spring(soil));
    action.add_wheel(wheel, wheel_gear(), "wheel");
    const Added added(w, action);
    maximal = worst(action, w);
  }
  {
    World w;
    Machine m(w, 2, 1, true, pivot);
    const double I = 0.4 * 2 * 0.13 * 0.13;
    m.body.setupRevolute(0, 2, bt(I, I, I), -1, btQuaternion::getIdentity(), bt(0, 1, 0), bt(0, 0, 0),
                         bt(length / 2, 0, 0), true);
    m.body.setupRevolute(1, 1, bt(I / 2, I / 2, I / 2), 0, btQuaternion::getIdentity(), bt(0, 1, 0),
                         bt(length / 2, 0, 0), bt(0, 0, 0), true);
    m.finish();
    TerrainAction action(*w.world, spring(soil));
    action.add_wheel(m.body, 1, wheel_gear(), "wheel");
    const Added added(w, action);
    reduced = worst(action, w);
  }
  RecordProperty("hinge_drift_um", std::to_string(1e6 * maximal));
  RecordProperty("multibody_drift_um", std::to_string(1e6 * reduced));
  EXPECT_LT(reduced, double_precision ? 1e-9 : 1e-5);
  EXPECT_GT(maximal, reduced);
  EXPECT_LT(maximal, 1e-3);
}

}  // namespace
}  // namespace grouser::bullet
