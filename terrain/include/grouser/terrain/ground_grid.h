#pragma once
// Heights on a regular grid, bilinear between nodes.
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

/// Nodes at (x0 + i dx, y0 + j dy), i < nx, j < ny; z is row-major with x running fastest: z[j * nx + i] [m].
struct HeightGrid {
  int nx = 0, ny = 0;     ///< >= 2 each
  double x0 = 0, y0 = 0;  ///< [m]
  double dx = 0, dy = 0;  ///< [m] > 0
  std::vector<double> z;
};

/// Bilinear interpolation: exact at nodes, C0, second order. normal() is that of the cell's bilinear patch.
/// `outside`: extend, mirror or error. Cost: about 9 ns a point. `name` is used in describe() and errors.
/// @throws GroundError for a grid that is too small, of wrong size or not finite, and for Outside::repeat.
GroundPtr height_map_ground(HeightGrid grid, Outside outside, std::string name);

}  // namespace grouser
