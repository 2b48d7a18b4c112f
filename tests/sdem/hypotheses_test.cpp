// Why the published surrogate sinks as it does, on tables made from grains (examples/14_surrogate, coarse): hypotheses 1 and 2 of the design.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "grouser/sdem/locomotion.h"
#include "grouser/terrain/terrain.h"

namespace grouser::test {
namespace {

struct Mean {
  double sinkage = 0, down = 0;  ///< [m], [-] upward force at the slowest downward node over the weight
};

/// Over the last 60 % of 0.25 m of the coarse wheel (20 N) at this slip and dead band.
Mean drive(const std::shared_ptr<const sdem::Tables>& t, double slip, double band) {
  sdem::LocomotionCase c;
  c.slip = slip;
  c.spin = 0.8;
  c.mass = 2.04;
  c.width = t->width;
  c.distance = 0.25;
  c.slice.dead_band = band;
  c.slice.floor = -t->bed_depth;
  for (const double v : t->vz)
    if (v < 0) c.probe_vz = v;
  Mean m;
  int n = 0;
  for (const sdem::LocomotionSample& s : sdem::run_locomotion(t, c).samples)
    if (s.s >= 0.4 * c.distance) {
      m.sinkage += s.sinkage;
      m.down += s.fz_probe / (c.mass * c.gravity);
      ++n;
    }
  m.sinkage /= n;
  m.down /= n;
  return m;
}

const std::filesystem::path kTables =
    std::filesystem::path(GROUSER_SOURCE_DIR) / "examples" / "14_surrogate" / "coarse_tables.h5";

// Hypothesis 1: the step of a rate-independent soil at vz = 0 is a ramp between the nodes -v1 and v1, so a wheel comes to rest not where the
// soil bears its weight but where it bears 2 v1/(v1 + b) of it at -v1 (b: dead band), if it bears nothing at v1. It bears a little there,
// so the share is less than that; it must be well above 1 and grow with slip as b falls.
TEST(PublishedSinkage, RestsWhereTheTableBearsMoreThanTheWeight) {
  const auto t = std::make_shared<const sdem::Tables>(sdem::Tables::read(kTables));
  const double v1 = 0.01, band = 0.05;
  double before = 1;
  for (const double slip : {-0.5, -0.3, 0.0, 0.3, 0.5}) {
    const double b = band * (1 - slip) * t->radius * 0.8, expected = 2 * v1 / (v1 + b);
    const Mean m = drive(t, slip, band);
    EXPECT_GT(m.down, before) << slip;
    EXPECT_GT(m.down / expected, 0.85) << slip;
    EXPECT_LT(m.down / expected, 1.0) << slip;
    before = m.down;
  }
  EXPECT_GT(before, 1.4);
}

// Hypothesis 2: the dead band stops sinking that is slower than it; without it the same wheel goes 1 to 6 mm deeper in a quarter of a metre.
TEST(PublishedSinkage, TheDeadBandHidesMillimetres) {
  const auto t = std::make_shared<const sdem::Tables>(sdem::Tables::read(kTables));
  for (const double slip : {-0.5, 0.0, 0.5}) {
    const double more = drive(t, slip, 0).sinkage - drive(t, slip, 0.05).sinkage;
    EXPECT_GT(more, 1e-3) << slip;
    EXPECT_LT(more, 6e-3) << slip;
  }
}

// Without the ramp, with the soil bearing at and above no vertical velocity what it bears at the slowest downward node, the same wheel rests
// where the soil bears its weight: hypothesis 1 turned round.
TEST(PublishedSinkage, WithoutTheRampTheSoilBearsTheWeight) {
  auto step = sdem::Tables::read(kTables);
  std::size_t down = 0;
  while (step.vz[down + 1] < 0) ++down;
  sdem::Grid& g = step.part(sdem::Part::wheel_bottom);
  for (std::size_t w = 0; w < step.w.size(); ++w)
    for (std::size_t x = 0; x < step.vx.size(); ++x)
      for (std::size_t k = 0; k < g.plane(); ++k) {
        const std::size_t from = step.node(w, x, down) * g.plane() + k, to = step.node(w, x, down + 1) * g.plane() + k;
        g.x[to] = g.x[from];
        g.z[to] = g.z[from];
      }
  const auto t = std::make_shared<const sdem::Tables>(step);
  for (const double slip : {-0.3, 0.0, 0.3}) EXPECT_NEAR(drive(t, slip, 0.05).down, 1, 0.04) << slip;
}

TEST(PublishedSinkage, AWheelThatLeavesTheTablesIsNamed) {
  const auto t = std::make_shared<const sdem::Tables>(sdem::Tables::read(kTables));
  sdem::LocomotionCase c;
  c.slip = 0.5;
  c.spin = 0.8;
  c.mass = 2.04;
  c.width = t->width;
  c.distance = 0.25;
  c.slice.floor = -t->bed_depth;
  EXPECT_NO_THROW(run_locomotion(t, c));
  c.slice.gate = false;
  try {
    run_locomotion(t, c);
    FAIL();
  } catch (const TerrainError& e) {
    EXPECT_NE(std::string(e.what()).find("sinks out of the tables"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("the tables begin at 0.14 m"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace grouser::test
