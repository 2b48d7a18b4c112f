#include "shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grouser::dem {

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
  s.mesh_ = std::move(m);
  return s;
}
Shape Shape::spheres(std::vector<Vec3> centres, std::vector<double> radii) {
  Shape s;
  s.kind_ = ShapeKind::spheres;
  for (std::size_t k = 0; k < centres.size(); ++k) s.extent_ = std::max(s.extent_, centres[k].norm() + radii[k]);
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

/// Nearest point of a triangle (Ericson 2005, section 5.1.5: regions of Voronoi).
Vec3 Shape::nearest_on(std::uint32_t triangle, const Vec3& p) const {
  const auto& t = mesh_.triangles[triangle];
  const Vec3 &a = mesh_.vertices[static_cast<std::size_t>(t[0])], &b = mesh_.vertices[static_cast<std::size_t>(t[1])],
             &c = mesh_.vertices[static_cast<std::size_t>(t[2])];
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = 1 / (va + vb + vc);
  return a + ab * (vb * sum) + ac * (vc * sum);
}

double Shape::distance(const Vec3& x, double beyond) const {
  double d = beyond;
  if (kind_ == ShapeKind::spheres) {
    for (std::size_t k = 0; k < centres_.size(); ++k) d = std::min(d, (x - centres_[k]).norm() - radii_[k]);
    return d;
  }
  each_part_near(x, [&](std::uint32_t part) { d = std::min(d, touch(part, x).distance); });
  return solid_ && x.norm() < extent_ && mesh_.contains(x) ? -d : d;
}

Touch Shape::touch(std::uint32_t part, const Vec3& x) const {
  Touch t;
  const auto outside = [&](const Vec3& q) {
    t.point = q;
    const Vec3 d = q - x;
    t.distance = d.norm();
    t.normal = t.distance > 0 ? Vec3(d / t.distance) : Vec3::UnitZ();
  };
  switch (kind_) {
    case ShapeKind::plane:
      t.distance = (x - point_).dot(normal_);
      t.normal = -normal_;
      t.point = x - t.distance * normal_;
      break;
    case ShapeKind::mesh:
      outside(nearest_on(part, x));
      break;
    case ShapeKind::spheres: {
      const Vec3 d = centres_[part] - x;
      const double length = d.norm();
      t.normal = d / length;
      t.distance = length - radii_[part];
      t.point = x + t.distance * t.normal;
      t.curvature = 1 / radii_[part];
      break;
    }
    case ShapeKind::cylinder: {
      const double rho = std::hypot(x[0], x[2]);
      const Vec3 out = rho > 0 ? Vec3(x[0] / rho, 0, x[2] / rho) : Vec3::UnitX();
      const bool between = std::fabs(x[1]) <= half_width_;
      if (between && (rho >= radius_ || radius_ - rho <= half_width_ - std::fabs(x[1]))) {
        t.distance = rho - radius_;
        t.normal = -out;
        t.point = Vec3(radius_ * out[0], x[1], radius_ * out[2]);
      } else if (rho <= radius_) {
        const double side = x[1] < 0 ? -1 : 1;
        t.distance = std::fabs(x[1]) - half_width_;
        t.normal = Vec3(0, -side, 0);
        t.point = Vec3(x[0], side * half_width_, x[2]);
      } else {
        outside(Vec3(radius_ * out[0], std::copysign(half_width_, x[1]), radius_ * out[2]));
      }
      break;
    }
  }
  return t;
}

}  // namespace grouser::dem
