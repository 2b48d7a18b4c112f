#pragma once
// Terrain model dem.sphere: grains under wheels, in the rig and under any Bullet vehicle.
//
// The world's soil is an endless repetition of one packing (`period`) that was poured, relaxed and cut into bricks lx x ly and by the
// ground's height h(x, y):
//
//   grain g of tile (i, j) at (i lx + gx, j ly + gy, base + gz) is soil when   -depth <= base + gz - h <= lift        (S1)
//
// with lift such that the mean of the highest grain tops over squares as wide as the largest grain is h; one diameter below that is
// frozen. Only tiles nearer than `reach` to a wheel's contact are in the solver, on a torus of nx x ny tiles: tile (i, j) lies in slot
// (i mod nx, j mod ny). Grains nearer than one largest diameter to a tile that is not in the solver are frozen. A tile that the wheels
// leave is kept as it is and comes back when a wheel returns (ruts).
//
// With `slab` (quasi-2D) ny = 1, ly = slab, and tile i is its own neighbour across: periodic along y, no frozen seam there. A smooth
// wheel crosses it without ends; with f of the slab's grains the wheel of width b has
//   F = f b/slab,   T = (torque about the axle) b/slab                                                                   (S2a)
//
// With `sides: walls` the slab stands between two planes square to y, slab apart, about y = 0 of the world, of the soil's wall material
// (smooth unless it says otherwise); poured between them. S2a as before: the wheel touches from wall to wall.
//
// Wheel over the host's step dt, in n = ceil(dt/dt_r) equal steps, dt_r = step_share T_R (solver.h):
//   pose from begin to end at constant velocity and spin;  impulse = sum over the n steps of force times step, exact   (S2)
//
// Valid: wheels not wider than the torus, ground within `relief` of its datum. Not: soil deeper than `depth`, energy held by the soil
// (counted as dissipated), grains in flight over soil that is not in the solver (they land there, at rest).
// Cost: about 30 ns per grain in the solver and inner step; README, "Terrain dem.sphere".
// @throws TerrainError in step(): ground beyond the relief, two tiles for one slot, no grain left in store,
// a wheel that a slab cannot carry, whatever the solver refuses.
#include <array>

#include "grouser/terrain/registry.h"

namespace grouser::dem {

/// A dem.sphere terrain with `sides: walls`, asked what its soil does to them (dynamic_cast from Terrain).
class SlabWalls {
 public:
  virtual ~SlabWalls() = default;
  /// Soil on the walls at y = -slab/2 and y = slab/2 since the start, times wheel's over slab's width as all forces [N s].
  virtual std::array<Vec3, 2> wall_impulses() const = 0;
};

ModelInfo sphere_model();

}  // namespace grouser::dem
