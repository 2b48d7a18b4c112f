#pragma once
// Geometry of one surface in the frame of its body: which parts a sphere may touch, and where.
#include <vector>

#include "facet.h"
#include "grouser/dem/surface.h"

namespace grouser::dem {

class Shape {
 public:
  static Shape plane(const Vec3& point, const Vec3& normal);
  static Shape cylinder(double radius, double half_width);  ///< about y; half_width infinite: no sides
  static Shape mesh(Mesh m, bool solid);
  static Shape spheres(std::vector<Vec3> centres, std::vector<double> radii);

  ShapeKind kind() const { return kind_; }
  const Vec3& point() const { return point_; }
  const Vec3& normal() const { return normal_; }
  /// Prepare the search for spheres up to this radius plus margin.
  void prepare(double reach);
  /// Parts that a sphere at x may touch; `f(part)` for each.
  template <class F>
  void each_part_near(const Vec3& x, F&& f) const {
    if (kind_ == ShapeKind::plane || kind_ == ShapeKind::cylinder) {
      f(0u);
      return;
    }
    int c[3];
    for (int k = 0; k < 3; ++k) {
      const double u = (x[k] - lo_[k]) / cell_;
      if (!(u >= 0 && u < n_[k])) return;
      c[k] = static_cast<int>(u);
    }
    const std::size_t at = (static_cast<std::size_t>(c[0]) * n_[1] + c[1]) * n_[2] + c[2];
    for (std::uint32_t e = start_[at]; e < start_[at + 1]; ++e) f(part_[e]);
  }
  /// Centre to part, negative when the centre is inside.
  double distance_to(std::uint32_t part, const Vec3& x) const;
  /// Nearest point of a triangle of the mesh.
  Vec3 nearest_on(std::uint32_t triangle, const Vec3& x) const;
  const Facet& facet(std::uint32_t part) const { return facets_[part]; }
  /// 1/radius of a sphere [1/m], 0 for all others.
  double curvature(std::uint32_t part) const { return kind_ == ShapeKind::spheres ? 1 / radii_[part] : 0; }
  double radius() const { return radius_; }  ///< of a cylinder
  double half_width() const { return half_width_; }
  double extent() const { return extent_; }
  /// Distance of a point from the surface, or `beyond` when it is outside the reach prepared for; negative inside a
  /// cylinder, a sphere, a solid mesh, behind a plane.
  double distance(const Vec3& x, double beyond) const;

 private:
  ShapeKind kind_ = ShapeKind::plane;
  Vec3 point_ = Vec3::Zero(), normal_ = Vec3::UnitZ();
  double radius_ = 0, half_width_ = 0, extent_ = 0;
  Mesh mesh_;
  bool solid_ = false;
  std::vector<Vec3> centres_;
  std::vector<double> radii_;
  std::vector<Facet> facets_;  ///< of triangles or spheres
  // Uniform cells over the parts, each listing what is within reach of any point in it.
  Vec3 lo_ = Vec3::Zero();
  double cell_ = 1;
  int n_[3] = {0, 0, 0};
  std::vector<std::uint32_t> start_, part_;
};

}  // namespace grouser::dem
