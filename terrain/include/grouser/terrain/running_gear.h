#pragma once
// What touches the soil: smooth cylinder, lugged cylinder (flat or concave tread), triangle mesh.
#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "grouser/terrain/types.h"

namespace grouser {

/// Rigid smooth cylinder; gear frame G: origin at the hub, y = spin axis.
struct SmoothCylinder {
  double radius = 0;  ///< [m] > 0
  double width = 0;   ///< [m] > 0
};

/// Cylinder with grousers (lugs). `radius` is the tread without lugs (dissertation Table 2.3, 3.3).
struct LuggedCylinder {
  double radius = 0;      ///< [m] > 0, largest tread radius without lugs
  double width = 0;       ///< [m] > 0
  double lug_height = 0;  ///< [m] > 0
  double lug_width = 0;   ///< [m] >= 0, thickness along the circumference
  int lug_count = 0;      ///< [-] >= 1
  double lug_ratio = 0;   ///< [-] mu of eq 2.15: share of the lug-tip area, 0..1; default count * width / circumference
  double tread_radius = 0;     ///< [m] radius of curvature of a concave tread across the width; 0 = flat
  int closed_sides = 2;        ///< 0, 1 or 2 closed wheel sides
  double sidewall_height = 0;  ///< [m] >= 0
};

/// Closed triangle mesh, gear frame as above.
struct TriangleMesh {
  std::vector<Vec3> vertices;                          ///< [m]
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< counter-clockwise seen from outside
  double radius = 0;                                   ///< [m] nominal radius used for slip
  double width = 0;                                    ///< [m] extent along y
};

/// One running gear with its name and source. Immutable after loading.
struct RunningGear {
  std::string name;
  std::variant<SmoothCylinder, LuggedCylinder, TriangleMesh> shape;

  double radius() const;        ///< [m] without lugs: the radius in the definition of slip
  double outer_radius() const;  ///< [m] with lugs
  double width() const;         ///< [m]
};

}  // namespace grouser
