#pragma once
// The undisturbed ground: a height over the plane. Shapes are built from YAML by loaders.h.
#include <memory>
#include <string>

#include "grouser/terrain/types.h"

namespace grouser {

/// Height field z = h(x, y) [m]. Implementations are immutable and thread-safe.
class Ground {
 public:
  virtual ~Ground() = default;
  /// [m] at world (x, y) [m], finite. Each shape's header says what lies beyond its data; `outside: error` throws there.
  virtual double height(double x, double y) const = 0;
  /// Heights at n points along the line (x0 + i dx, y0 + i dy); override where a whole line is cheaper than n points.
  virtual void heights(double x0, double y0, double dx, double dy, int n, double* out) const {
    for (int i = 0; i < n; ++i) out[i] = height(x0 + i * dx, y0 + i * dy);
  }
  /// Unit normal, z > 0. Default: central difference over 1 mm.
  virtual Vec3 normal(double x, double y) const;
  /// Smallest feature length that matters [m]: a contact search need not sample finer. Infinite for a plane.
  virtual double resolution() const = 0;
  /// One line for the report, e.g. "ISO 8608 class E, seed 1, two tracks 0.4 m apart".
  virtual std::string describe() const = 0;
};

using GroundPtr = std::shared_ptr<const Ground>;

/// Horizontal plane at height z [m].
GroundPtr flat_ground(double z = 0.0);

}  // namespace grouser
