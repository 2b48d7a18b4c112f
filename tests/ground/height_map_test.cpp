// Height maps: interpolation, edges and the three file formats.
#include <algorithm>

#include "grouser/terrain/ground_grid.h"
#include "grouser/terrain/ground_grid_files.h"
#include "helpers.h"

namespace grouser {
namespace {

using ground_test::examples;

/// A smooth field on n x n nodes over 0..1 m.
double field(double x, double y) { return 0.1 * std::sin(5 * x + 1) * std::cos(4 * y); }

HeightGrid sampled(int n) {
  HeightGrid g{n, n, 0, 0, 1.0 / (n - 1), 1.0 / (n - 1), {}};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) g.z.push_back(field(i * g.dx, j * g.dy));
  return g;
}

TEST(HeightMap, IsExactAtItsNodes) {
  const HeightGrid g = sampled(17);  // spacing 1/16: node coordinates are exact numbers
  const GroundPtr ground = height_map_ground(g, Outside::error, "field");
  for (int j = 0; j < 17; ++j)
    for (int i = 0; i < 17; ++i)
      EXPECT_EQ(ground->height(i / 16.0, j / 16.0), g.z[static_cast<std::size_t>(17 * j + i)]);
}

TEST(HeightMap, InterpolationErrorFallsWithTheSquareOfTheSpacing) {
  auto worst = [](int n) {
    const GroundPtr g = height_map_ground(sampled(n), Outside::extend, "field");
    double e = 0;
    for (double x = 0.003; x < 1; x += 0.0071)
      for (double y = 0.005; y < 1; y += 0.0073) e = std::max(e, std::abs(g->height(x, y) - field(x, y)));
    return e;
  };
  const double e1 = worst(17), e2 = worst(33), e3 = worst(65);
  // Bilinear: order 2, up to where the probing points fall in the cells.
  EXPECT_NEAR(std::log2(e1 / e2), 2, 0.1);
  EXPECT_NEAR(std::log2(e2 / e3), 2, 0.1);
}

TEST(HeightMap, IsContinuousAcrossCells) {
  const GroundPtr g = height_map_ground(sampled(9), Outside::mirror, "field");
  const double e = 1e-9;
  // Steepest slope of the field 0.64: no more than that times 2e-9 m between the two sides.
  for (int i = -9; i < 18; ++i)
    for (double t = -0.99; t < 2; t += 0.0631) {
      EXPECT_NEAR(g->height(i / 8.0 - e, t), g->height(i / 8.0 + e, t), 2e-9);
      EXPECT_NEAR(g->height(t, i / 8.0 - e), g->height(t, i / 8.0 + e), 2e-9);
    }
}

TEST(HeightMap, NormalIsTheGradientInsideMirroredAndBeyondTheEdge) {
  for (Outside o : {Outside::mirror, Outside::extend}) {
    const GroundPtr g = height_map_ground(sampled(9), o, "field");
    // No probe on a cell's edge, where the gradient jumps.
    for (double x = -1.4913; x < 2.6; x += 0.173)
      for (double y = -1.4717; y < 2.6; y += 0.191) ground_test::expect_normal_is_gradient(*g, x, y, 1e-8);
  }
}

TEST(HeightMap, BeyondItsEdgeDoesWhatWasAsked) {
  const GroundPtr extended = height_map_ground(sampled(9), Outside::extend, "field");
  EXPECT_EQ(extended->height(1.7, 0.3), extended->height(1.0, 0.3));
  EXPECT_EQ(extended->height(-2, 5), extended->height(0, 1));
  const GroundPtr mirrored = height_map_ground(sampled(9), Outside::mirror, "field");
  EXPECT_NEAR(mirrored->height(1.2, 0.3), mirrored->height(0.8, 0.3), 1e-14);
  EXPECT_NEAR(mirrored->height(-0.2, 2.3), mirrored->height(0.2, 0.3), 1e-14);
  const GroundPtr strict = height_map_ground(sampled(9), Outside::error, "field");
  EXPECT_NO_THROW(strict->height(1.0, 1.0));
  try {
    strict->height(1.2, 0.5);
    FAIL();
  } catch (const GroundError& e) {
    EXPECT_STREQ(
        e.what(),
        "height map field: the point (1.2, 0.5) m is outside its extent x 0..1 m, y 0..1 m, and 'outside' is error");
  }
}

TEST(HeightMap, PngEsriAndCsvOfOneFieldAgree) {
  const HeightGrid png = read_height_png(examples() / "data/crater_field.png", 0.1, -0.30, 0.10);
  const HeightGrid esri = read_height_esri(examples() / "data/crater_field.asc");
  const HeightGrid csv = read_height_csv(examples() / "data/crater_field.csv", 0.1, 1e-3);
  ASSERT_EQ(png.nx, 81);
  ASSERT_EQ(png.ny, 61);
  ASSERT_EQ(esri.z.size(), png.z.size());
  ASSERT_EQ(csv.z.size(), png.z.size());
  EXPECT_EQ(esri.dx, 0.1);
  EXPECT_EQ(esri.x0, 0);
  // The text files hold 0.1 micrometre.
  for (std::size_t i = 0; i < png.z.size(); ++i) {
    ASSERT_NEAR(esri.z[i], png.z[i], 0.51e-7) << i;
    ASSERT_NEAR(csv.z[i], png.z[i], 0.51e-7) << i;
  }
  // The deepest crater's centre is 5.2 m to the right and 4.1 m up: the first row of a file is the far one.
  const auto deepest = std::min_element(png.z.begin(), png.z.end()) - png.z.begin();
  EXPECT_EQ(deepest % 81, 52);
  EXPECT_EQ(deepest / 81, 41);
}

TEST(HeightMap, EsriCornerIsHalfACellFromItsNode) {
  const ground_test::Folder folder;
  const auto file = folder.write("g.asc", "NCOLS 3\nNROWS 2\nXLLCORNER 10\nYLLCORNER 20\nCELLSIZE 2\n1 2 3\n4 5 6\n");
  const HeightGrid g = read_height_esri(file);
  EXPECT_EQ(g.x0, 11);
  EXPECT_EQ(g.y0, 21);
  EXPECT_EQ(g.z, (std::vector<double>{4, 5, 6, 1, 2, 3}));
}

TEST(HeightMap, RefusesABrokenGrid) {
  HeightGrid g = sampled(5);
  g.z[7] = NAN;
  EXPECT_THROW(height_map_ground(g, Outside::extend, "field"), GroundError);
  g = sampled(5);
  g.z.pop_back();
  EXPECT_THROW(height_map_ground(g, Outside::extend, "field"), GroundError);
  EXPECT_THROW(height_map_ground(sampled(5), Outside::repeat, "field"), GroundError);
}

}  // namespace
}  // namespace grouser
