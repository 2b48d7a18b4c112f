#pragma once
// Shared by the ground shapes; not installed.
#include <cmath>
#include <cstdio>
#include <string>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser::ground_detail {

/// 3u^2 - 2u^3 with u clamped to 0..1, and its derivative.
inline double smooth(double u) {
  u = u <= 0 ? 0 : u >= 1 ? 1 : u;
  return u * u * (3 - 2 * u);
}
inline double smooth_slope(double u) { return u <= 0 || u >= 1 ? 0 : 6 * u * (1 - u); }

inline Vec3 normal_from_gradient(double gx, double gy) {
  const double k = 1 / std::sqrt(1 + gx * gx + gy * gy);
  return {-gx * k, -gy * k, k};
}

struct Frame {
  explicit Frame(const GroundFrame& f)
      : c(std::cos(f.heading)), s(std::sin(f.heading)), start(f.start), lateral(f.lateral) {}
  double c, s, start, lateral;
  double along(double x, double y) const { return x * c + y * s - start; }
  double across(double x, double y) const { return y * c - x * s - lateral; }
  Vec3 normal(double g_along, double g_across) const {
    return normal_from_gradient(g_along * c - g_across * s, g_along * s + g_across * c);
  }
};

/// height() and heights() from the shape's inline at(x, y): one virtual call per line, and the same bits.
template <class Shape>
class GroundShape : public Ground {
 public:
  double height(double x, double y) const final { return static_cast<const Shape&>(*this).at(x, y); }
  void heights(double x0, double y0, double dx, double dy, int n, double* out) const final {
    const Shape& shape = static_cast<const Shape&>(*this);
    for (int i = 0; i < n; ++i) out[i] = shape.at(x0 + i * dx, y0 + i * dy);
  }
};

inline std::string number(double x) {
  char buf[32];
  std::snprintf(buf, sizeof buf, "%.6g", x);
  return buf;
}

inline double degrees(double rad) { return rad * 180 / pi; }

/// ", heading 30 deg, start 2 m", only what differs from the default.
inline std::string frame_text(const GroundFrame& f) {
  std::string t;
  if (f.heading != 0) t += ", heading " + number(degrees(f.heading)) + " deg";
  if (f.start != 0) t += ", start " + number(f.start) + " m";
  if (f.lateral != 0) t += ", lateral " + number(f.lateral) + " m";
  return t;
}

inline void require(bool ok, const std::string& message) {
  if (!ok) throw GroundError(message);
}
inline void check_frame(const GroundFrame& f) {
  require(std::isfinite(f.start) && std::isfinite(f.lateral), "start and lateral must be finite");
  require(std::abs(f.heading) <= pi + 1e-12, "heading must be within -180..180 deg");
}

}  // namespace grouser::ground_detail
