#pragma once
// What the loop over contacts with surfaces reads of a triangle or a sphere, beside each contact: plain numbers in
// lanes, filled when a list of grains near surfaces is made.
#include <array>

#include "store.h"

namespace grouser::dem {

enum class ShapeKind { plane, mesh, cylinder, spheres };

/// Places of the numbers of a facet.
struct FacetField {
  static constexpr int corner = 0;    ///< 3: corner A of a triangle, centre of a sphere [m]
  static constexpr int radius = 3;    ///< of a sphere
  static constexpr int u = 3, v = 6;  ///< 3 each: B - A, C - A
  static constexpr int normal = 9;    ///< 3: unit
  static constexpr int uu = 12, uv = 13, vv = 14;
  static constexpr int inv_uu = 15, inv_vv = 16, inv_ww = 17;  ///< w = C - B
  static constexpr int inv_det = 18;                           ///< of uu, uv, uv, vv
  static constexpr int count = 19;
};
using Facet = std::array<double, FacetField::count>;

/// In the frame of the body, for the lanes of one block of contacts.
struct alignas(64) FacetBlock {
  double field[FacetField::count][kBlock];
  double point[3][kBlock], distance[kBlock];  ///< nearest point of the last step, centre of the grain to it
};

}  // namespace grouser::dem
