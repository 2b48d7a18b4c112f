#pragma once
// Surface of a running gear above the soil nodes: height, normal and cover of each node, from the gear's own geometry.
#include <array>
#include <vector>

#include "grouser/terrain/running_gear.h"
#include "node_kernel.h"

namespace grouser::bekker::node {

/// Lugs one by one, or as a mean over tips and tread (eq 2.15); automatic: one by one where a lug takes two nodes and
/// stays on them until their shear is mobilised, 4 K.
enum class Lugs { automatic, mean, resolved };

/// Gear turned to its attitude over a node: frame of the grid's axes, origin at the hub.
class GearShape {
 public:
  /// least: width [m] from which `automatic` takes lugs one by one.
  GearShape(const RunningGear& gear, Lugs lugs, double least);

  /// Lugs as a mean at this spacing of the nodes.
  bool takes_mean(double spacing) const;
  /// Choose how lugs are carried; before anything below.
  void resolve(double spacing);
  /// A cylinder, smooth or with lugs as a mean: the kernel does it alone.
  bool smooth() const { return mean_ || std::holds_alternative<SmoothCylinder>(gear_.shape); }
  /// Tip share and tread for the kernel.
  void mean_lugs(Gear& g) const;
  double radius() const { return radius_; }  ///< outermost
  double width() const { return gear_.width(); }

  /// Turn to this attitude (gear frame in grid axes); g has the carrier axes.
  void turn(const Quat& q, const Gear& g);
  /// Fill the 5 arrays of a segment (Segment::surface).
  void cover(const Gear& g, const Segment& s, double* out) const;

 private:
  void cover_profile(const Gear& g, const Segment& s, double* out) const;
  void cover_mesh(const Gear& g, const Segment& s, double* out) const;

  RunningGear gear_;
  Lugs lugs_option_;
  double least_;
  bool mean_ = false;
  double radius_;
  std::vector<Vec3> turned_;                        ///< mesh: vertices in grid axes
  std::vector<std::array<std::int32_t, 3>> below_;  ///< mesh: triangles that face down
  std::vector<std::array<double, 4>> lugs_;         ///< lugs near the bottom: sin, cos of the angle from the bottom
};

}  // namespace grouser::bekker::node
