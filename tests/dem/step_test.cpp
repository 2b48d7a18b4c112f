// Steps by themselves: from the Rayleigh time, or by the stiffness of the contacts.
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/dem/packing.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

TEST(AutomaticStep, OfTableFourTwoIsThePublishedShareOfTheRayleighTime) {
  // Section 4.2: 2.2e-6 s is 4.7 % of the Rayleigh time of the smallest grain; 0.17 of it is then 8e-6 s.
  SoilSettings s;
  EXPECT_NEAR(2.2e-6 / rayleigh_time(s.materials.materials[0], s.smallest / 2, s.density), 0.047, 1e-3);
  s.dt_share = kStepShare;
  set_step(s);
  EXPECT_NEAR(s.dt, 8e-6, 0.3e-6);
  // A quarter of the stiffness doubles it.
  const double before = s.dt;
  for (Material& m : s.materials.materials) m.young /= 4;
  set_step(s);
  EXPECT_NEAR(s.dt, 2 * before, 1e-9 * before);
}

SolverSettings falling(double adapt) {
  SolverSettings s;
  s.domain.lo = Vec3(0, 0, -0.01);
  s.domain.hi = Vec3(0.05, 0.05, 0.2);
  s.dt = 8e-6;
  s.adapt = adapt;
  s.dt_largest = 4e-5;
  return s;
}

const Packing& bed() {
  static const Packing p = [] {
    SoilSettings s;
    s.smallest = 0.004;
    s.largest = 0.008;
    s.dt = 1e-5;
    s.law.rolling = RollingCoefficient::constant;
    s.materials.pair(0, 0).rolling = 0.3;
    return pour_periodic(s, 0.05, 0.05, 0.03);
  }();
  return p;
}

TEST(AdaptiveStep, FollowsTheStiffnessOfTheContactsAndEndsOnTime) {
  Solver s(falling(0.5), bed().grains);
  s.add_floor();
  s.step_for(0.05);
  EXPECT_NEAR(s.time(), 0.05, 0.5 * s.time_step());
  // At rest under its own weight a bed stands longer steps than the first one; they stay below the share asked for.
  EXPECT_GT(s.time_step(), 1.5e-5);
  EXPECT_LE(s.time_step(), 0.5 * s.stable_step() * 1.3);
  // A plate pressed into it at speed stiffens the contacts: the step goes down in time, nothing is refused.
  BodySettings b;
  b.X_WB.p = Vec3(0.025, 0.025, bed().height + 0.02);
  b.V_W.v = Vec3(0, 0, -0.2);
  const int plate = s.add_body(b);
  s.add_mesh(plate, box_mesh(Vec3(0.03, 0.03, 0.02)));
  const double rest = s.time_step();
  s.step_for(0.1);
  EXPECT_LT(s.time_step(), rest);
  EXPECT_LE(s.time_step(), s.stable_step());
}

TEST(AdaptiveStep, GivesTheSameForceAsAFixedOne) {
  // The weight of the bed on the floor, once it is at rest: statics, whatever the steps.
  double mass = 0;
  for (const GrainState& g : bed().grains) mass += 4.0 / 3 * pi * std::pow(g.radius, 3) * g.density;
  for (const double adapt : {0.0, 0.5}) {
    Solver s(falling(adapt), bed().grains);
    const int floor = s.add_floor();
    s.step_for(0.3);
    const double before = s.body(floor).impulse[2], t = s.time();
    s.step_for(0.1);
    EXPECT_NEAR(-(s.body(floor).impulse[2] - before) / (s.time() - t), mass * 9.81, 2e-3 * mass * 9.81);
  }
}

TEST(AdaptiveStep, ContinuesWithTheSameBits) {
  Solver whole(falling(0.5), bed().grains), part(falling(0.5), bed().grains);
  whole.add_floor();
  part.add_floor();
  whole.step_for(0.02);
  State saved;
  whole.traverse(saved);
  whole.step_for(0.02);
  saved.rewind(State::Mode::load);
  part.traverse(saved);
  part.step_for(0.02);
  EXPECT_EQ(part.time_step(), whole.time_step());
  EXPECT_EQ(part.hash(), whole.hash());
}

TEST(AdaptiveStep, WrongSharesAreNamed) {
  EXPECT_THROW(Solver(falling(0.9), bed().grains), DemError);
  SolverSettings s = falling(0.5);
  s.dt_largest = 1e-6;
  EXPECT_THROW(Solver(s, bed().grains), DemError);
}

}  // namespace
