#pragma once
// Triangle meshes of bodies and wheels for the 3-D view.
#include <vector>

#include "grouser/vehicle/vehicle_spec.h"

namespace grouser::vehicle {

struct VisualMesh {
  std::vector<double> vertices;   ///< [m] x y z, body frame
  std::vector<double> triangles;  ///< vertex indices, three per triangle
};

/// A wheel body shows its running gear; smooth wheels get a shallow tread pattern so that one sees them turn.
VisualMesh visual_mesh(const VehicleSpec& v, int link);

}  // namespace grouser::vehicle
