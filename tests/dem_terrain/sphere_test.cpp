// dem.sphere as a terrain: forces on a wheel, momentum, memory, borders of what moves, state, errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "dem_terrain/coarse.h"

namespace grouser::test {
namespace {

/// Lowered at 0.2 m/s without spin from 20 mm above the ground; the hub ends at radius - depth. Returns the last answer.
BodyResult lower(Terrain& t, double depth, double& time, double dt = 1e-3) {
  Ride down;
  down.speed = down.slip = 0;
  down.hub = kRadius + 0.02;
  down.sink = 0.2;
  BodyResult r;
  const int n = static_cast<int>(std::lround((0.02 + depth) / down.sink / dt));
  for (int i = 0; i < n; ++i, time += dt) r = step_one(t, time, dt, down.motion(dt * i, dt * (i + 1)));
  return r;
}

TEST(Sphere, LeavesAWheelAloneThatIsOneGrainAboveTheGround) {
  const auto t = coarse_terrain();
  Ride clear;
  clear.hub = kRadius + 0.018;
  for (int i = 0; i < 50; ++i) {
    const BodyResult r = step_one(*t, 1e-3 * i, 1e-3, clear.motion(1e-3 * i, 1e-3 * (i + 1)));
    EXPECT_EQ(r.impulse, Vec3(Vec3::Zero()));
    EXPECT_EQ(r.angular_impulse, Vec3(Vec3::Zero()));
    EXPECT_FALSE(r.report.in_contact);
  }
}

TEST(Sphere, CarriesMoreTheDeeperAWheelIsPressed) {
  const auto t = coarse_terrain();
  double time = 0, last = 0;
  lower(*t, 0, time);
  Ride down;
  down.speed = down.slip = 0;
  down.sink = 0.1;
  double sum = 0;
  for (int i = 0; i < 200; ++i, time += 1e-3) {
    const BodyResult r = step_one(*t, time, 1e-3, down.motion(1e-3 * i, 1e-3 * (i + 1)));
    sum += r.report.normal_force / 50;
    EXPECT_NEAR(r.report.sinkage, 1e-4 * (i + 1), 1e-9);
    if ((i + 1) % 50 == 0) {
      // Means over 5 mm; single grains that give way do not turn the order.
      EXPECT_GT(sum, last) << i;
      last = sum;
      sum = 0;
    }
  }
  // 20 mm of sinkage into 1.6 g/cm3 of frictional soil: between the weight of the soil pushed aside and a hundred bars.
  EXPECT_GT(last, 10);
  EXPECT_LT(last, 5000);
}

TEST(Sphere, HasItsSurfaceWhereTheGroundIs) {
  for (const double z0 : {0.0, 3.5}) {
    const auto t = coarse_terrain(flat_ground(z0));
    Ride above;
    above.hub = z0 + kRadius + 0.018;
    step_one(*t, 0, 1e-3, above.motion(0, 1e-3));
    double mean = 0;
    for (int i = 0; i < 10; ++i)
      for (int k = 0; k < 10; ++k) mean += t->surface(0.015 * i - 0.07, 0.015 * k - 0.07).height / 100;
    // Nothing has happened: springs that form anew let grains settle by micrometres.
    EXPECT_NEAR(mean, z0, 1e-4);
    EXPECT_EQ(t->surface(5, 5).height, z0) << "soil that is not in the solver";
  }
}

TEST(Sphere, DrivingPullsMoreThanBraking) {
  const auto pull = [](double slip) {
    const auto t = coarse_terrain();
    double time = 0, sum = 0, torque = 0;
    lower(*t, 0.01, time);
    Ride ride;
    ride.hub = kRadius - 0.01;
    ride.slip = slip;
    for (int i = 0; i < 600; ++i, time += 1e-3) {
      const BodyResult r = step_one(*t, time, 1e-3, ride.motion(1e-3 * i, 1e-3 * (i + 1)));
      if (i >= 200) sum += r.report.drawbar_pull / 400, torque += r.report.driving_torque / 400;
    }
    return std::pair(sum, torque);
  };
  const auto [drive, asked] = pull(0.6);
  const auto [brake, held] = pull(-1.5);  // r w is 0.4 v
  EXPECT_GT(drive, brake);
  EXPECT_LT(brake, 0);
  EXPECT_GT(asked, 0);
  EXPECT_LT(held, 0);
}

TEST(Sphere, RutStaysAndIsMetAgain) {
  const auto t = coarse_terrain();
  double time = 0;
  lower(*t, 0.015, time);
  Ride ride;
  ride.hub = kRadius - 0.015;
  ride.speed = 0.7;
  const auto pass = [&](double from) {
    double sum = 0;
    int n = 0;
    for (int i = 0; i < 900; ++i, time += 1e-3) {
      const BodyResult r = step_one(*t, time, 1e-3, ride.motion(from + 1e-3 * i, from + 1e-3 * (i + 1)));
      const double x = ride.speed * (from + 1e-3 * (i + 1));
      if (x > 0.2 && x < 0.5) sum += r.report.normal_force, ++n;
    }
    return sum / n;
  };
  const double first = pass(0);
  // Long after the wheel has gone (its soil is in store), the track lies low and the soil beside it does not.
  const auto mean_sinkage = [&](double y) {
    double sum = 0;
    for (int i = 0; i < 30; ++i)
      for (const double side : {-0.02, 0.0, 0.02}) sum += t->surface(0.1 + 0.006 * i, y + side).sinkage / 90;
    return sum;
  };
  // The wheel ran 15 mm deep; soil as coarse as this flows back to a quarter of that.
  EXPECT_GT(mean_sinkage(0), 0.002);
  EXPECT_LT(mean_sinkage(0.35), 1e-4);
  EXPECT_FALSE(t->take_changed_cells().empty());
  // Lifted, carried back and put down in front of its track, it meets less soil the second time.
  Ride clear = ride;
  clear.hub = kRadius + 0.05;
  step_one(*t, time, 1e-3, clear.motion(0.9, 0.901));
  time += 1e-3;
  step_one(*t, time, 1e-3, clear.motion(0, 1e-3));
  time += 1e-3;
  const double second = pass(0);
  EXPECT_LT(second, 0.7 * first);
}

TEST(Sphere, MeanForceDoesNotDependOnTheStepOfTheHost) {
  const auto mean = [](double dt) {
    const auto t = coarse_terrain();
    double time = 0;
    lower(*t, 0.012, time, dt);
    Ride ride;
    ride.hub = kRadius - 0.012;
    Vec3 sum = Vec3::Zero();
    const int n = static_cast<int>(std::lround(1 / dt));
    for (int i = 0; i < n; ++i, time += dt) {
      const BodyResult r = step_one(*t, time, dt, ride.motion(dt * i, dt * (i + 1)));
      if (dt * i > 0.3) sum += r.impulse / 0.7;
    }
    return sum;
  };
  const Vec3 fine = mean(5e-4), coarse = mean(2e-3);
  // One packing, but collisions part ways: half a dozen grains carry the wheel, and the mean over 0.14 m of them scatters by a tenth.
  EXPECT_NEAR(coarse.z(), fine.z(), 0.2 * fine.z());
  EXPECT_NEAR(coarse.x(), fine.x(), 0.2 * fine.z());
}

TEST(Sphere, SavedAndLoadedAcrossATileContinuesBitByBit) {
  const auto whole = coarse_terrain(), first = coarse_terrain(), second = coarse_terrain();
  Ride ride;
  ride.hub = kRadius - 0.01;
  ride.speed = 0.5;
  const auto drive = [&](Terrain& t, int from, int to) {
    for (int i = from; i < to; ++i) step_one(t, 1e-3 * i, 1e-3, ride.motion(1e-3 * i, 1e-3 * (i + 1)));
  };
  drive(*whole, 0, 400);
  drive(*first, 0, 220);
  State saved = state_of(*first);
  saved.rewind(State::Mode::load);
  second->traverse(saved);
  saved.finish();
  drive(*second, 220, 400);
  const auto d = State::first_difference(state_of(*whole), state_of(*second));
  EXPECT_FALSE(d) << d->field << '[' << d->index << "]: " << d->left << " became " << d->right;
}

std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const TerrainError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Sphere, NamesWhatItCannotCarry) {
  using testing::HasSubstr;
  Ride ride;
  ride.hub = kRadius;
  EXPECT_THAT(error_of([&] {
                const auto t = coarse_terrain(flat_ground(), 1,
                                              "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, capacity: 2}");
                step_one(*t, 0, 1e-3, ride.motion(0, 1e-3));
              }),
              HasSubstr("no grain is left"));
  EXPECT_THAT(error_of([&] {
                const auto t = coarse_terrain(flat_ground(0.1), 1,
                                              "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, datum: 0 m}");
                Ride high = ride;
                high.hub += 0.1;
                step_one(*t, 0, 1e-3, high.motion(0, 1e-3));
              }),
              HasSubstr("above the datum 0 m; soil was poured for a relief of 0.02 m"));
  EXPECT_THAT(error_of([&] {
                const auto t = coarse_terrain(flat_ground(), 2,
                                              "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, torus: 5}");
                std::vector<BodyMotion> m{ride.motion(0, 1e-3), ride.motion(0, 1e-3)};
                for (Pose* X : {&m[1].X_WB_begin, &m[1].X_WB_end}) X->p.x() += 0.4;
                std::vector<BodyResult> r(2);
                t->step(0, 1e-3, m, r);
              }),
              HasSubstr("too far apart for the torus of 5 x 5 bricks"));
}

}  // namespace
}  // namespace grouser::test
