#include "grouser/vehicle/ode.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace grouser::vehicle;

namespace {

// Stiff relaxation onto a slow curve (Prothero & Robinson 1974): y = cos t exactly when it starts there.
TEST(Ode, FollowsAStiffCurveToTolerance) {
  OdeOptions o;
  o.relative = 1e-9;
  o.absolute = {1e-11};
  Ode ode(
      0, {1.0}, [](double t, auto y, auto dy) { dy[0] = -1e5 * (y[0] - std::cos(t)) - std::sin(t); }, o);
  ASSERT_EQ(ode.advance(3.0), Ode::Stop::end);
  EXPECT_EQ(ode.time(), 3.0);
  // Global error may exceed the local tolerance by the number of steps; the attraction keeps it near it.
  EXPECT_NEAR(ode.state()[0], std::cos(3.0), 1e-7);
  EXPECT_LT(ode.evaluations(), 5000);  // an explicit method would need 1e5 * 3 / 2 steps
}

TEST(Ode, StopsWhereAFallingBodyMeetsTheGround) {
  OdeOptions o;
  o.relative = 1e-10;
  Ode ode(
      0, {2.0, 0.0}, [](double, auto y, auto dy) { dy[0] = y[1], dy[1] = -9.81; }, o);
  ode.watch(1, [](double, auto y, auto g) { g[0] = y[0]; });
  ASSERT_EQ(ode.advance(10), Ode::Stop::root);
  EXPECT_NEAR(ode.time(), std::sqrt(2 * 2.0 / 9.81), 1e-8);
  EXPECT_EQ(ode.crossings()[0], -1);
  // Bounce without loss: the same height after twice the fall.
  const double back[2] = {0.0, -ode.state()[1]};
  const double t1 = ode.time();
  ode.restart(t1, back);
  ASSERT_EQ(ode.advance(2 * t1), Ode::Stop::end);
  EXPECT_NEAR(ode.state()[0], 2.0, 1e-7);
}

TEST(Ode, PassesOnWhatTheRightHandSideThrows) {
  Ode ode(0, {1.0}, [](double t, auto, auto dy) {
    if (t > 0.5) throw std::domain_error("no soil there");
    dy[0] = 1;
  });
  try {
    ode.advance(1);
    FAIL();
  } catch (const std::domain_error& e) {
    EXPECT_STREQ(e.what(), "no soil there");
  }
}

TEST(Ode, NamesTimeAndReasonWhenItGivesUp) {
  OdeOptions o;
  o.max_steps = 20;
  Ode ode(
      0, {1.0}, [](double t, auto, auto dy) { dy[0] = std::sin(1e6 * t); }, o);
  try {
    ode.advance(1);
    FAIL();
  } catch (const OdeError& e) {
    EXPECT_NE(std::string(e.what()).find("mxstep steps taken"), std::string::npos) << e.what();
  }
}

TEST(Ode, RefusesTolerancesThatDoNotFit) {
  OdeOptions o;
  o.absolute = {1e-9, 1e-9, 1e-9};
  EXPECT_THROW(Ode(
                   0, {1.0, 2.0}, [](double, auto, auto) {}, o),
               OdeError);
  o.absolute = {0.0};
  EXPECT_THROW(Ode(
                   0, {1.0, 2.0}, [](double, auto, auto) {}, o),
               OdeError);
}

}  // namespace
