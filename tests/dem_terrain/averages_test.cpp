// Averages for a surrogate: they do not change the run, and say what the run says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "dem_terrain/coarse.h"
#include "grouser/terrain/recorder.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

void ride(Terrain& t) {
  Ride down;
  down.hub = kRadius + 0.005;
  down.speed = 0.3;
  down.sink = 0.05;
  for (int i = 0; i < 300; ++i) step_one(t, 1e-3 * i, 1e-3, down.motion(1e-3 * i, 1e-3 * (i + 1)));
}
const char* options = "depth: 50 mm, relief: 20 mm, brick: 80 mm, reach: 60 mm";

struct SphereAverages : testing::Test {
  fs::path folder;
  SphereAverages() {
    folder = fs::path(testing::TempDir()) /
             ("sphere_averages_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  std::string with(const std::string& more) const {
    return "{" + std::string(options) + ", averages: '" + (folder / "a.h5").string() + "'" + more + "}";
  }
};

TEST_F(SphereAverages, LeaveTheRunAsItIsBitByBit) {
  const auto plain = coarse_terrain(flat_ground(), 1, "{" + std::string(options) + "}"),
             recorded = coarse_terrain(flat_ground(), 1, with(""));
  ride(*plain);
  ride(*recorded);
  const auto d = State::first_difference(state_of(*plain), state_of(*recorded));
  EXPECT_FALSE(d) << d->field << '[' << d->index << ']';
}

TEST_F(SphereAverages, AreTakenEveryStatedWayOverTheStatedWay) {
  {
    const auto t = coarse_terrain(flat_ground(), 1, with(""));
    ride(*t);
  }
  const RunFile f(folder / "a.h5");
  const std::vector<double> x = f.read("hub_position"), v = f.read("hub_velocity"), spin = f.read("spin");
  // 0.3 m/s along and 0.05 m/s down for 0.3 s: 91.2 mm, a window every 2.5 mm from the first on.
  ASSERT_EQ(f.frames(), 37u);
  for (std::size_t k = 0; k < f.frames(); ++k) {
    const double way = std::hypot(x[3 * k], x[3 * k + 2] - (kRadius + 0.005));
    // Middle of the window; a step of the solver (0.27 ms) is 0.08 mm of way.
    EXPECT_NEAR(way, 2.5e-3 * static_cast<double>(k) + 0.125e-3, 0.12e-3) << k;
    EXPECT_NEAR(v[3 * k], 0.3, 1e-9);
    EXPECT_NEAR(v[3 * k + 2], -0.05, 1e-9);
    EXPECT_NEAR(spin[k], 0.3 / 0.8 / kRadius, 1e-9);
  }
  EXPECT_THAT(f.attributes().scenario, testing::HasSubstr("diameter_largest_m 0.018"));
  EXPECT_EQ(f.attribute("inputs_hash").size(), 16u);
}

TEST_F(SphereAverages, PressuresSumUpToTheForceOnTheWheel) {
  {
    const auto t = coarse_terrain(flat_ground(), 1, with(", averaged_over: 2 mm"));
    ride(*t);
  }
  const RunFile f(folder / "a.h5");
  const std::vector<double> force = f.read("force"), angle = f.read("angle"), p = f.read("pressure");
  const std::size_t bins = angle.size();
  double lift = 0, seen = 0, pull = 0, seen_pull = 0;
  for (std::size_t k = 15; k < f.frames(); ++k) {
    lift += force[3 * k + 2];
    pull += force[3 * k];
    for (std::size_t b = 0; b < bins; ++b) {
      const double area = kRadius * 2 * pi / static_cast<double>(bins) * kWidth;
      const double* q = &p[3 * (k * bins + b)];
      seen += area * (q[0] * std::cos(angle[b]) + q[1] * std::sin(angle[b]));
      seen_pull += area * (-q[0] * std::sin(angle[b]) + q[1] * std::cos(angle[b]));
    }
  }
  // Springs without dampers, and samples instead of every step: a few per cent, of the whole force along as well.
  EXPECT_NEAR(seen, lift, 0.1 * lift);
  EXPECT_NEAR(seen_pull, pull, 0.1 * lift);
  EXPECT_GT(lift, 0);
}

TEST_F(SphereAverages, KeepGrainsWhereTheyAre) {
  {
    const auto t = coarse_terrain(flat_ground(), 1, with(""));
    ride(*t);
  }
  const RunFile f(folder / "a.h5");
  const std::vector<double> hub = f.read("hub_position"), x = f.read("grains.36.position"),
                            r = f.read("grains.36.radius"), v = f.read("grains.36.velocity");
  ASSERT_GT(r.size(), 100u);
  double fastest = 0;
  int ahead = 0, behind = 0;
  for (std::size_t k = 0; k < r.size(); ++k) {
    EXPECT_GE(r[k], 0.007 - 1e-7);
    EXPECT_LE(r[k], 0.009 + 1e-7);
    // No centre inside the wheel; it is forced 10 mm into grains so soft that they give way by a fifth of their radius.
    const double d = std::hypot(x[3 * k] - hub[3 * 36], x[3 * k + 2] - hub[3 * 36 + 2]);
    if (std::abs(x[3 * k + 1]) < 0.5 * kWidth) {
      EXPECT_GT(d, kRadius + 0.5 * r[k]);
    }
    fastest = std::max(fastest, std::hypot(v[3 * k], v[3 * k + 2]));
    ++(x[3 * k] > hub[3 * 36] ? ahead : behind);
  }
  // Grains move, none much faster than the rim; both sides of the wheel are there.
  EXPECT_GT(fastest, 0.02);
  EXPECT_LT(fastest, 1.0);
  EXPECT_GT(ahead, 20);
  EXPECT_GT(behind, 20);
}

TEST_F(SphereAverages, RefuseAFileThatIsThereAndASecondWheel) {
  {
    const auto t = coarse_terrain(flat_ground(), 1, with(""));
    ride(*t);
  }
  EXPECT_THAT([&] { ride(*coarse_terrain(flat_ground(), 1, with(""))); },
              testing::ThrowsMessage<ResultsError>(testing::HasSubstr("is there already")));
  EXPECT_THAT([&] { coarse_terrain(flat_ground(), 2, with("")); },
              testing::ThrowsMessage<TerrainError>(testing::HasSubstr("one wheel")));
}

}  // namespace
}  // namespace grouser::test
