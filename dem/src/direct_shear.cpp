#include <algorithm>
#include <cmath>

#include "packing.h"

namespace grouser::dem {

namespace {

/// Rectangle in the plane z = z0.
void add_rectangle(Mesh& m, double x0, double x1, double y0, double y1, double z) {
  Mesh r;
  for (int k = 0; k < 4; ++k) r.vertices.push_back(Vec3(k & 1 ? x1 : x0, k & 2 ? y1 : y0, z));
  r.triangles = {{0, 1, 3}, {0, 3, 2}};
  m.append(r);
}

/// Four walls from z0 to z1 and, where asked, a bottom; the ledge beside the split keeps grains in.
Mesh half_box(double side, double z0, double z1, bool bottom, double ledge_from, double ledge_to, double split) {
  Mesh m = box_mesh(Vec3(side, side, z1 - z0), true, !bottom);
  for (Vec3& v : m.vertices) v[2] += 0.5 * (z0 + z1);
  add_rectangle(m, ledge_from, ledge_to, -side / 2, side / 2, split);
  return m;
}

/// Layer of equal spheres in rows, their lowest points in z = 0 of the body.
void rough_plate(double side, double radius, std::vector<Vec3>& centres, std::vector<double>& radii) {
  const int n = static_cast<int>(side / (2 * radius));
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      centres.push_back(Vec3((a + 0.5) * side / n - side / 2, (b + 0.5) * side / n - side / 2, radius));
      radii.push_back(radius);
    }
}

}  // namespace

ShearCurve direct_shear(const SoilSettings& soil, const ShearSettings& test, const Progress& progress) {
  if (!(test.side > 0 && test.height > 0 && test.pressure > 0 && test.rate > 0 && test.displacement > 0))
    throw DemError("direct shear: side, height, pressure, rate and displacement must be positive");
  if (test.samples < 1) throw DemError("direct shear: at least one sample");
  const double side = test.side, area = side * side, ledge = test.displacement + soil.largest;
  const double loosest = 1 / 0.25, column = test.height * 0.518 * loosest + 0.05;
  // As many grains as fill the height at the bulk density aimed at with the density given.
  std::vector<GrainState> grains =
      scatter(soil, side, side, true, soil.bulk_density / soil.density * area * test.height);
  for (GrainState& g : grains) g.x -= Vec3(side / 2, side / 2, 0);
  SolverSettings s;
  s.domain.lo = Vec3(-side, -side, -0.02);
  s.domain.hi = Vec3(side, side, column + 0.1);
  s.domain.periodic = {false, false, false};
  s.materials = soil.materials;
  s.law = soil.law;
  s.dt = soil.dt;
  s.precision = soil.precision;
  const double split = test.height / 2;
  const auto boxes = [&](Solver& solver) {
    const int low = solver.add_body({}), high = solver.add_body({});
    solver.add_mesh(low, half_box(side, 0, split, true, side / 2, side / 2 + ledge, split), 1);
    solver.add_mesh(high, half_box(side, split, column + 0.05, false, -side / 2 - ledge, -side / 2, split), 1);
    return high;
  };
  {
    Solver pour(s, grains);
    boxes(pour);
    settle(pour, 2e-3, 1.5, {});
    grains = pour.grains();
  }
  const double height = [&] {
    std::vector<GrainState> moved = grains;
    for (GrainState& g : moved) g.x += Vec3(side / 2, side / 2, 0);
    return surface_height(moved, side, side, soil.largest);
  }();
  const double bulk = total_mass(grains) / (area * height);
  double top = 0;
  for (GrainState& g : grains) {
    g.density *= soil.bulk_density / bulk;
    g.v = g.w = Vec3::Zero();
    top = std::max(top, g.x[2] + g.radius);
  }
  Solver solver(s, grains);
  const int upper = boxes(solver);
  BodySettings p;
  p.free = true;
  p.mass = test.pressure * area / s.gravity.norm();
  p.locked = {true, true, false, true, true, true};
  p.X_WB.p = Vec3(0, 0, top + 1e-5);
  const int plate = solver.add_body(p);
  std::vector<Vec3> centres;
  std::vector<double> radii;
  rough_plate(side, 0.0025, centres, radii);
  solver.add_spheres(plate, centres, radii, 0);
  // Load until the plate rests.
  settle(solver, 1e-4, 1.0, {});
  ShearCurve c;
  c.bulk_density = soil.bulk_density;
  c.grains = grains.size();
  const double z0 = solver.pose(plate).p[2];
  Twist V;
  V.v = Vec3(test.rate, 0, 0);
  solver.set_motion(upper, V);
  Twist W = solver.twist(plate);
  W.v[0] = test.rate;
  solver.set_motion(plate, W);
  const double sample = test.displacement / test.rate / test.samples;
  for (int k = 0; k < test.samples; ++k) {
    const Vec3 box = solver.body(upper).impulse, cap = solver.body(plate).impulse;
    const double t = solver.time();
    solver.step_for(sample);
    const double dt = solver.time() - t;
    const Vec3 f = (solver.body(upper).impulse - box) / dt, g = (solver.body(plate).impulse - cap) / dt;
    // Mean over the sample: its middle.
    c.displacement.push_back((k + 0.5) * sample * test.rate);
    c.shear.push_back(-f[0] / area);
    c.shear_total.push_back(-(f[0] + g[0]) / area);
    c.normal.push_back(g[2] / area);
    c.rise.push_back(solver.pose(plate).p[2] - z0);
    if (progress) progress(double(k + 1) / test.samples, solver.time());
  }
  c.counters = solver.counters();
  return c;
}

}  // namespace grouser::dem
