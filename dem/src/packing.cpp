#include "packing.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace grouser::dem {

std::vector<GrainState> scatter(const SoilSettings& soil, double lx, double ly, bool walls, double solid_volume) {
  if (!(lx > 2 * soil.largest && ly > 2 * soil.largest))
    throw DemError("the base of a packing must be wider than two of the largest grains");
  if (!(soil.smallest > 0 && soil.largest >= soil.smallest))
    throw DemError("grain diameters must be positive, smallest first");
  std::mt19937_64 g(soil.seed);
  // Own mapping to [0, 1): the library's distributions differ between implementations.
  const auto u = [&g] { return static_cast<double>(g() >> 11) * 0x1p-53; };
  std::vector<double> d;
  for (double v = 0; v < solid_volume;) {
    d.push_back(soil.smallest + (soil.largest - soil.smallest) * u());
    v += pi / 6 * d.back() * d.back() * d.back();
  }
  std::sort(d.rbegin(), d.rend());
  const double loose = 0.25, height = solid_volume / (loose * lx * ly);
  // Largest first, at random places that are still free; cells as wide as the largest grain.
  const double cell = soil.largest;
  const int nx = static_cast<int>(lx / cell), ny = static_cast<int>(ly / cell),
            nz = static_cast<int>(height / cell) + 2;
  std::vector<std::vector<int>> in(static_cast<std::size_t>(nx) * ny * nz);
  std::vector<GrainState> out;
  for (double diameter : d) {
    const double r = diameter / 2;
    for (int attempt = 0;; ++attempt) {
      if (attempt > 1000000) throw DemError("no room for another grain in the column");
      const Vec3 x(walls ? r + u() * (lx - 2 * r) : u() * lx, walls ? r + u() * (ly - 2 * r) : u() * ly,
                   r + u() * (height - 2 * r));
      const int c[3] = {std::min(nx - 1, static_cast<int>(x[0] / lx * nx)),
                        std::min(ny - 1, static_cast<int>(x[1] / ly * ny)), static_cast<int>(x[2] / cell)};
      bool free = true;
      for (int a = -1; a <= 1 && free; ++a)
        for (int b = -1; b <= 1 && free; ++b)
          for (int e = -1; e <= 1 && free; ++e) {
            const int z = c[2] + e;
            if (z < 0 || z >= nz) continue;
            const std::size_t at =
                (static_cast<std::size_t>((c[0] + a + nx) % nx) * ny + static_cast<std::size_t>((c[1] + b + ny) % ny)) *
                    nz +
                z;
            for (int o : in[at]) {
              const GrainState& other = out[static_cast<std::size_t>(o)];
              Vec3 s = x - other.x;
              if (!walls) s[0] -= lx * std::round(s[0] / lx), s[1] -= ly * std::round(s[1] / ly);
              if (s.norm() < r + other.radius) {
                free = false;
                break;
              }
            }
          }
      if (!free) continue;
      in[(static_cast<std::size_t>(c[0]) * ny + c[1]) * nz + c[2]].push_back(static_cast<int>(out.size()));
      GrainState s;
      s.x = x;
      s.radius = r;
      s.density = soil.density;
      out.push_back(s);
      break;
    }
  }
  return out;
}

double surface_height(const std::vector<GrainState>& grains, double lx, double ly, double square) {
  const int nx = std::max(1, static_cast<int>(lx / square)), ny = std::max(1, static_cast<int>(ly / square));
  std::vector<double> top(static_cast<std::size_t>(nx) * ny, 0);
  for (const GrainState& g : grains) {
    const double fx = g.x[0] / lx - std::floor(g.x[0] / lx), fy = g.x[1] / ly - std::floor(g.x[1] / ly);
    double& t = top[static_cast<std::size_t>(std::min(nx - 1, static_cast<int>(fx * nx))) * ny +
                    std::min(ny - 1, static_cast<int>(fy * ny))];
    t = std::max(t, g.x[2] + g.radius);
  }
  double sum = 0;
  for (double t : top) sum += t;
  return sum / static_cast<double>(top.size());
}

double total_mass(const std::vector<GrainState>& grains) {
  double m = 0;
  for (const GrainState& g : grains) m += 4.0 / 3 * pi * g.radius * g.radius * g.radius * g.density;
  return m;
}

double settle(Solver& solver, double slow, double limit, const Progress& progress) {
  const double begin = solver.time(), quantum = 0.02;
  double last = 1e30;
  while (solver.time() - begin < limit) {
    solver.step_for(quantum);
    double v2 = 0, m = 0;
    for (const GrainState& g : solver.grains()) {
      if (g.frozen) continue;
      const double w = g.radius * g.radius * g.radius;
      v2 += w * g.v.squaredNorm();
      m += w;
    }
    const double v = std::sqrt(v2 / m);
    if (progress) progress((solver.time() - begin) / limit, solver.time());
    // Twice in a row, so that the turn of a bounce is not taken for rest.
    if (v < slow && last < slow) break;
    last = v;
  }
  return solver.time() - begin;
}

Packing pour_periodic(const SoilSettings& soil, double lx, double ly, double height, const Progress& progress) {
  if (!(height > 0)) throw DemError("height of a packing must be positive");
  // Enough for a packing as dense as spheres of these sizes get by falling, then cut at the height.
  std::vector<GrainState> grains = scatter(soil, lx, ly, false, 0.62 * lx * ly * (height + soil.largest));
  double top = 0;
  for (const GrainState& g : grains) top = std::max(top, g.x[2] + g.radius);
  SolverSettings s;
  s.domain.lo = Vec3(0, 0, -0.01);
  s.domain.hi = Vec3(lx, ly, top + 0.05);
  s.materials = soil.materials;
  s.law = soil.law;
  s.dt = soil.dt;
  s.precision = soil.precision;
  Solver solver(s, grains);
  solver.add_floor();
  Packing p;
  p.settle_time = settle(solver, 2e-3, 1.5, progress);
  for (const GrainState& g : solver.grains())
    if (g.x[2] < height) p.grains.push_back(g);
  for (GrainState& g : p.grains) g.v = g.w = Vec3::Zero();
  p.height = surface_height(p.grains, lx, ly, soil.largest);
  p.bulk_density = total_mass(p.grains) / (lx * ly * p.height);
  for (GrainState& g : p.grains) g.density *= soil.bulk_density / p.bulk_density;
  p.bulk_density = soil.bulk_density;
  return p;
}

std::vector<GrainState> tile(const std::vector<GrainState>& grains, double lx, double ly, int nx, int ny) {
  std::vector<GrainState> out;
  for (int a = 0; a < nx; ++a)
    for (int b = 0; b < ny; ++b)
      for (GrainState g : grains) {
        g.x[0] += lx * (a - std::floor(g.x[0] / lx));
        g.x[1] += ly * (b - std::floor(g.x[1] / ly));
        out.push_back(g);
      }
  return out;
}

SoilSettings::SoilSettings() {
  materials.materials[0].name = "soil";
  materials.pairs[0].rolling = 6.75e8;
  law.rolling = RollingCoefficient::rate;
  Material wall;
  wall.name = "wall";
  PairProperties smooth;
  smooth.friction = smooth.rolling = 0;
  smooth.restitution = 0.06;
  materials.add(wall, smooth);
}

}  // namespace grouser::dem
