#pragma once
// Where a wheel meets the ground: overlap of a rolling disc with any height field, reduced to one equivalent flat patch.
#include <limits>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/types.h"

namespace grouser {

/// Cylinder at a pose: hub p_WH, unit spin axis y_W, radius and width [m].
struct WheelPose {
  Vec3 hub_W = Vec3::Zero();
  Vec3 axis_W = Vec3::UnitY();
  double radius = 0, width = 0;
  /// Way of the hub along the ground [m], from which the ground samples are counted; NaN: hub_W . x_C. A wheel that yaws far from the
  /// world's origin needs a count of its own: there hub_W . x_C changes by the turn alone, and the samples would slide over the ground.
  double along = std::numeric_limits<double>::quiet_NaN();
};

struct PatchOptions {
  int strips = 3;               ///< 1..15 discs across the width, each the middle of an equal share of it
  int samples_per_radius = 24;  ///< 4..400 ground samples per wheel radius where the ground has features that small
};

/// Equivalent flat patch of a wheel.
///
/// Each strip is a disc in the wheel plane (x_C, z_C). The ground along the strip is a polyline through samples that are fixed in
/// the world, cut exactly at the circle. With A overlap area, w(x) the polyline and S = z - h(x, y) the ground,
///   grad_hub A = -c,   c = sum over the pieces inside of integral grad S/(grad S . z_C) dx                        (P1)
/// (on a plane: chord length times the normal). Means over the strips give A and c; the sinkage h of a flat ground with
/// the same overlap follows from
///   A = r^2 (a - sin a cos a),  h = r (1 - cos a),  chord = 2 r sin a                                             (P2)
/// and the generalised normal is g = (c, m)/chord, m = moment of c about the hub, so that
///   dh/dt = -g . (v, w) for every motion of the hub                                                               (P3)
/// A force F(h) g is then conservative, continuous at touch-down and has no moment about the spin axis.
///
/// Limits: on a plane exact (camber and side slope included); elsewhere the ground is a polyline of spacing
/// max(r/samples_per_radius, min(Ground::resolution(), r/2)); its slope across is taken at
/// each strip (where the camber enters, one fitted value). Over a vertical face across the width the overlap of a strip jumps.
/// A hub below the ground still gives a patch (a up to pi).
struct ContactPatch {
  bool contact = false;
  double area = 0;   ///< A [m^2], mean over strips; a strip less than r/100 deep counts gently (see terrain/README.md)
  double angle = 0;  ///< a [rad], entry angle theta_f of the equivalent flat patch
  double sinkage = 0;              ///< h [m]
  double chord = 0;                ///< 2 r sin a [m]
  double length_ratio = 1;         ///< |c|/chord: 1 on a plane without camber
  Vec6 g = Vec6::Zero();           ///< (c, m)/chord [-, m]
  Vec3 normal_W = Vec3::UnitZ();   ///< n = c/|c|
  Vec3 forward_W = Vec3::UnitX();  ///< t = y_C x n, unit
  Vec3 lateral_W = Vec3::UnitY();  ///< l = n x t
  Vec3 arm_W = Vec3::Zero();       ///< hub to the line of the normal force, perpendicular to n [m]
  Vec3 point_W = Vec3::Zero();     ///< middle of the contact, W [m]
};

/// Finds patches; keeps its buffers, so one instance per thread or per wheel. No allocation after the first call of a size.
class PatchFinder {
 public:
  explicit PatchFinder(PatchOptions options = {}) : options_(options) {}
  ContactPatch find(const WheelPose& wheel, const Ground& ground);

 private:
  PatchOptions options_;
  std::vector<double> heights_;
};

/// Half angle a of the circular segment of area q r^2, q = a - sin a cos a in [0, pi]. Newton from a series start: relative error
/// of a below 1e-13 (checked by tests against bisection).
double segment_angle(double q);

}  // namespace grouser
