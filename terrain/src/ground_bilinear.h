#pragma once
// Bilinear lookup shared by height maps and profiles; not installed.
#include <cmath>

#include "ground_detail.h"
#include "grouser/terrain/ground_grid.h"

namespace grouser::ground_detail {

/// Cell and position in it; sign_u, sign_v turn the cell's gradient into the ground's (-1 mirrored, 0 on an extended
/// edge).
struct Place {
  std::size_t k = 0;
  double fu = 0, fv = 0;
  double sign_u = 1, sign_v = 1;
};

/// Fold u into 0..m, back and forth; the sign is that of du_folded/du.
inline double mirror(double& u, double m) {
  if (u >= 0 && u <= m) return 1;
  double r = std::fmod(std::abs(u), 2 * m);
  double sign = u < 0 ? -1 : 1;
  if (r > m) {
    r = 2 * m - r;
    sign = -sign;
  }
  u = r;
  return sign;
}

struct BilinearField {
  explicit BilinearField(HeightGrid g)
      : grid(std::move(g)), inverse_dx(1 / grid.dx), inverse_dy(1 / grid.dy), u_max(grid.nx - 1), v_max(grid.ny - 1) {}
  HeightGrid grid;
  double inverse_dx, inverse_dy, u_max, v_max;

  double u(double x) const { return (x - grid.x0) * inverse_dx; }
  double v(double y) const { return (y - grid.y0) * inverse_dy; }

  /// u, v in node units, clamped to the grid.
  void locate(double uu, double vv, Place& p) const {
    uu = uu > 0 ? (uu < u_max ? uu : u_max) : 0;
    vv = vv > 0 ? (vv < v_max ? vv : v_max) : 0;
    int i = static_cast<int>(uu), j = static_cast<int>(vv);
    if (i > grid.nx - 2) i = grid.nx - 2;
    if (j > grid.ny - 2) j = grid.ny - 2;
    p.k = static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.nx) + static_cast<std::size_t>(i);
    p.fu = uu - i;
    p.fv = vv - j;
  }
  double height(const Place& p) const {
    const double* a = grid.z.data() + p.k;
    const double* b = a + grid.nx;
    // Weights rather than differences: exact at all four nodes.
    const double lower = (1 - p.fu) * a[0] + p.fu * a[1], upper = (1 - p.fu) * b[0] + p.fu * b[1];
    return (1 - p.fv) * lower + p.fv * upper;
  }
  Vec2 gradient(const Place& p) const {
    const double* a = grid.z.data() + p.k;
    const double* b = a + grid.nx;
    return {((1 - p.fv) * (a[1] - a[0]) + p.fv * (b[1] - b[0])) * inverse_dx,
            ((1 - p.fu) * (b[0] - a[0]) + p.fu * (b[1] - a[1])) * inverse_dy};
  }
};

/// @throws GroundError for a grid that is too small, of wrong size or not finite.
void check_grid(const HeightGrid& g, const std::string& name);

}  // namespace grouser::ground_detail
