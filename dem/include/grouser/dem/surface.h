#pragma once
// Bodies that grains touch: planes, triangle meshes, a cylinder, spheres fixed to each other (a clump).
#include <array>
#include <string>
#include <vector>

#include "grouser/terrain/types.h"

namespace grouser::dem {

/// Triangles in the frame of their body; both sides are solid to grains.
struct Mesh {
  std::vector<Vec3> vertices;  ///< [m]
  std::vector<std::array<int, 3>> triangles;
  void append(const Mesh& other);
  /// Open edges, those of one triangle only: 0 for a closed mesh.
  std::size_t open_edges() const;
  /// Whether a point lies inside a closed mesh: solid angle of all triangles seen from it (Van Oosterom, Strackee 1983).
  bool contains(const Vec3& x) const;
  double area() const;    ///< [m2]
  double volume() const;  ///< [m3], signed, of a closed mesh
};
/// Box with edges `size`, centred; `open_top`, `open_bottom` leave these faces out.
Mesh box_mesh(const Vec3& size, bool open_top = false, bool open_bottom = false);
/// Flat rectangle in the plane z = 0, centred.
Mesh plate_mesh(double lx, double ly);
/// Wheel about y: rim of `segments` strips, side discs, and `lugs` rectangular lugs of height and thickness given [m].
Mesh wheel_mesh(double radius, double width, int segments, int lugs = 0, double lug_height = 0,
                double lug_thickness = 0);

struct BodySettings {
  Pose X_WB{};
  Twist V_W{};  ///< prescribed motion, or the initial one of a free body
  bool free = false;
  double mass = 1;               ///< [kg], free body
  Vec3 inertia = Vec3::Ones();   ///< principal moments in its frame [kg m2]
  std::array<bool, 6> locked{};  ///< x, y, z, rotation about x, y, z (W): keeps the prescribed value
  Vec3 force = Vec3::Zero();     ///< [N] applied at its origin, besides gravity
  Vec3 torque = Vec3::Zero();    ///< [N m]
};

/// What the grains do to a body or to one of its surfaces.
struct SurfaceReport {
  Vec3 force = Vec3::Zero();    ///< [N] in the last step
  Vec3 torque = Vec3::Zero();   ///< [N m] about the body's origin
  Vec3 impulse = Vec3::Zero();  ///< [N s] since the start
  Vec3 angular_impulse =
      Vec3::Zero();  ///< [N m s] since the start: sum of torque times step, about the body's origin as it was then
  double work = 0;   ///< [J] by the body on the grains since the start
  int contacts = 0;
};

/// Contact of a grain with a body, from its springs (dampers and rolling torques, some per cent, are left out).
struct BodyContact {
  Vec3 at = Vec3::Zero();     ///< [m] from the body's origin, axes W
  Vec3 force = Vec3::Zero();  ///< [N] on the body, W
};

}  // namespace grouser::dem
