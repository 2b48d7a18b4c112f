// Packing and the soil tests, at a size that runs in seconds.
#include "grouser/dem/soil_test.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace grouser;
using namespace grouser::dem;

SoilSettings constant_rolling(unsigned seed) {
  SoilSettings s;
  s.law.rolling = RollingCoefficient::constant;
  s.materials.pair(0, 0).rolling = 0.3;
  s.seed = seed;
  return s;
}

TEST(PouredBrick, HasTheBulkDensityAskedForAndTilesWithoutOverlap) {
  const Packing p = pour_periodic(constant_rolling(1), 0.05, 0.05, 0.03);
  double mass = 0;
  for (const GrainState& g : p.grains) mass += 4.0 / 3 * pi * std::pow(g.radius, 3) * g.density;
  EXPECT_NEAR(mass / (0.05 * 0.05 * p.height), 1600, 1e-6);
  // Fallen spheres fill between 50 and 64 %; the grains' density follows.
  EXPECT_GT(p.grains[0].density, 1600 / 0.64);
  EXPECT_LT(p.grains[0].density, 1600 / 0.48);
  const auto bed = tile(p.grains, 0.05, 0.05, 2, 2);
  EXPECT_EQ(bed.size(), 4 * p.grains.size());
  SolverSettings s;
  s.domain.hi = Vec3(0.1, 0.1, 0.2);
  s.domain.lo[2] = -0.01;
  Solver solver(s, bed);  // refuses overlap
  solver.add_floor();
  solver.step(1000);
  // Joined tiles stay at rest: no grain gets faster than its settling.
  EXPECT_LT(std::sqrt(2 * solver.kinetic_energy() / (4 * mass)), 0.01);
}

TEST(PouredBricks, OfTheSameSeedAreTheSameAndOfAnotherAreNot) {
  const Packing a = pour_periodic(constant_rolling(3), 0.03, 0.03, 0.02),
                b = pour_periodic(constant_rolling(3), 0.03, 0.03, 0.02),
                c = pour_periodic(constant_rolling(4), 0.03, 0.03, 0.02);
  ASSERT_EQ(a.grains.size(), b.grains.size());
  for (std::size_t k = 0; k < a.grains.size(); ++k) EXPECT_EQ(a.grains[k].x, b.grains[k].x);
  EXPECT_NE(a.grains[0].x, c.grains[0].x);
}

TEST(DirectShear, CarriesItsLoadAndResistsBetweenSmoothAndInterlocked) {
  ShearSettings t;
  t.side = 0.04;
  t.height = 0.04;
  t.pressure = 5000;
  t.rate = 0.02;
  t.displacement = 4e-3;
  t.samples = 10;
  const ShearCurve c = direct_shear(constant_rolling(1), t);
  ASSERT_EQ(c.shear.size(), 10u);
  EXPECT_NEAR(c.displacement.back(), 3.8e-3, 1e-9);
  double mean = 0, normal = 0;
  for (std::size_t k = 5; k < 10; ++k) mean += c.shear_total[k] / 5;
  for (double n : c.normal) normal += n / 10;
  // The impulse of the plate is its weight's, up to its own momentum: 0.8 kg at a few cm/s over 0.2 s.
  EXPECT_NEAR(normal, 5000, 100);
  // Friction angles of sand-like packings, 15 to 60 degrees: the test looks for gross mistakes only.
  EXPECT_GT(mean, 0.27 * 5000);
  EXPECT_LT(mean, 1.73 * 5000);
}

TEST(PressureSinkage, RisesWithDepth) {
  SinkageSettings t;
  t.bin_x = t.bin_y = 0.08;
  t.brick = 0.04;
  t.depth = 0.05;
  t.plate_x = t.plate_y = 0.03;
  t.rate = 0.05;
  t.sinkage = 0.008;
  t.samples = 8;
  const SinkageCurve c = pressure_sinkage(constant_rolling(1), t);
  // A plate three grains wide sits on single force chains, so one sample may fall; halves of the path differ by more.
  // Six packings gave 2.2 to 7 between the means of the two halves.
  double first = 0, last = 0;
  for (std::size_t k = 0; k < 8; ++k) (k < 4 ? first : last) += c.pressure[k] / 4;
  EXPECT_GT(last, 1.5 * first);
  EXPECT_GT(last, 1000);
  EXPECT_NEAR(c.sinkage[7] - c.sinkage[6], (c.sinkage[7] - c.sinkage[0]) / 7, 1e-9);
}

}  // namespace
