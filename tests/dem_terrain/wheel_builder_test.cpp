// Wheels as meshes and clumps: closed, as large as geometry says, with the surface where Table 3.3 has it.
#include "grouser/dem/wheel_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/dem/solver.h"

namespace grouser::test {
namespace {

using dem::Mesh;
using dem::WheelShape;

WheelShape ding() {
  WheelShape w;
  w.radius = 0.157;
  w.width = 0.165;
  w.lugs = 30;
  w.lug_height = 0.005;
  w.lug_thickness = 0.002;
  return w;
}
WheelShape mer() {
  WheelShape w;
  w.radius = 0.125;
  w.width = 0.16;
  w.tread_radius = 0.219;
  w.lugs = 30;
  w.lug_height = 0.00555;
  w.lug_thickness = 0.0021;
  w.closed_sides = 1;
  w.sidewall_height = 0.0025;
  return w;
}

TEST(WheelBuilder, MakesClosedMeshesOfEveryKind) {
  for (const int sides : {0, 1, 2})
    for (const double tread : {0.0, 0.219})
      for (const double sidewall : {0.0, 0.0025}) {
        WheelShape w = mer();
        w.closed_sides = sides;
        w.tread_radius = tread;
        w.sidewall_height = sidewall;
        EXPECT_EQ(wheel_mesh(w).open_edges(), 0u) << sides << ' ' << tread << ' ' << sidewall;
      }
}

TEST(WheelBuilder, EnclosesTheVolumeThatPappusGives) {
  // Solid flat wheel: a polygon of 72 corners, pi becomes 36 sin(pi/36).
  const double polygon = 36 * std::sin(pi / 36);
  WheelShape solid = ding();
  solid.lugs = 0;
  EXPECT_NEAR(std::abs(wheel_mesh(solid).volume()), polygon * 0.157 * 0.157 * 0.165, 1e-9);
  // Rim alone: the difference of two such.
  solid.closed_sides = 0;
  EXPECT_NEAR(std::abs(wheel_mesh(solid).volume()), polygon * (0.157 * 0.157 - 0.147 * 0.147) * 0.165, 1e-9);
  // One side adds a disc 10 mm thick inside the rim.
  solid.closed_sides = 1;
  EXPECT_NEAR(std::abs(wheel_mesh(solid).volume()),
              polygon * ((0.157 * 0.157 - 0.147 * 0.147) * 0.165 + 0.147 * 0.147 * 0.01), 1e-9);
}

TEST(WheelBuilder, HollowsAConcaveTreadByItsSagitta) {
  const WheelShape w = mer();
  // Geometry of a circle of 219 mm over a chord of 160 mm.
  EXPECT_NEAR(tread_radius_at(w, 0), 0.125 - (0.219 - std::sqrt(0.219 * 0.219 - 0.08 * 0.08)), 1e-12);
  EXPECT_NEAR(tread_radius_at(w, 0.077), 0.125, 1.2e-3);
  EXPECT_NEAR(tread_radius_at(w, 0.08), 0.1275, 1e-12);
  double outer = 0;
  for (const Vec3& v : wheel_mesh(w).vertices) outer = std::max(outer, std::hypot(v.x(), v.z()));
  // Half the thickness of a lug makes its corners stand out by 4 um more.
  EXPECT_NEAR(outer, 0.125 + 0.00555, 1e-5);
}

TEST(WheelBuilder, KeepsSpheresOfAClumpInsideTheMeshTheyStandFor) {
  for (const WheelShape& w : {ding(), mer()}) {
    const dem::Clump c = wheel_clump(w);
    double outer = 0, tread = 0;
    for (std::size_t k = 0; k < c.centres.size(); ++k) {
      const double y = std::abs(c.centres[k].y());
      EXPECT_LE(y + c.radii[k], 0.5 * w.width + 1e-12);
      const double out = std::hypot(c.centres[k].x(), c.centres[k].z()) + c.radii[k];
      outer = std::max(outer, out);
      if (c.radii[k] > 0.002 && y < 0.02) tread = std::max(tread, out);
    }
    // The outermost spheres of a lug lie a millimetre from the edge, where a concave tread is 0.4 mm lower than there.
    EXPECT_NEAR(outer, w.radius + w.lug_height, w.tread_radius > 0 ? 5e-4 : 2e-5);
    // A tread that leans is met by the side of a sphere.
    EXPECT_NEAR(tread, tread_radius_at(w, 0.02), 2e-4);
  }
  // The dissertation's wheels have 92,055 and 93,557 particles "typically" 75 % of a radius apart: the same order.
  EXPECT_THAT(wheel_clump(ding()).centres.size(), testing::AllOf(testing::Gt(60000u), testing::Lt(140000u)));
}

TEST(WheelBuilder, NamesAMeshAndARimThatIsTooThick) {
  const RunningGear mesh{"plough", TriangleMesh{}};
  EXPECT_THAT([&] { dem::wheel_shape(mesh); }, testing::ThrowsMessage<dem::DemError>(testing::HasSubstr("plough")));
  LuggedCylinder narrow;
  narrow.radius = 0.1;
  narrow.width = 0.015;
  narrow.lug_count = 3;
  narrow.closed_sides = 1;
  EXPECT_THAT(
      [&] {
        dem::wheel_shape({"narrow", narrow});
      },
      testing::ThrowsMessage<dem::DemError>(testing::HasSubstr("thicker than the wheel")));
}

}  // namespace
}  // namespace grouser::test
