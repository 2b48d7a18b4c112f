#include <algorithm>
#include <cmath>

#include "packing.h"

namespace grouser::dem {

SinkageCurve pressure_sinkage(const SoilSettings& soil, const SinkageSettings& test, const Progress& progress) {
  if (!(test.rate > 0 && test.sinkage > 0 && test.depth > test.sinkage))
    throw DemError("pressure-sinkage: rate and sinkage must be positive, the soil deeper than the sinkage");
  if (test.samples < 1) throw DemError("pressure-sinkage: at least one sample");
  const int nx = static_cast<int>(std::lround(test.bin_x / test.brick)),
            ny = static_cast<int>(std::lround(test.bin_y / test.brick));
  if (std::fabs(nx * test.brick - test.bin_x) > 1e-9 || std::fabs(ny * test.brick - test.bin_y) > 1e-9)
    throw DemError("pressure-sinkage: the bin must be a whole number of bricks long and wide");
  const Packing brick = pour_periodic(soil, test.brick, test.brick, test.depth);
  const std::vector<GrainState> grains = tile(brick.grains, test.brick, test.brick, nx, ny);
  SolverSettings s;
  s.domain.lo = Vec3(0, 0, -0.01);
  s.domain.hi = Vec3(test.bin_x, test.bin_y, test.depth + 0.1);
  s.materials = soil.materials;
  s.law = soil.law;
  s.dt = soil.dt;
  s.precision = soil.precision;
  s.threads = test.threads;
  Solver solver(s, grains);
  solver.add_floor();
  settle(solver, 2e-3, 0.3, {});
  double top = 0;
  for (const GrainState& g : solver.grains()) {
    const bool under =
        std::fabs(g.x[0] - test.bin_x / 2) < test.plate_x / 2 && std::fabs(g.x[1] - test.bin_y / 2) < test.plate_y / 2;
    if (under) top = std::max(top, g.x[2] + g.radius);
  }
  BodySettings b;
  b.X_WB.p = Vec3(test.bin_x / 2, test.bin_y / 2, top + test.plate_z / 2 + 1e-6);
  b.V_W.v = Vec3(0, 0, -test.rate);
  const int plate = solver.add_body(b);
  solver.add_mesh(plate, box_mesh(Vec3(test.plate_x, test.plate_y, test.plate_z)), 1);
  SinkageCurve c;
  c.bulk_density = brick.bulk_density;
  c.grains = grains.size();
  const double area = test.plate_x * test.plate_y;
  // Sinkage counts from the surface of the packing, not from the highest grain.
  const double above = top - brick.height, whole = (test.sinkage + std::max(0.0, above)) / test.rate,
               sample = whole / test.samples;
  for (int k = 0; k < test.samples; ++k) {
    const double z = solver.body(plate).impulse[2], t = solver.time();
    solver.step_for(sample);
    c.pressure.push_back((solver.body(plate).impulse[2] - z) / (solver.time() - t) / area);
    c.sinkage.push_back((k + 0.5) * sample * test.rate - above);
    if (progress) progress(double(k + 1) / test.samples, solver.time());
  }
  c.counters = solver.counters();
  return c;
}

}  // namespace grouser::dem
