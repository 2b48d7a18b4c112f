#pragma once
// Parts of a run file that say what a body looks like and what was assumed.
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/running_gear.h"

namespace grouser::vehicle {

/// Surface of a running gear for the 3-D view, in the gear frame: the mesh itself, or a cylinder of 48 facets with its lugs.
TriangleMesh view_mesh(const RunningGear& gear);

/// Statics mesh.<body>.vertices and mesh.<body>.triangles.
void write_gear_mesh(Recorder& file, const std::string& body, const RunningGear& gear);

/// JSON list of {file, key, value, why}.
std::string assumptions_json(const std::vector<Assumption>& a);

}  // namespace grouser::vehicle
