#include "sphere_wheel.h"

#include <algorithm>
#include <cmath>

namespace grouser::dem {

SphereWheel::SphereWheel(const BodySpec& body, const WheelForm& form, double slab)
    : radius_(body.gear.outer_radius()), half_width_(0.5 * body.gear.width()), slab_(slab) {
  if (slab_ > 0) {
    if (form.mesh || form.clump || !std::holds_alternative<SmoothCylinder>(body.gear.shape))
      throw TerrainError("a slab carries a smooth cylinder only; '" + body.gear.name +
                         "' has ends or lugs: leave out 'slab', or take a smooth wheel with 'wheel: auto'");
    return;
  }
  if (const auto* mesh = std::get_if<TriangleMesh>(&body.gear.shape)) {
    if (form.clump)
      throw TerrainError("running gear '" + body.gear.name + "' is a mesh: 'wheel: clump' cannot build it");
    mesh_.vertices = mesh->vertices;
    for (const auto& t : mesh->triangles) mesh_.triangles.push_back({t[0], t[1], t[2]});
    return;
  }
  try {
    const WheelShape shape = wheel_shape(body.gear);
    if (form.clump)
      clump_ = wheel_clump(shape, form.diameter, form.lug_diameter);
    else if (form.mesh || std::holds_alternative<LuggedCylinder>(body.gear.shape))
      mesh_ = wheel_mesh(shape);
  } catch (const DemError& e) {
    throw TerrainError(e.what());
  }
}

void SphereWheel::add_to(Solver& solver, const Pose& X, int material) const {
  BodySettings b;
  b.X_WB = X;
  const int number = solver.add_body(b);
  if (!clump_.centres.empty())
    solver.add_spheres(number, clump_.centres, clump_.radii, material);
  else if (mesh_.triangles.empty())
    // Across a slab no image of a grain lies further than half of it: this cylinder has no ends there.
    solver.add_cylinder(number, radius_, slab_ > 0 ? slab_ : half_width_, material);
  else
    solver.add_mesh(number, mesh_, material, true);
}

double SphereWheel::overlap(const Pose& X, const Vec3& centre, double r) const {
  const Vec3 d = X.q.conjugate() * (centre - X.p);
  const double out = std::hypot(d[0], d[2]) - radius_;
  if (slab_ > 0) return r - out;
  const double side = std::abs(d[1]) - half_width_;
  if (out > 0 && side > 0) return r - std::hypot(out, side);
  return r - std::max(out, side);
}

namespace {

/// Distance of an oriented rectangle (centre, unit axis u, half sizes a along u and b across) from the box [lo, hi].
double distance(const Vec2& centre, const Vec2& u, double a, double b, const Vec2& lo, const Vec2& hi) {
  const Vec2 v(-u[1], u[0]);
  // Alternating projections between two convex sets.
  Vec2 p = centre, q = p;
  for (int k = 0; k < 30; ++k) {
    q = p.cwiseMax(lo).cwiseMin(hi);
    const Vec2 d = q - centre;
    p = centre + std::clamp(d.dot(u), -a, a) * u + std::clamp(d.dot(v), -b, b) * v;
  }
  return (p - q).norm();
}

}  // namespace

void SphereWheel::tiles_near(const Pose& X, const Ground& ground, double lx, double ly, const PatchReach& reach,
                             const PatchReach& keep, double clear, const std::vector<Tile>& now,
                             std::vector<Tile>& into) const {
  const Mat3 C = carrier_axes(X.q * Vec3::UnitY());
  const Vec2 u = Vec2(C.col(0).head<2>()).normalized();
  double level = -1e300;
  for (const double s : {-0.7, -0.35, 0.0, 0.35, 0.7})
    for (const double w : {-1.0, 0.0, 1.0}) {
      const Vec2 p = X.p.head<2>() + s * radius_ * u + w * half_width_ * Vec2(-u[1], u[0]);
      level = std::max(level, ground.height(p.x(), p.y()));
    }
  const double depth = level - (X.p.z() - radius_);
  if (depth < -clear) return;
  const double d = std::clamp(depth, 0.0, radius_), a = std::sqrt(radius_ * radius_ - (radius_ - d) * (radius_ - d));
  const Vec2 centre = X.p.head<2>();
  const double out = a + half_width_ + keep.most();
  const auto index = [](double x, double l) { return static_cast<std::int64_t>(std::floor(x / l)); };
  for (std::int64_t i = index(centre.x() - out, lx); i <= index(centre.x() + out, lx); ++i)
    for (std::int64_t j = index(centre.y() - out, ly); j <= index(centre.y() + out, ly); ++j) {
      const Vec2 lo(static_cast<double>(i) * lx, static_cast<double>(j) * ly), hi = lo + Vec2(lx, ly);
      const auto near = [&](const PatchReach& r) {
        return distance(centre, u, a + (r.along - r.least()), half_width_ + (r.across - r.least()), lo, hi) < r.least();
      };
      if (near(reach) || (near(keep) && std::binary_search(now.begin(), now.end(), Tile{i, j}))) into.push_back({i, j});
    }
}

double patch_stiffness(const Material& m, double force, double area) {
  if (!(force > 0 && area > 0)) return 0;
  constexpr double contacts = 5, solid = 0.57, poisson = 0.2;
  const double G = m.young / (2 * (1 + m.poisson)), nu = m.poisson;
  const double bulk =
      std::cbrt(contacts * contacts * solid * solid * G * G * (force / area) / (18 * pi * pi * (1 - nu) * (1 - nu)));
  const double young = 3 * bulk * (1 - 2 * poisson);
  return 2 * young * std::sqrt(area / pi) / (1 - poisson * poisson);
}

}  // namespace grouser::dem
