#pragma once
// The way of one wheel over a row of soil of its own, for the surrogates in the plane.
#include <cmath>
#include <optional>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/terrain.h"
#include "grouser/terrain/types.h"

namespace grouser::sdem {

struct OwnWay {
  double s = 0;                  ///< hub along its way [m]
  Vec3 hub = Vec3::Zero();       ///< [m, W] at the last step's end
  Vec3 forward = Vec3::UnitX();  ///< there
  bool placed = false;

  /// Whether a wheel that begins its step at `begin` was put elsewhere, or nowhere yet: it meets fresh soil.
  bool fresh(const Vec3& begin, double radius) const { return !placed || (begin - hub).norm() > 0.1 * radius; }

  /// Goes on from `begin` to `end` along `ahead`. Returns s before.
  double go(const Vec3& begin, const Vec3& end, const Vec3& ahead) {
    const double from = s;
    s = from + (end - begin).dot(ahead);
    hub = end;
    forward = ahead;
    return from;
  }

  /// Undisturbed ground at s [m].
  double ground(const Ground& g, double at) const {
    return g.height(hub.x() + (at - s) * forward.x(), hub.y() + (at - s) * forward.y());
  }

  /// Distance ahead of the hub of a place within the wheel's width; none beside it [m].
  std::optional<double> ahead_of_hub(double x, double y, double width) const {
    const Vec2 d(x - hub.x(), y - hub.y());
    const double along = d.x() * forward.x() + d.y() * forward.y(), across = d.y() * forward.x() - d.x() * forward.y();
    if (!placed || std::abs(across) > 0.5 * width) return std::nullopt;
    return along;
  }

  void traverse(State& state) {
    state.field("s", s);
    state.field("hub", hub);
    state.field("forward", forward);
    state.field("placed", placed);
  }
};

/// The surface there is `h`, unless that is no number.
inline void lay_over(SurfaceSample& sample, double h) {
  if (!std::isfinite(h)) return;
  sample.sinkage += sample.height - h;
  sample.height = h;
}

}  // namespace grouser::sdem
