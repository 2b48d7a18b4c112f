#pragma once
// Triangle meshes from OBJ and STL files, checked.
#include <filesystem>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/running_gear.h"

namespace grouser {

/// Vertices and triangles in metres (file units times `scale`), equal vertices joined. Every fault is noted with file
/// and line (triangle number for binary STL): unreadable numbers, bad indices, degenerate triangles, open or inside-out
/// surfaces.
TriangleMesh read_mesh(const std::filesystem::path& file, double scale, std::vector<Diagnostic>& faults);

}  // namespace grouser
