#pragma once
#include <array>

#include "pieces.h"

namespace grouser::bekker {

/// Sizes of the rules that met the tolerance on one arc, for arcs nearby: with the same plan the result is a smooth function of the arc,
/// which a root finder needs, and costs one pass.
struct RulePlan {
  std::array<signed char, kMostPieces> size{};
  int pieces = 0;  ///< 0: none yet, or a piece had to be halved
};

/// Eq 2.11 by quadrature of the stresses. The arc must be in range (status_of). A plan for as many pieces is followed without a check of
/// the tolerance; another one is replaced by what this arc needed.
ForceResult nonlinear_forces(const Arc& arc, double tolerance, RulePlan* plan = nullptr) noexcept;

}  // namespace grouser::bekker
