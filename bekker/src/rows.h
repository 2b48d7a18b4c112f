#pragma once
// Several wheels at once, one to a lane, for batches: driven smooth wheels on virgin soil, whose arcs need two pieces.
#include <array>

#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// Of theta_f: where theta_m lies farther behind the bottom, the pressure's root at -theta_f is felt there.
inline constexpr double kMirror = 0.5;

/// Eight wheels of one shear law.
struct Rows {
  static constexpr int kSize = 8;
  enum Value {
    radius,
    width,
    theta_f,
    theta_m,
    theta_r,
    modulus,
    exponent,
    cohesion,
    tan_phi,
    inv_K,
    Kr,
    e_t,  ///< slip before plan_rows
    e_l,  ///< slip angle before plan_rows
    kValues
  };
  alignas(64) std::array<std::array<double, kSize>, kValues> value;

  /// Whether plan_rows may be asked about this case (its status_of is ok).
  static bool takes(const ForceCase& c) {
    return c.slip >= 0 && c.wheel.lug_height == 0 && c.unloading_sinkage == 0 && c.arc.theta_m > c.arc.theta_r &&
           c.arc.theta_m >= -kMirror * c.arc.theta_f;
  }
  void set(int lane, const ForceCase& c) {
    const SoilLaw& s = c.soil;
    const double all[kValues]{
        c.wheel.radius, c.wheel.width, c.arc.theta_f,    c.arc.theta_m, c.arc.theta_r,
        s.modulus,      s.n,           s.shear.cohesion, s.tan_phi,     1 / s.shear_displacement(),
        s.shear.Kr,     c.slip,        c.slip_angle};
    for (int i = 0; i < kValues; ++i) value[i][lane] = all[i];
  }
  void copy(int to, const Rows& from, int lane) {
    for (int i = 0; i < kValues; ++i) value[i][to] = from.value[i][lane];
  }
};

/// Points on a piece, by class. A rule has the nodes for both powers that the entry asks for (p = 2, 3; q = 1).
inline constexpr std::array<int, 8> kRowSizes{8, 10, 12, 16, 20, 24, 32, 48};
inline constexpr int kRowClasses = static_cast<int>(kRowSizes.size());
struct RowRule {
  int n = 0;
  std::array<const double*, 2> x{}, w{};
  const double* null = nullptr;
  double limit = 0;  ///< for the sums of `null`, of the force: the rule's error is about the square of them
};
const RowRule& row_rule(int row_class);

/// Classes of the rules that each row needs ahead of theta_m and behind for 1e-6; -1: none of them, or the shear turns
/// too sharply for two pieces.
struct RowPlan {
  std::array<signed char, Rows::kSize> front, rear;
};

/// Forces of the rows, and whether the highest Legendre coefficients of the stresses are as small as they should be.
struct RowSums {
  alignas(64) std::array<std::array<double, Rows::kSize>, 6> wrench;
  std::array<bool, Rows::kSize> smooth;
};

}  // namespace grouser::bekker
