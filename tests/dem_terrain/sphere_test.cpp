// dem.sphere as a terrain: forces on a wheel, momentum, memory, borders of what moves, state, errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "dem_terrain/coarse.h"
#include "grouser/terrain/soil_points.h"

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
  // Grains as coarse as these flow back, one packing more than another: means over three.
  double first = 0, second = 0, rut = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    const auto t =
        coarse_terrain(flat_ground(), 1,
                       "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, period: [0.24 m, 0.24 m], seed: " +
                           std::to_string(seed) + "}");
    double time = 0;
    lower(*t, 0.02, time);
    Ride ride;
    ride.hub = kRadius - 0.02;
    ride.speed = 0.7;
    const auto pass = [&](double from) {
      double sum = 0;
      int n = 0;
      for (int i = 0; i < 600; ++i, time += 1e-3) {
        const BodyResult r = step_one(*t, time, 1e-3, ride.motion(from + 1e-3 * i, from + 1e-3 * (i + 1)));
        const double x = ride.speed * (from + 1e-3 * (i + 1));
        if (x > 0.1 && x < 0.3) sum += r.report.normal_force, ++n;
      }
      return sum / n;
    };
    first += pass(0) / 3;
    // Long after the wheel has gone (its soil is in store), the track lies low and the soil beside it does not.
    const auto mean_sinkage = [&](double y) {
      double sum = 0;
      for (int i = 0; i < 40; ++i)
        for (const double side : {-0.03, -0.015, 0.0, 0.015, 0.03})
          sum += t->surface(0.06 + 0.006 * i, y + side).sinkage / 200;
      return sum;
    };
    rut += mean_sinkage(0) / 3;
    EXPECT_LT(mean_sinkage(0.35), 1e-4);
    EXPECT_FALSE(t->take_changed_cells().empty());
    // Lifted, carried back and put down in front of its track, it meets less soil the second time.
    Ride clear = ride;
    clear.hub = kRadius + 0.05;
    step_one(*t, time, 1e-3, clear.motion(0.6, 0.601));
    time += 1e-3;
    step_one(*t, time, 1e-3, clear.motion(0, 1e-3));
    time += 1e-3;
    second += pass(0) / 3;
  }
  // The wheel ran 20 mm deep; most of it flows back behind it, and single packings differ by 2 mm.
  EXPECT_GT(rut, 0.001);
  EXPECT_LT(second, 0.85 * first);
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

TEST(Sphere, SlipsWithoutTorqueWhereGrainsAndWheelHaveNoFriction) {
  const std::string ch4 = kCoarseSoil;
  std::string ch3 = ch4;
  // Stiffness as of 2 MPa: k_n = 4/3 E*, k_t = 8 G*; damping of the order of e = 0.4 for grains this large and soft.
  ch3.replace(ch3.find("  restitution"), 0,
              "  model: hertz-ch3\n  normal_stiffness: 1.52 MPa\n  shear_stiffness: 1.8 MPa\n  gamma_n: 1e6 1/(m s)\n  "
              "gamma_t: "
              "1e6 1/(m s)\n  cohesion: 500 J/m^3\n");
  for (const std::string& soil : {ch4, ch3}) {
    const auto mean = [&](const std::string& wheel) {
      const auto t = coarse_terrain(flat_ground(), 1,
                                    "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, period: [80 mm, 80 mm]}",
                                    coarse_wheel(), soil + wheel);
      double time = 0, torque = 0, load = 0;
      lower(*t, 0.012, time);
      Ride ride;
      ride.hub = kRadius - 0.012;
      ride.slip = 0.5;
      for (int i = 0; i < 200; ++i, time += 1e-3) {
        const BodyResult r = step_one(*t, time, 1e-3, ride.motion(1e-3 * i, 1e-3 * (i + 1)));
        torque += r.report.driving_torque / 200;
        load += r.report.normal_force / 200;
      }
      return std::pair(torque, load);
    };
    const auto [smooth, carried] = mean("  wheel: {friction: 0, rolling_coefficient: 0, cohesion: 0 J/m^3}\n");
    const auto [rough, held] = mean("");
    EXPECT_GT(carried, 5);
    // Radial forces have no moment about the hub, whatever the soil does: rounding of sums in single precision.
    EXPECT_NEAR(smooth, 0, 1e-4 * carried * kRadius);
    EXPECT_GT(rough, 0.1 * held * kRadius);
  }
}

/// Lengths along x and y of the soil that moves under a wheel that stands along x [m], and the impulse on it.
struct Patch {
  double x = 0, y = 0;
  Vec3 impulse = Vec3::Zero();
};
Patch patch_of(const std::string& reach) {
  const auto t = coarse_terrain(flat_ground(0.3), 1,
                                "{depth: 50 mm, relief: 20 mm, brick: 80 mm, period: [80 mm, 80 mm], " + reach + "}");
  BodyMotion m;
  m.X_WB_begin = m.X_WB_end = Pose{Vec3(0.04, 0.04, 0.3 + kRadius - 0.005), Quat::Identity()};
  Patch p;
  p.impulse = step_one(*t, 0, 1e-3, m).impulse;
  Vec2 lo(1e9, 1e9), hi = -lo;
  for (const auto& g : dynamic_cast<const SoilPoints&>(*t).soil_points(1000000)) {
    lo = lo.cwiseMin(Vec2(g[0], g[1]));
    hi = hi.cwiseMax(Vec2(g[0], g[1]));
  }
  p.x = hi.x() - lo.x();
  p.y = hi.y() - lo.y();
  return p;
}

TEST(Sphere, LengthAndWidthOfThePatchAreSetApart) {
  // 160 mm more of reach are two bricks of 80 mm more on either side, 320 mm; a grain may lie 10 mm off a brick's border.
  const Patch both = patch_of("reach: 60 mm"),
              apart = patch_of("reach: 10 mm, reach_along: 60 mm, reach_across: 60 mm"),
              longer = patch_of("reach: 60 mm, reach_along: 220 mm"),
              wider = patch_of("reach: 60 mm, reach_across: 220 mm");
  EXPECT_EQ(both.impulse, apart.impulse);
  EXPECT_EQ(both.x, apart.x);
  EXPECT_NEAR(longer.x - both.x, 0.32, 0.02);
  EXPECT_NEAR(longer.y - both.y, 0, 0.02);
  EXPECT_NEAR(wider.y - both.y, 0.32, 0.02);
  EXPECT_NEAR(wider.x - both.x, 0, 0.02);
}

TEST(Sphere, ShowsTheGrainsOfTheTwoUpperLayersNearTheWheelWhereTheyAreInTheWorld) {
  // Far from the origin, beyond several lengths of the torus.
  const auto t = coarse_terrain(flat_ground(0.3), 1,
                                "{depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm, period: [80 mm, 80 mm]}");
  const double x = 7.3, y = -4.1;
  for (int i = 0; i < 20; ++i) {
    BodyMotion m;
    const auto pose = [&](int k) { return Pose{Vec3(x + 1e-4 * k, y, 0.3 + kRadius - 0.005), Quat::Identity()}; };
    m.X_WB_begin = pose(i);
    m.X_WB_end = pose(i + 1);
    m.V_WB_end.v = Vec3(0.1, 0, 0);
    step_one(*t, 1e-3 * i, 1e-3, m);
  }
  const auto* soil = dynamic_cast<const SoilPoints*>(t.get());
  ASSERT_NE(soil, nullptr);
  const auto all = soil->soil_points(100000), few = soil->soil_points(40);
  ASSERT_EQ(few.size(), 40u);
  ASSERT_GT(all.size(), 200u);
  const auto far = [&](const std::array<double, 4>& p) {
    return std::hypot(p[0] - (x + 2e-3), p[1] - y, p[2] - (0.3 + kRadius - 0.005));
  };
  double nearest_left_out = 1e9, farthest_kept = 0;
  for (const auto& p : few) farthest_kept = std::max(farthest_kept, far(p));
  std::size_t within = 0;
  for (const auto& p : all) {
    // Contact, reach and a brick on every side, no more.
    EXPECT_LT(std::abs(p[0] - x), 0.3);
    EXPECT_LT(std::abs(p[1] - y), 0.3);
    EXPECT_GT(p[2], 0.3 - 2 * 0.018 - 1e-9);
    EXPECT_LT(p[2], 0.3 + 0.018);
    EXPECT_GE(p[3], 0.007 - 1e-9);
    EXPECT_LE(p[3], 0.009 + 1e-9);
    if (far(p) <= farthest_kept + 1e-9)
      ++within;
    else
      nearest_left_out = std::min(nearest_left_out, far(p));
  }
  // The few are the nearest to the hub at the end.
  EXPECT_EQ(within, 40u);
  EXPECT_GT(nearest_left_out, farthest_kept);
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
