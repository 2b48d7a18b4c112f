#pragma once
// Where a ground has heights: a grid of them for the 3-D view, and whether a wheel stands on them. Internal.
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/running_gear.h"

namespace grouser::vehicle {

struct GroundView {
  std::vector<double> x, y;    ///< [m]
  std::vector<double> height;  ///< [m] row per y
};

/// Heights at the nodes x[i], y[j]. Of a ground that ends (`outside: error`) border rows and columns are left out until
/// all that remain lie on its data; empty when none do.
GroundView ground_view(const Ground& ground, std::vector<double> x, std::vector<double> y);

/// As the static datasets ground.x, ground.y and ground.height; nothing for an empty view.
void write_ground_view(Recorder& file, const GroundView& view);

/// Empty when the ground has heights under a wheel with its centre at `p` and its axle along `axle` (both world), to
/// `reach` radii before and behind and over its width; else what the ground says (`outside: error`).
std::string off_ground(const Ground& ground, const RunningGear& gear, const Vec3& p, const Vec3& axle, double reach);

}  // namespace grouser::vehicle
