// Beds on disk, cut and frozen, and the two tests that need no plate: heap and oedometer.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>

#include "grouser/dem/soil_test.h"
#include "grouser/terrain/recorder.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

SoilSettings coarse(double rolling, unsigned seed = 1) {
  SoilSettings s;
  s.smallest = 0.006;
  s.law.rolling = RollingCoefficient::constant;
  s.materials.pair(0, 0).rolling = rolling;
  s.seed = seed;
  s.dt = 1e-5;
  return s;
}

std::filesystem::path scratch(const char* name) {
  return std::filesystem::temp_directory_path() / ("grouser-bed-" + std::to_string(::getpid()) + name);
}

TEST(Bed, ComesBackFromDiskBitForBit) {
  Packing p = pour_periodic(coarse(0.3), 0.04, 0.04, 0.03);
  freeze_edges(p, 0, 0.005);
  const auto file = scratch(".h5");
  write_bed(p, file, "test");
  const Packing q = read_bed(file);
  std::filesystem::remove(file);
  EXPECT_EQ(p.inputs, q.inputs);
  EXPECT_EQ(p.height, q.height);
  ASSERT_EQ(p.grains.size(), q.grains.size());
  for (std::size_t k = 0; k < p.grains.size(); ++k) {
    EXPECT_EQ(p.grains[k].x, q.grains[k].x);
    EXPECT_EQ(p.grains[k].radius, q.grains[k].radius);
    EXPECT_EQ(p.grains[k].density, q.grains[k].density);
    EXPECT_EQ(p.grains[k].frozen, q.grains[k].frozen);
  }
}

/// The same places and spins, bit by bit.
void expect_same(const Packing& a, const Packing& b) {
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.settle_time, b.settle_time);
  EXPECT_EQ(a.residual_speed, b.residual_speed);
  ASSERT_EQ(a.grains.size(), b.grains.size());
  for (std::size_t k = 0; k < a.grains.size(); ++k) {
    EXPECT_EQ(a.grains[k].x, b.grains[k].x);
    EXPECT_EQ(a.grains[k].density, b.grains[k].density);
  }
}

TEST(Pouring, GoesOnFromAnyPieceWithTheSameBits) {
  // Saved while falling, pressed and let go again, and continued by another object each time.
  SoilSettings soil = coarse(0.3);
  PourSettings p;
  p.lx = p.ly = 0.04;
  p.height = 0.02;
  p.compaction = 5e3;
  Pouring whole(soil, p);
  int pieces = 1;
  while (whole.advance()) ++pieces;
  auto part = std::make_unique<Pouring>(soil, p);
  for (int k = 1; part->advance(); ++k) {
    if (k % 7 != 3) continue;
    State s;
    part->traverse(s);
    part = std::make_unique<Pouring>(soil, p);
    s.rewind(State::Mode::load);
    part->traverse(s);
    s.finish();
  }
  expect_same(whole.packing(), part->packing());
  EXPECT_GT(pieces, 15);
}

TEST(Pouring, ThatWasKilledIsContinuedFromTheCheckpointOfTheCache) {
  const auto folder = scratch("-killed");
  std::filesystem::create_directories(folder);
  PourSettings p;
  p.lx = p.ly = 0.04;
  p.height = 0.02;
  const Packing whole = pour(coarse(0.3), p);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    // After every piece a checkpoint; gone in the middle, without a word.
    int piece = 0;
    cached_packing(
        coarse(0.3), p, folder,
        [&](double, double) {
          if (++piece == 8) ::kill(::getpid(), SIGKILL);
        },
        0);
    ::_exit(3);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  int pieces = 0, of_whole = 0;
  cached_packing(coarse(0.3), p, scratch("-other"), [&](double, double) { ++of_whole; });
  const Packing again = cached_packing(coarse(0.3), p, folder, [&](double, double) { ++pieces; });
  expect_same(whole, again);
  EXPECT_EQ(pieces, of_whole - 7);
  // Nothing but the bed is left.
  int files = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(folder)) ++files;
  EXPECT_EQ(files, 1);
  std::filesystem::remove_all(folder);
  std::filesystem::remove_all(scratch("-other"));
}

TEST(Slab, StandsBetweenItsWallsAndIsPeriodicAlongX) {
  PourSettings p;
  p.lx = 0.05;
  p.ly = 0.03;
  p.height = 0.03;
  p.slab = true;
  const Packing slab = pour(coarse(0.3), p);
  EXPECT_TRUE(slab.slab);
  double across = 0;
  for (const GrainState& g : slab.grains) {
    // Walls give way by micrometres.
    EXPECT_GT(g.x[1], g.radius - 2e-5);
    EXPECT_LT(g.x[1], p.ly - g.radius + 2e-5);
    const double x = g.x[0] - p.lx * std::floor(g.x[0] / p.lx);
    across += x < g.radius || x > p.lx - g.radius;
  }
  EXPECT_GT(across, 0);
  const auto file = scratch("-slab.h5");
  write_bed(slab, file, "test");
  EXPECT_TRUE(read_bed(file).slab);
  std::filesystem::remove(file);
  EXPECT_NO_THROW(tile(slab, 2, 1));
  EXPECT_THROW(tile(slab, 1, 2), DemError);
}

TEST(Bed, FromTheCacheIsTheOnePoured) {
  const auto folder = scratch("-cache");
  PourSettings pour_as;
  pour_as.lx = pour_as.ly = 0.04;
  pour_as.height = 0.02;
  const Packing a = cached_packing(coarse(0.3), pour_as, folder), b = cached_packing(coarse(0.3), pour_as, folder),
                c = cached_packing(coarse(0.3, 2), pour_as, folder);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(folder)) ++files;
  std::filesystem::remove_all(folder);
  EXPECT_EQ(files, 2u);
  ASSERT_EQ(a.grains.size(), b.grains.size());
  for (std::size_t k = 0; k < a.grains.size(); ++k) EXPECT_EQ(a.grains[k].x, b.grains[k].x);
  EXPECT_NE(a.grains[0].radius, c.grains[0].radius);
}

TEST(Bed, PorosityOfLayersAddsUpToTheSolidVolume) {
  // One sphere of 1 cm radius in a box of 4 x 4 x 2 cm: the layers' solid volumes are spherical segments.
  Packing p;
  p.lx = p.ly = 0.04;
  p.height = 0.02;
  GrainState g;
  g.radius = 0.01;
  g.x = Vec3(0.02, 0.02, 0.01);
  p.grains = {g};
  const std::vector<double> n = porosity_profile(p, 2);
  EXPECT_NEAR(n[0], 1 - 2.0 / 3 * pi * 1e-6 / 1.6e-5, 1e-12);
  EXPECT_NEAR(n[1], n[0], 1e-12);
  // A quarter of the height: a cap of half the radius, 5/24 pi r^3.
  EXPECT_NEAR(porosity_profile(p, 4)[0], 1 - 5.0 / 24 * pi * 1e-6 / 0.8e-5, 1e-12);
}

TEST(Bed, PressedIsDenserThanPoured) {
  PourSettings loose, pressed;
  loose.lx = loose.ly = pressed.lx = pressed.ly = 0.04;
  loose.height = pressed.height = 0.04;
  pressed.compaction = 2e4;
  SoilSettings s = coarse(0.3);
  s.bulk_density = 0;
  EXPECT_GT(pour(s, pressed).bulk_density, 1.01 * pour(s, loose).bulk_density);
}

TEST(Bed, IsCutToTheSurfaceAskedFor) {
  const Packing whole = pour_periodic(coarse(0.3), 0.04, 0.04, 0.04);
  Packing p = tile(whole, 3, 1);
  cut_surface(p, [](double x, double) { return 0.02 + 0.005 * std::sin(2 * pi * x / 0.12); });
  EXPECT_LT(p.grains.size(), 3 * whole.grains.size());
  for (const GrainState& g : p.grains) EXPECT_LE(g.x[2], 0.02 + 0.005 * std::sin(2 * pi * g.x[0] / 0.12));
  EXPECT_THROW(cut_surface(p, [](double, double) { return -1.0; }), DemError);
}

TEST(AngleOfRepose, IsSteeperWhereGrainsCannotRoll) {
  ReposeSettings t;
  t.base_x = 0.05;
  t.base_y = 0.03;
  t.height = 0.05;
  t.lift = 0.2;
  t.duration = 0.8;
  t.samples = 8;
  const auto angle = [&](double rolling) {
    const auto run = make_angle_of_repose(coarse(rolling), pour(coarse(rolling), pour_settings(t)), t);
    while (run->advance()) {
    }
    return run->table().column("angle_deg").back();
  };
  const double free = angle(0), held = angle(0.5);
  // Spheres that roll freely heap at 15 to 25 degrees at most; sands and grains that resist rolling at 25 to 45.
  EXPECT_LT(free, 26);
  EXPECT_GT(held, free + 3);
}

TEST(Oedometer, LoadIsCarriedAndUnloadingGivesBackAPartOnly) {
  OedometerSettings t;
  t.side = 0.04;
  t.height = 0.025;
  t.pressures = {5e3, 4e4, 5e3};
  t.hold = 0.2;
  const auto run = make_oedometer(coarse(0.3), pour(coarse(0.3), pour_settings(t)), t);
  while (run->advance()) {
  }
  const std::vector<double> strain = run->table().column("strain"), e = run->table().column("void_ratio");
  ASSERT_EQ(strain.size(), 3u);
  EXPECT_GT(strain[1], 0.005);
  EXPECT_LT(strain[2], 0.9 * strain[1]);
  EXPECT_GT(strain[2], 0.05 * strain[1]);
  // Void ratio and strain tell the same: 1 + e goes with the height.
  EXPECT_NEAR((1 + e[1]) / (1 + e[0]), 1 - strain[1], 1e-9);
}

}  // namespace
