#pragma once
// Work that pressing a wheel into the ground takes on its way over a step.
#include <algorithm>
#include <cmath>
#include <utility>

#include "grouser/terrain/wheel_motion.h"

namespace grouser {

/// Where a wheel that ends a step of constant twist in `end` was `ago` seconds before its end.
inline WheelPose earlier(const WheelPose& end, const Twist& V, double ago) {
  WheelPose p = end;
  p.hub_W -= ago * V.v;
  p.axis_W = (p.axis_W - ago * V.w.cross(p.axis_W)).normalized();
  p.along -= ago * V.v.dot(carrier_axes(end.axis_W).col(0));
  return p;
}

/// `end` with its place on the way along the ground: counted on from `along`, the place at the last step, by the hub's velocity; NaN: from
/// the world's origin. So a turn about the hub leaves the ground samples beside one another, wherever in the world the wheel is.
inline WheelMotion moved_on(WheelMotion end, double along, double dt) {
  const Vec3 forward = end.carrier.col(0);
  end.pose.along = std::isnan(along) ? end.pose.hub_W.dot(forward) : along + dt * end.V.v.dot(forward);
  return end;
}

/// How deep a wheel stands and how fast its generalised normal g says it sinks; both zero without contact.
struct Pressing {
  double sinkage = 0;  ///< h [m]
  double rate = 0;     ///< -g . V [m/s], what P3 says of dh/dt
  static Pressing of(const ContactPatch& patch, const Twist& V) {
    if (!patch.contact) return {};
    return {patch.sinkage, -(patch.g.head<3>().dot(V.v) + patch.g.tail<3>().dot(V.w))};
  }
};

/// What the work over a step may be wrong by [J]: a thousandth of the largest power at its ends, or 3e-4 of the larger force times the hub's
/// way. The second is for wheels that roll over small features: the errors of one step and the next cancel there (Belgian block: about 0.001 % of
/// the motors' work is left of them), and a wheel that happens to sink slowly is not looked at more closely than others.
inline double path_tolerance(double dt, const Twist& V, double force_begin, const Pressing& begin, double force_end,
                             const Pressing& end) {
  const double power = std::max(std::abs(force_begin * begin.rate), std::abs(force_end * end.rate));
  return dt * std::max(1e-3 * power, 3e-4 * std::max(force_begin, force_end) * V.v.norm());
}

/// Integral of F(h) (-g . V) dt over a step that ends in m [J]: the work of an elastic force F(h) g on the hub's way. It knows no potential, so
/// a ledger that holds it against the change of one finds a force that is no gradient.
///
/// F is asked for as often as it takes; patches on the way only where the rate does not run straight. On a piece of the step, F is taken at
/// the cubic through sinkage and rate at both ends and the rate as the straight line between its ends (Gauss, three points). Good where that
/// line's way agrees with what the wheel has sunk: F times the difference within `tolerance` [J]. Else the piece is halved, down to dt/64, or
/// until halving changes the way of the rate by no more than that. A piece in which the wheel touches down (or leaves) is cut where its last
/// rate says that a quarter of the depth is reached, twice; what is left over, some 1 % of the work, is taken at that rate.
/// Cost: a patch for each cut, none on most steps.
template <class Force>
class PathWork {
 public:
  PathWork(PatchFinder& finder, const Ground& ground, const WheelMotion& m, double dt, double tolerance,
           const Force& force)
      : finder_(finder), ground_(ground), m_(m), dt_(dt), tolerance_(tolerance), force_(force) {}

  double between(const Pressing& begin, const Pressing& end) { return piece(dt_, dt_, begin, end, tolerance_, 6); }

 private:
  static constexpr double kLeft = 32;  ///< work of a touch-down that may be taken at one rate, in tolerances
  Pressing at(double ago) { return Pressing::of(finder_.find(earlier(m_.pose, m_.V, ago), ground_), m_.V); }

  static double way(double width, const Pressing& a, const Pressing& b) { return 0.5 * width * (a.rate + b.rate); }

  double smooth(double width, const Pressing& a, const Pressing& b) const {
    constexpr double kPlace = 0.3872983346207417;  // of the outer two points from the middle: sqrt(0.15)
    const double step = b.sinkage - a.sinkage, da = width * a.rate - step, db = step - width * b.rate;
    double sum = 0;
    for (const auto& [x, weight] : {std::pair{0.5 - kPlace, 5.0}, {0.5, 8.0}, {0.5 + kPlace, 5.0}}) {
      const double h = a.sinkage + x * step + x * (1 - x) * ((1 - x) * da + x * db);
      sum += weight * force_(std::max(h, 0.0)) * (a.rate + x * (b.rate - a.rate));
    }
    return sum * width / 18;
  }

  /// Piece from `ago` to `ago - width` seconds before the end.
  double piece(double ago, double width, const Pressing& a, const Pressing& b, double bound, int depth) {
    const double deepest = std::max(a.sinkage, b.sinkage);
    if (!(deepest > 0)) return 0;
    if (!(std::min(a.sinkage, b.sinkage) > 0)) return touching(ago, width, a, b, bound, depth);
    const double F = force_(deepest), straight = way(width, a, b);
    if (depth == 0 || F * std::abs(straight - (b.sinkage - a.sinkage)) <= bound) return smooth(width, a, b);
    const double half = 0.5 * width;
    const Pressing middle = at(ago - half);
    if (middle.sinkage > 0 && F * std::abs(way(half, a, middle) + way(half, middle, b) - straight) <= bound)
      return smooth(half, a, middle) + smooth(half, middle, b);
    return piece(ago, half, a, middle, 0.5 * bound, depth - 1) +
           piece(ago - half, half, middle, b, 0.5 * bound, depth - 1);
  }

  /// Piece with contact at one end only.
  double touching(double ago, double width, const Pressing& a, const Pressing& b, double bound, int depth) {
    const bool down = b.sinkage > 0;
    const Pressing& in = down ? b : a;
    const double speed = down ? b.rate : -a.rate;  // at which depth has come, seen from where there is some
    if (depth == 0 || force_(in.sinkage) * in.sinkage <= kLeft * bound) {
      const Pressing edge{0, in.rate};
      const double time = speed > 0 ? std::min(in.sinkage / speed, width) : width;
      return down ? smooth(time, edge, in) : smooth(time, in, edge);
    }
    const double most = 0.75 * in.sinkage, back = speed * width > most ? most / speed : 0.5 * width;
    const double first = down ? width - back : back;
    const Pressing cut = at(ago - first);
    return piece(ago, first, a, cut, bound, depth - 1) + piece(ago - first, width - first, cut, b, bound, depth - 1);
  }

  PatchFinder& finder_;
  const Ground& ground_;
  const WheelMotion& m_;
  double dt_, tolerance_;
  const Force& force_;
};

}  // namespace grouser
