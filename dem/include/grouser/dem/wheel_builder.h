#pragma once
// Wheels of section 3.2.2 as surfaces for grains: a closed mesh, or a clump of overlapping spheres as the dissertation's.
//
// Tread radius across the width, y from the middle, R = `tread_radius` (0: flat):
//
//   r(y) = radius - (R_e - R_m),   R_m = sqrt(R^2 - y^2), R_e = sqrt(R^2 - (width/2)^2)                           (W1)
//
// so a concave tread has its largest radius at both edges and is lower in the middle by the sagitta. Lugs stand on the tread from edge
// to edge, lug_height above it everywhere. A sidewall is a ring on each edge, sidewall_height above the tread and `wall` thick. An open
// side shows a rim `shell` thick; a single closed side is the one at +y (a disc `shell` thick), two make a solid wheel, none an open ring.
// Source: W. Smith's dissertation, section 3.2.2 and Table 3.3; shell = 10 mm and wall = 2 mm are the diameters of its particles. Which
// way its tread is curved and where its sidewall is are not told: read as above.
#include <vector>

#include "grouser/dem/surface.h"
#include "grouser/terrain/running_gear.h"

namespace grouser::dem {

struct WheelShape {
  double radius = 0, width = 0;  ///< [m] > 0
  double tread_radius = 0;       ///< [m] 0: flat; else >= width/2
  int lugs = 0;                  ///< >= 0
  double lug_height = 0;         ///< [m]
  double lug_thickness = 0.002;  ///< [m] along the circumference
  int closed_sides = 2;          ///< 0, 1, 2
  double sidewall_height = 0;    ///< [m]
  double shell = 0.01;           ///< [m]
  double wall = 0.002;           ///< [m]
};

/// @throws DemError for a mesh, which has a shape of its own, or a wheel that is not one (radius or width not positive, shell wider than the wheel).
WheelShape wheel_shape(const RunningGear& gear);
/// r(y) of W1, sidewall included [m].
double tread_radius_at(const WheelShape& w, double y);

/// Closed mesh of `segments` strips around (72: within 0.1 % of the radius), lugs as closed bodies of their own set into the tread.
Mesh wheel_mesh(const WheelShape& w, int segments = 72);

struct Clump {
  std::vector<Vec3> centres;  ///< [m] about the hub, y = spin axis
  std::vector<double> radii;  ///< [m]
};
/// Spheres of `diameter` whose outside is the surface (no sphere reaches beyond it), and of `lug_diameter` in the lugs, `spacing` of
/// their radius apart (the dissertation: 0.75). Discs of closed sides are filled, the inside is hollow. Sidewalls as lugs.
Clump wheel_clump(const WheelShape& w, double diameter = 0.01, double lug_diameter = 0.002, double spacing = 0.75);

}  // namespace grouser::dem
