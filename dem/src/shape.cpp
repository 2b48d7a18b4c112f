#include "shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "touch.h"

namespace grouser::dem {

namespace {

Vec3L<double> plain(const Vec3& x) { return {x[0], x[1], x[2]}; }

Facet triangle_facet(const Vec3& a, const Vec3& b, const Vec3& c) {
  using N = FacetField;
  const Vec3 u = b - a, v = c - a, w = c - b, n = u.cross(v).normalized();
  Facet f{};
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    f[N::corner + at] = a[k];
    f[N::u + at] = u[k];
    f[N::v + at] = v[k];
    f[N::normal + at] = n[k];
  }
  f[N::uu] = u.dot(u);
  f[N::uv] = u.dot(v);
  f[N::vv] = v.dot(v);
  f[N::inv_uu] = 1 / u.dot(u);
  f[N::inv_vv] = 1 / v.dot(v);
  f[N::inv_ww] = 1 / w.dot(w);
  f[N::inv_det] = 1 / u.cross(v).squaredNorm();
  return f;
}

Facet sphere_facet(const Vec3& centre, double radius) {
  Facet f{};
  for (int k = 0; k < 3; ++k) f[FacetField::corner + static_cast<std::size_t>(k)] = centre[k];
  f[FacetField::radius] = radius;
  return f;
}

}  // namespace

Shape Shape::plane(const Vec3& point, const Vec3& normal) {
  Shape s;
  s.kind_ = ShapeKind::plane;
  s.point_ = point;
  s.normal_ = normal.normalized();
  s.extent_ = std::numeric_limits<double>::infinity();
  return s;
}
Shape Shape::cylinder(double radius, double half_width) {
  Shape s;
  s.kind_ = ShapeKind::cylinder;
  s.radius_ = radius;
  s.half_width_ = half_width;
  s.extent_ = std::isfinite(half_width) ? std::hypot(radius, half_width) : radius;
  return s;
}
Shape Shape::mesh(Mesh m, bool solid) {
  Shape s;
  s.solid_ = solid;
  s.kind_ = ShapeKind::mesh;
  for (const Vec3& v : m.vertices) s.extent_ = std::max(s.extent_, v.norm());
  for (const auto& t : m.triangles) {
    const auto at = [&](std::size_t k) { return m.vertices[static_cast<std::size_t>(t[k])]; };
    s.facets_.push_back(triangle_facet(at(0), at(1), at(2)));
  }
  s.mesh_ = std::move(m);
  return s;
}
Shape Shape::spheres(std::vector<Vec3> centres, std::vector<double> radii) {
  Shape s;
  s.kind_ = ShapeKind::spheres;
  for (std::size_t k = 0; k < centres.size(); ++k) s.extent_ = std::max(s.extent_, centres[k].norm() + radii[k]);
  for (std::size_t k = 0; k < centres.size(); ++k) s.facets_.push_back(sphere_facet(centres[k], radii[k]));
  s.centres_ = std::move(centres);
  s.radii_ = std::move(radii);
  return s;
}

void Shape::prepare(double reach) {
  const std::size_t parts = kind_ == ShapeKind::mesh ? mesh_.triangles.size() : centres_.size();
  if (parts == 0) return;
  std::vector<Vec3> low(parts), high(parts);
  Vec3 lo = Vec3::Constant(1e30), hi = Vec3::Constant(-1e30);
  for (std::size_t p = 0; p < parts; ++p) {
    low[p] = Vec3::Constant(1e30);
    high[p] = Vec3::Constant(-1e30);
    if (kind_ == ShapeKind::mesh) {
      for (int v : mesh_.triangles[p]) {
        low[p] = low[p].cwiseMin(mesh_.vertices[static_cast<std::size_t>(v)]);
        high[p] = high[p].cwiseMax(mesh_.vertices[static_cast<std::size_t>(v)]);
      }
    } else {
      low[p] = centres_[p] - Vec3::Constant(radii_[p]);
      high[p] = centres_[p] + Vec3::Constant(radii_[p]);
    }
    low[p] -= Vec3::Constant(reach);
    high[p] += Vec3::Constant(reach);
    lo = lo.cwiseMin(low[p]);
    hi = hi.cwiseMax(high[p]);
  }
  lo_ = lo;
  cell_ = reach;
  const auto cells = [&] {
    double c = 1;
    for (int k = 0; k < 3; ++k) c *= std::ceil((hi[k] - lo[k]) / cell_) + 1;
    return c;
  };
  while (cells() > 4e6) cell_ *= 1.5;
  for (int k = 0; k < 3; ++k) n_[k] = static_cast<int>(std::ceil((hi[k] - lo[k]) / cell_)) + 1;
  const std::size_t total = static_cast<std::size_t>(n_[0]) * n_[1] * n_[2];
  start_.assign(total + 1, 0);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t p = 0; p < parts; ++p) {
      int a[3], b[3];
      for (int k = 0; k < 3; ++k) {
        a[k] = static_cast<int>((low[p][k] - lo_[k]) / cell_);
        b[k] = std::min(n_[k] - 1, static_cast<int>((high[p][k] - lo_[k]) / cell_));
      }
      for (int x = a[0]; x <= b[0]; ++x)
        for (int y = a[1]; y <= b[1]; ++y)
          for (int z = a[2]; z <= b[2]; ++z) {
            const std::size_t at = (static_cast<std::size_t>(x) * n_[1] + y) * n_[2] + z;
            if (kind_ == ShapeKind::mesh) {
              // A box round a slanted triangle is wide: look at the triangle itself.
              const Vec3 centre = lo_ + cell_ * (Vec3(x, y, z) + Vec3::Constant(0.5));
              if ((nearest_on(static_cast<std::uint32_t>(p), centre) - centre).norm() > reach + 0.8661 * cell_)
                continue;
            }
            if (pass == 0)
              ++start_[at + 1];
            else
              part_[next[at]++] = static_cast<std::uint32_t>(p);
          }
    }
    if (pass == 0) {
      for (std::size_t k = 0; k < total; ++k) start_[k + 1] += start_[k];
      part_.resize(start_.back());
    }
  }
}

Vec3 Shape::nearest_on(std::uint32_t triangle, const Vec3& x) const {
  const Facet& f = facets_[triangle];
  const Near<double> t = near_triangle<double>(plain(x), [&f](int k) { return f[static_cast<std::size_t>(k)]; });
  return {t.point.x, t.point.y, t.point.z};
}

double Shape::distance_to(std::uint32_t part, const Vec3& x) const {
  const auto field = [&](int k) { return facets_[part][static_cast<std::size_t>(k)]; };
  switch (kind_) {
    case ShapeKind::plane:
      return (x - point_).dot(normal_);
    case ShapeKind::mesh:
      return near_triangle<double>(plain(x), field).distance;
    case ShapeKind::spheres:
      return near_sphere<double>(plain(x), field).distance;
    case ShapeKind::cylinder:
      return near_cylinder<double>(plain(x), radius_, half_width_).distance;
  }
  return 0;
}

double Shape::distance(const Vec3& x, double beyond) const {
  double d = beyond;
  if (kind_ == ShapeKind::spheres) {
    for (std::size_t k = 0; k < centres_.size(); ++k) d = std::min(d, (x - centres_[k]).norm() - radii_[k]);
    return d;
  }
  each_part_near(x, [&](std::uint32_t part) { d = std::min(d, distance_to(part, x)); });
  return solid_ && x.norm() < extent_ && mesh_.contains(x) ? -d : d;
}

}  // namespace grouser::dem
