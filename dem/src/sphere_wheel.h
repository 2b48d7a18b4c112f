#pragma once
// A running gear among grains: its surface in the solver, what it overlaps, where it touches, which tiles it needs.
#include <algorithm>
#include <vector>

#include "grouser/dem/wheel_builder.h"
#include "grouser/terrain/ground.h"
#include "grouser/terrain/terrain.h"
#include "sphere_tiles.h"

namespace grouser::dem {

/// How a wheel is built.
struct WheelForm {
  bool mesh = false;                             ///< also where a cylinder would do
  bool clump = false;                            ///< spheres, as the dissertation's
  double diameter = 0.01, lug_diameter = 0.002;  ///< [m] of them
};

/// Soil that moves around a contact [m]: along the wheel's way and along its axle.
struct PatchReach {
  double along = 0, across = 0;
  double least() const { return std::min(along, across); }
  double most() const { return std::max(along, across); }
};

class SphereWheel {
 public:
  /// @throws TerrainError for a gear that cannot be carried.
  /// `slab`: width of a periodic slab that the wheel crosses without end [m]; 0: a wheel of its own width.
  SphereWheel(const BodySpec& body, const WheelForm& form, double slab = 0);
  /// Adds body and surface to the solver; X: pose of the gear, z of the solver.
  void add_to(Solver& solver, const Pose& X, int material) const;
  double radius() const { return radius_; }  ///< outer [m]
  double half_width() const { return half_width_; }  ///< its own [m]

  /// Depth of a sphere in the cylinder over the gear [m], negative clear of it. Coordinates as those of X.
  double overlap(const Pose& X, const Vec3& centre, double r) const;

  struct Arc {
    int touching = 0;
    double entry = 0, exit = 0;    ///< [rad] from the bottom of the wheel, positive forward
    Vec3 centre_W = Vec3::Zero();  ///< mean of the touching grains' centres, less the hub [m]
  };
  /// Grains (not `skip`) that touch the cylinder, wheel at X over the torus lx x ly.
  template <class Skip>
  Arc arc(const Pose& X, const std::vector<GrainState>& grains, double lx, double ly, Skip skip) const {
    Arc out;
    const Mat3 C = carrier_axes(X.q * Vec3::UnitY());
    const double reach = std::hypot(radius_, std::max(half_width_, slab_));
    for (std::size_t k = 0; k < grains.size(); ++k) {
      const GrainState& g = grains[k];
      Vec3 d = g.x - X.p;
      d[0] -= lx * std::round(d[0] / lx);
      d[1] -= ly * std::round(d[1] / ly);
      const double far = reach + g.radius;
      if (d.squaredNorm() > far * far || skip(k)) continue;
      if (overlap(X, X.p + d, g.radius) <= 0) continue;
      const Vec3 c = C.transpose() * d;
      const double angle = std::atan2(c[0], -c[2]);
      out.entry = out.touching ? std::max(out.entry, angle) : angle;
      out.exit = out.touching ? std::min(out.exit, angle) : angle;
      out.centre_W += d;
      ++out.touching;
    }
    if (out.touching) out.centre_W /= out.touching;
    return out;
  }

  /// Tiles lx x ly nearer than `reach` to the part of the wheel at X (world) that may be in the soil, or nearer than `keep` and in `now`.
  void tiles_near(const Pose& X, const Ground& ground, double lx, double ly, const PatchReach& reach,
                  const PatchReach& keep, double clear, const std::vector<Tile>& now, std::vector<Tile>& into) const;

 private:
  double radius_, half_width_, slab_;
  Mesh mesh_;    ///< empty: smooth cylinder
  Clump clump_;  ///< instead
};

/// Stiffness of a wheel on grains at rest for small motions [N/m], an estimate within a factor of about two, of an elastic half-space under a
/// rigid patch of area A under the force N; moduli of a random packing by Hertz-Mindlin mean field (Walton 1987, as in Mavko,
/// Mukerji and Dvorkin 2009, section 5.4) with 5 contacts per grain and a solid fraction of 0.57.
double patch_stiffness(const Material& m, double force, double area);

}  // namespace grouser::dem
