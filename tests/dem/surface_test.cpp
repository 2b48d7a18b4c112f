// Meshes, cylinder, clumps, free bodies: against planes, against mechanics of rigid bodies, against geometry.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

constexpr double kRadius = 0.005;

SolverSettings walled(Precision p = Precision::full) {
  SolverSettings s;
  s.domain.lo = Vec3(-0.2, -0.2, -0.1);
  s.domain.hi = Vec3(0.2, 0.2, 0.3);
  s.domain.periodic = {false, false, false};
  s.dt = 4e-6;
  s.precision = p;
  return s;
}
GrainState ball(const Vec3& x, const Vec3& v = Vec3::Zero(), const Vec3& w = Vec3::Zero()) {
  GrainState g;
  g.x = x;
  g.radius = kRadius;
  g.v = v;
  g.w = w;
  return g;
}
double mass() { return 4.0 / 3 * pi * std::pow(kRadius, 3) * 3100; }

Mesh grid(int n, double length, std::function<double(double, double)> z) {
  Mesh m;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = length * (double(i) / n - 0.5), y = length * (double(j) / n - 0.5);
      m.vertices.push_back(Vec3(x, y, z(x, y)));
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j;
      m.triangles.push_back({a, a + n + 1, a + n + 2});
      m.triangles.push_back({a, a + n + 2, a + 1});
    }
  return m;
}

TEST(FlatMesh, IsAPlaneToAGrainThatRollsAcrossItsEdges) {
  // 3 mm triangles under a grain of 10 mm, oblique path over edges and corners, with friction and rolling springs.
  const GrainState g = ball({-0.05, 0.013, kRadius - 5e-7}, {0.2, 0.07, 0}, {3, 5, 1});
  SolverSettings s = walled();
  s.materials.pairs[0].rolling = 0.02;
  Solver plane(s, {g}), mesh(s, {g});
  plane.add_floor();
  mesh.add_mesh(mesh.add_body({}), grid(100, 0.3, [](double, double) { return 0.0; }));
  for (int k = 0; k < 40; ++k) {
    plane.step(1000);
    mesh.step(1000);
    const GrainState a = plane.grains()[0], b = mesh.grains()[0];
    EXPECT_LT((a.x - b.x).norm(), 1e-9);
    EXPECT_LT((a.v - b.v).norm(), 1e-6);
    EXPECT_LE(mesh.body(0).contacts, 1);
  }
  EXPECT_GT(plane.grains()[0].x[0], -0.03);
}

TEST(MeshBox, HoldsAGrainInACornerByThreeFaces) {
  SolverSettings s = walled();
  s.gravity = 9.81 * Vec3(-1, -1, -1).normalized();
  Solver solver(s, {ball({-0.044, -0.044, -0.044})});
  solver.add_mesh(solver.add_body({}), box_mesh(Vec3(0.1, 0.1, 0.1)));
  solver.set_drag(100);
  solver.step(50000);
  EXPECT_EQ(solver.body(0).contacts, 3);
  const Vec3 x = solver.grains()[0].x;
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(x[k], -0.05 + kRadius, 2e-6);
  EXPECT_LT((solver.body(0).force - mass() * s.gravity).norm(), 1e-5 * mass() * 9.81);
}

TEST(MeshEdge, CountsOnceWhenTwoTrianglesShareIt) {
  // A grain pressed on the ridge of a roof: both triangles have the same nearest point.
  SolverSettings s = walled();
  Solver solver(s, {ball({0, 0, kRadius - 1e-6})});
  solver.add_mesh(solver.add_body({}), grid(2, 0.2, [](double x, double) { return -std::fabs(x); }));
  solver.step(1);
  EXPECT_EQ(solver.body(0).contacts, 1);
}

TEST(Meshes, HaveTheSizesTheyWereAskedFor) {
  EXPECT_NEAR(box_mesh(Vec3(1, 2, 3)).volume(), 6, 1e-12);
  EXPECT_EQ(box_mesh(Vec3(1, 2, 3)).open_edges(), 0u);
  EXPECT_EQ(box_mesh(Vec3(1, 2, 3), true).open_edges(), 4u);
  const Mesh wheel = wheel_mesh(0.13, 0.16, 360);
  EXPECT_EQ(wheel.open_edges(), 0u);
  EXPECT_NEAR(std::fabs(wheel.volume()), pi * 0.13 * 0.13 * 0.16, 1e-4 * pi * 0.13 * 0.13 * 0.16);
}

TEST(Cylinder, RestsOnGrainsThatCarryItsWeight) {
  SolverSettings s = walled();
  std::vector<GrainState> g;
  for (int k = -1; k <= 1; ++k) g.push_back(ball({0, 0.02 * k, kRadius}));
  Solver solver(s, g);
  const int floor = solver.add_floor();
  BodySettings b;
  b.free = true;
  b.mass = 0.2;
  b.inertia = Vec3(0.01, 0.01, 0.01);
  b.locked = {true, true, false, true, true, true};
  b.X_WB.p = Vec3(0, 0, 0.04 + 2 * kRadius + 1e-5);
  const int wheel = solver.add_body(b);
  solver.add_cylinder(wheel, 0.04, 0.05);
  solver.step(150000);
  EXPECT_EQ(solver.body(wheel).contacts, 3);
  EXPECT_NEAR(solver.body(wheel).force[2], 0.2 * 9.81, 2e-3 * 0.2 * 9.81);
  EXPECT_NEAR(-solver.body(floor).force[2], (0.2 + 3 * mass()) * 9.81, 2e-3 * 0.2 * 9.81);
  // Hertz on both sides of a grain: overlap of the wheel from the law of the plane, R* = r.
  const double E = 7e7 / (2 * (1 - 0.35 * 0.35)), load = 0.2 * 9.81 / 3;
  const double depth = std::pow(load * 0.75 / E / std::sqrt(kRadius), 2.0 / 3);
  const double z = solver.grains()[0].x[2];
  EXPECT_NEAR(0.04 + kRadius - (solver.pose(wheel).p[2] - z), depth, 0.01 * depth);
}

TEST(Cylinder, TouchesWithRimSideAndEdge) {
  // Places whose nearest point is known: beside the rim, beside the disc, off the edge.
  struct Case {
    Vec3 x;
    double distance;
  };
  for (const Case& c : {Case{{0.05, 0.01, 0}, 0.01}, Case{{0, 0.028, 0.01}, 0.008}, Case{{0.043, 0.024, 0}, 0.005}}) {
    SolverSettings s = walled();
    s.gravity = Vec3::Zero();
    GrainState g = ball(c.x);
    for (const double share : {1.001, 0.999}) {
      g.radius = c.distance * share;
      Solver solver(s, {g});
      solver.add_cylinder(solver.add_body({}), 0.04, 0.02);
      solver.step(1);
      EXPECT_EQ(solver.body(0).contacts, share > 1 ? 1 : 0);
    }
  }
}

TEST(FreePlate, SettlesOnAGrainWithItsWeightAndGivesTheBedItsMomentum) {
  SolverSettings s = walled();
  s.gravity = Vec3(0, 0, -9.81);
  Solver solver(s, {ball({0, 0, kRadius})});
  const int floor = solver.add_floor();
  BodySettings b;
  b.free = true;
  b.mass = 0.05;
  b.locked = {true, true, false, true, true, true};
  b.X_WB.p = Vec3(0, 0, 2 * kRadius + 1e-4);
  const int plate = solver.add_body(b);
  solver.add_mesh(plate, plate_mesh(0.05, 0.05));
  solver.step(150000);
  EXPECT_NEAR(solver.body(plate).force[2], 0.05 * 9.81, 2e-3 * 0.05 * 9.81);
  // Impulses of gravity, floor and plate make up the momentum of grain and plate.
  const double t = solver.time(), weight = (mass() + 0.05) * 9.81 * t;
  const double grain =
      solver.momentum()[2] - (-mass() * 9.81 * t - solver.body(floor).impulse[2] - solver.body(plate).impulse[2]);
  EXPECT_NEAR(grain, 0, 1e-9 * weight);
  const double plate_momentum = 0.05 * solver.twist(plate).v[2] - (-0.05 * 9.81 * t + solver.body(plate).impulse[2]);
  EXPECT_NEAR(plate_momentum, 0, 1e-9 * weight);
}

TEST(Clump, BouncesOffAGrainAsTheBodyItIs) {
  // Centre hit head-on by a grain: momentum and the restitution of a smooth central impact decide both velocities.
  SolverSettings s = walled();
  s.gravity = Vec3::Zero();
  Solver solver(s, {ball({-0.02, 0, 0.1}, {0.1, 0, 0})});
  BodySettings b;
  b.free = true;
  b.mass = 10;  // far heavier than the grain: the law takes the grain's own mass for m*
  b.inertia = Vec3(1, 1, 1);
  b.X_WB.p = Vec3(0, 0, 0.1);
  const int body = solver.add_body(b);
  solver.add_spheres(body, {Vec3(0, 0, 0), Vec3(0.01, 0, 0)}, {0.01, 0.01});
  solver.step(30000);
  const double e = -solver.grains()[0].v[0] / 0.1;
  EXPECT_NEAR(e, 0.4, 0.03);
  EXPECT_NEAR(10 * solver.twist(body).v[0], mass() * 0.1 * (1 + e), 1e-9 * mass());
  EXPECT_LT(solver.twist(body).w.norm(), 1e-12);
}

TEST(PrescribedBody, CarriesAGrainAlongAndCountsItsWork) {
  // Conveyor: a moving plate brings a grain at rest to its own speed; friction force times plate speed is the work.
  SolverSettings s = walled();
  s.materials.pairs[0].rolling = 1.0;
  Solver solver(s, {ball({-0.05, 0, kRadius - 7e-7})});
  BodySettings b;
  b.V_W.v = Vec3(0.1, 0, 0);
  const int belt = solver.add_body(b);
  solver.add_mesh(belt, grid(4, 0.3, [](double, double) { return 0.0; }));
  solver.step(100000);
  EXPECT_NEAR(solver.grains()[0].v[0], 0.1, 1e-4);
  EXPECT_NEAR(solver.body(belt).work, -solver.body(belt).impulse[0] * 0.1, 1e-12);
  EXPECT_NEAR(-solver.body(belt).impulse[0], mass() * 0.1, 1e-3 * mass() * 0.1);
}

TEST(Surfaces, RefuseNonsenseByName) {
  SolverSettings s = walled();
  Solver solver(s, {ball({0, 0, 0.1})});
  const int b = solver.add_body({});
  const auto message = [](const std::function<void()>& f) -> std::string {
    try {
      f();
    } catch (const DemError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message([&] { solver.add_mesh(b, {}); }), "mesh without triangles");
  Mesh m = plate_mesh(1, 1);
  m.vertices[3] = m.vertices[0];
  EXPECT_EQ(message([&] { solver.add_mesh(b, m); }), "triangle 0 has no area");
  EXPECT_EQ(message([&] { solver.add_plane(7, Vec3::Zero(), Vec3::UnitZ()); }), "body 7; there are 1");
  EXPECT_EQ(message([&] { solver.add_cylinder(b, -1, 1); }),
            "cylinder of radius -1 m, half width 1 m: both must be positive");
  Mesh open = box_mesh(Vec3(0.1, 0.1, 0.01), true);
  EXPECT_EQ(message([&] { solver.add_mesh(b, open, 0, true); }),
            "the mesh is open: 4 edges belong to one triangle only; a solid body needs a closed mesh");
  SolverSettings p = s;
  p.domain.periodic = {true, true, false};
  Solver periodic(p, {ball({0, 0, 0.1})});
  EXPECT_EQ(message([&] { periodic.add_plane(periodic.add_body({}), Vec3::Zero(), Vec3(1, 0, 1)); }),
            "a plane cannot lean along the periodic axis x");
}

/// A wheel whose rim is `depth` below the top of one grain at the origin, which lies right below its axis.
void add_wheel(Solver& solver, double depth, bool cylinder) {
  BodySettings b;
  b.X_WB.p = Vec3(0, 0, 0.1 + kRadius - depth);
  const int wheel = solver.add_body(b);
  if (cylinder)
    solver.add_cylinder(wheel, 0.1, 0.05);
  else
    solver.add_mesh(wheel, wheel_mesh(0.1, 0.1, 360), 0, true);
}

TEST(AWheel, MayNotStartInTheBed) {
  SolverSettings s = walled();
  for (const bool cylinder : {true, false})
    for (const double depth : {0.0, 0.001, 0.002, 0.02, 0.1}) {
      Solver solver(s, {ball({0, 0, 0})});
      // A quarter of the radius, 1.25 mm, is allowed; at 20 mm and 100 mm the whole grain is inside.
      if (depth < 0.00125)
        EXPECT_NO_THROW(add_wheel(solver, depth, cylinder));
      else
        try {
          add_wheel(solver, depth, cylinder);
          ADD_FAILURE() << "a depth of " << depth << " was accepted";
        } catch (const DemError& e) {
          EXPECT_THAT(e.what(), testing::HasSubstr("grain 0 at (0, 0, 0) m is"));
          EXPECT_THAT(e.what(), testing::HasSubstr("deep in surface 0, of body 0; at most a quarter of its radius"));
        }
    }
}

}  // namespace
