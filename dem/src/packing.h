#pragma once
#include "grouser/dem/soil_test.h"

namespace grouser::dem {

/// Loose grains in a column above z = 0, none overlapping, of this solid volume together; `walls`: inside, not wrapped.
std::vector<GrainState> scatter(const SoilSettings& soil, double lx, double ly, bool walls, double solid_volume);
/// Mean over squares of the highest grain top [m].
double surface_height(const std::vector<GrainState>& grains, double lx, double ly, double square);
double total_mass(const std::vector<GrainState>& grains);
/// Step until the mass-weighted rms velocity is below `slow` [m/s], `limit` [s] at most. Returns the time taken.
double settle(Solver& solver, double slow, double limit, const Progress& progress);

}  // namespace grouser::dem
