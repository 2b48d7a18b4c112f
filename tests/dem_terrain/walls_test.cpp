// dem.sphere as a slab between two walls: grains stay between them, what they push, widths, state, threads, what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "dem_terrain/slab.h"
#include "grouser/dem/packing.h"
#include "grouser/dem/soil_config.h"
#include "grouser/terrain/soil_points.h"

namespace grouser::test {
namespace {

using testing::HasSubstr;

constexpr double kBetween = 0.0625;              // [m] three and a half of the largest grains
constexpr double kYoung = 2e6, kPoisson = 0.35;  // of kCoarseSoil, [Pa], [1]

std::string walls_options(const std::string& more = ", depth: 50 mm", const std::string& sides = "walls") {
  return "{relief: 20 mm, slab: 62.5 mm, brick: 125 mm, reach: 60 mm, torus: 8, "
         "period: [0.5 m, 62.5 mm], sides: " +
         sides + more + "}";
}
/// The coarse soil with smooth walls.
std::string smooth_soil() {
  std::string soil = kCoarseSoil;
  const std::string rough = "wall: {friction: 0.6", smooth = "wall: {friction: 0";
  return soil.replace(soil.find(rough), rough.size(), smooth);
}
std::unique_ptr<Terrain> between_walls(double width = kBetween, const std::string& more = ", depth: 50 mm") {
  return coarse_terrain(flat_ground(), 1, walls_options(more), {"wheel", SmoothCylinder{kRadius, width}},
                        smooth_soil());
}
const dem::SlabWalls& walls_of(const Terrain& t) { return dynamic_cast<const dem::SlabWalls&>(t); }

TEST(Walls, GrainsStayBetweenThem) {
  // Shown are grains down to 36 mm: with a depth of 30 mm all that move.
  const auto t = between_walls(kBetween, ", depth: 30 mm");
  double most = 0, before[2] = {};
  for (int i = 0; i < 1500; ++i) {
    roll_slab(*t, i, i + 1);
    for (std::size_t k : {0, 1}) {
      const double now = std::abs(walls_of(*t).wall_impulses()[k].y());
      most = std::max(most, (now - before[k]) / kStep);
      before[k] = now;
    }
  }
  // No grain is deeper in a wall than Hertz says of the largest one bearing all that a wall ever bore (walls as stiff as grains).
  const double stiff = 4.0 / 3 * kYoung / (2 * (1 - kPoisson * kPoisson)) * std::sqrt(0.009),
               deepest = std::pow(most / stiff, 2.0 / 3);
  ASSERT_LT(deepest, 0.006) << "a grain that has left lies a radius off or more";
  std::size_t seen = 0;
  for (const auto& g : dynamic_cast<const SoilPoints&>(*t).soil_points(100000)) {
    ASSERT_LE(std::abs(g[1]) + g[3], 0.5 * kBetween + deepest) << "x " << g[0] << ", z " << g[2];
    ++seen;
  }
  EXPECT_GT(seen, 50U);
  // There is no soil beyond, and so no rut.
  for (const double x : {0.1, 0.2, 0.3}) {
    EXPECT_EQ(t->surface(x, 0.04).sinkage, 0);
    EXPECT_NE(t->surface(x, 0.01).sinkage, 0);
  }
}

TEST(Walls, ThatAreSmoothArePushedOutwardAndNoOtherWay) {
  const auto t = between_walls();
  roll_slab(*t, 0, 300);
  const auto before = walls_of(*t).wall_impulses();
  const std::vector<BodyResult> r = roll_slab(*t, 300, 1300);
  const auto after = walls_of(*t).wall_impulses();
  const double time = 1000 * kStep;
  const Vec3 right = (after[0] - before[0]) / time, left = (after[1] - before[1]) / time;
  EXPECT_LT(right.y(), 0);
  EXPECT_GT(left.y(), 0);
  for (const Vec3& f : {right, left}) {
    EXPECT_EQ(f.x(), 0);
    EXPECT_EQ(f.z(), 0);
  }
  // What they do not balance between them, wheel and frozen grains bear.
  EXPECT_NEAR(-right.y(), left.y(), 0.25 * left.y());
  // Soil under a wheel pushes aside with a part of what it bears.
  const double borne = mean_force(r, 0).z();
  EXPECT_GT(left.y(), 0.1 * borne);
  EXPECT_LT(left.y(), 3 * borne);
}

TEST(Walls, AreNotThereWithoutTheOption) {
  const auto t = slab();
  roll_slab(*t, 0, 50);
  for (const Vec3& impulse : walls_of(*t).wall_impulses()) EXPECT_EQ(impulse, Vec3::Zero());
}

TEST(Walls, ForcesAreThoseOfTheWheelsWidthAndDoNotDependOnItsPlace) {
  const auto one = between_walls(0.5 * kBetween), two = between_walls(kBetween), moved = between_walls(kBetween),
             period = between_walls(kBetween);
  const auto a = roll_slab(*one, 0, 200), b = roll_slab(*two, 0, 200), c = roll_slab(*moved, 0, 200, 0, 0.015625),
             d = roll_slab(*period, 0, 200, 1.0);
  for (std::size_t k = 0; k < 200; ++k) {
    ASSERT_EQ(b[k].impulse, 2 * a[k].impulse) << k;
    ASSERT_EQ(b[k].impulse, d[k].impulse) << k;
    // A place along y is a number of the solver's too: rounding only.
    ASSERT_NEAR((b[k].impulse - c[k].impulse).norm(), 0, 1e-3 * b[k].impulse.norm()) << k;
  }
  EXPECT_EQ(walls_of(*two).wall_impulses()[1].y(), 2 * walls_of(*one).wall_impulses()[1].y());
  EXPECT_GT(mean_force(b, 100).z(), 5);
}

TEST(Walls, SavedAndLoadedContinuesBitByBitOnAnyThreads) {
  expect_same_bits_after_load_and_on_two_threads([] { return between_walls(); },
                                                 [](const Terrain& t, const Terrain& whole) {
                                                   EXPECT_EQ(walls_of(t).wall_impulses()[0],
                                                             walls_of(whole).wall_impulses()[0]);
                                                 });
}

TEST(Walls, NameWhatTheyCannotBound) {
  const auto made = [](const std::string& options, int wheels = 1) {
    return error_of([&] { coarse_terrain(flat_ground(), wheels, options); });
  };
  EXPECT_THAT(made("{sides: walls}"), HasSubstr("walls stand at the sides of a slab: give its width too"));
  EXPECT_THAT(made("{sides: walls}"), HasSubstr("options.yaml:1:"));
  EXPECT_THAT(made("{sides: wall, slab: 125 mm}"), HasSubstr("sides"));
  EXPECT_THAT(made("{sides: walls, slab: 36 mm}"),
              HasSubstr("must be more than 36 mm: 2 of the soil's largest grains between walls"));
  EXPECT_THAT(made("{sides: walls, slab: 62.5 mm, reach_across: 60 mm}"), HasSubstr("a slab moves as a whole across"));
  EXPECT_THAT(made(walls_options(", depth: 50 mm", "periodic")), HasSubstr("must be 108 mm or more"));
  EXPECT_EQ(made(walls_options()), "no error");
  // A vehicle, or a second wheel behind the first.
  EXPECT_THAT(made(walls_options(), 2), HasSubstr("a slab carries one wheel, as wide as itself"));
  EXPECT_THAT(error_of([&] {
                const auto t = between_walls();
                roll_slab(*t, 0, 1, 0, 0.04);
              }),
              HasSubstr("the slab between walls lies about y = 0, 62.5 mm wide; the hub is at y = 40 mm"));
}

TEST(Walls, WantABedThatWasPouredBetweenThem) {
  const ConfigDocument file = ConfigDocument::from_text(smooth_soil(), "soil.yaml");
  const dem::SoilSettings soil = dem::read_soil(load_soil(file.root()).dem);
  int beds = 0;
  const auto forces_on = [&](bool poured_between, const std::string& sides, double slab_mm) {
    dem::PourSettings p;
    p.lx = 0.25;
    p.ly = 1e-3 * slab_mm;
    p.height = 0.13;
    p.slab = poured_between;
    const std::filesystem::path bed = std::filesystem::temp_directory_path() /
                                      ("walls_test_" + std::to_string(getpid()) + "_" + std::to_string(++beds) + ".h5");
    std::filesystem::remove(bed);
    dem::write_bed(dem::pour(soil, p), bed, "bed of a test");
    const std::string text = error_of([&] {
      const auto t = coarse_terrain(
          flat_ground(), 1,
          "{depth: 50 mm, relief: 20 mm, brick: 125 mm, reach: 60 mm, torus: 8, slab: " + std::to_string(slab_mm) +
              " mm, sides: " + sides + ", bed: " + bed.string() + "}",
          {"wheel", SmoothCylinder{kRadius, kBetween}}, smooth_soil());
      EXPECT_GT(mean_force(roll_slab(*t, 0, 100), 50).z(), 5);
    });
    std::filesystem::remove(bed);
    return text;
  };
  EXPECT_EQ(forces_on(true, "walls", 62.5), "no error");
  EXPECT_THAT(forces_on(false, "walls", 62.5), HasSubstr("'sides: walls' needs one poured between walls"));
  EXPECT_THAT(forces_on(true, "periodic", 125), HasSubstr("the bed was poured between walls"));
}

}  // namespace
}  // namespace grouser::test
