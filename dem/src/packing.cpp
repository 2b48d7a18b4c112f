#include "packing.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace grouser::dem {

std::vector<GrainState> scatter(const SoilSettings& soil, const PourSettings& p, double solid_volume) {
  const double lx = p.lx, ly = p.ly;
  const bool wall_x = p.walls, wall_y = p.walls || p.slab;
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
      const Vec3 x(wall_x ? r + u() * (lx - 2 * r) : u() * lx, wall_y ? r + u() * (ly - 2 * r) : u() * ly,
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
              if (!wall_x) s[0] -= lx * std::round(s[0] / lx);
              if (!wall_y) s[1] -= ly * std::round(s[1] / ly);
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

double rms_speed(const std::vector<GrainState>& grains) {
  double v2 = 0, m = 0;
  for (const GrainState& g : grains) {
    if (g.frozen) continue;
    const double w = g.radius * g.radius * g.radius * g.density;
    v2 += w * g.v.squaredNorm();
    m += w;
  }
  return m > 0 ? std::sqrt(v2 / m) : 0;
}

bool Settling::step(Solver& solver) {
  const double before = solver.time();
  solver.step_for(0.02);
  spent_ += solver.time() - before;
  const double v = rms_speed(solver.grains());
  const bool rest = v < slow_ && last_ < slow_;
  last_ = v;
  return !rest && spent_ < limit_;
}

void Settling::traverse(State& s) {
  const auto g = s.group("settling");
  s.field("spent", spent_);
  s.field("speed", last_);
}

void set_step(SoilSettings& soil) {
  if (soil.dt_share > 0)
    soil.dt = soil.dt_share * rayleigh_time(soil.materials.materials[0], soil.smallest / 2, soil.density);
}

SolverSettings solver_settings(const SoilSettings& soil) {
  SolverSettings s;
  s.materials = soil.materials;
  s.law = soil.law;
  s.dt = soil.dt;
  s.precision = soil.precision;
  return s;
}

void add_container(Solver& solver, const PourSettings& p) {
  solver.add_floor(0, 1);
  if (!p.walls && !p.slab) return;
  const int walls = solver.add_body({});
  if (p.walls) {
    solver.add_plane(walls, Vec3::Zero(), Vec3::UnitX(), 1);
    solver.add_plane(walls, Vec3(p.lx, 0, 0), -Vec3::UnitX(), 1);
  }
  solver.add_plane(walls, Vec3::Zero(), Vec3::UnitY(), 1);
  solver.add_plane(walls, Vec3(0, p.ly, 0), -Vec3::UnitY(), 1);
}

void set_domain(SolverSettings& s, const PourSettings& p, double top) {
  const bool wall_x = p.walls, wall_y = p.walls || p.slab;
  const double beyond_x = wall_x ? 0.01 : 0, beyond_y = wall_y ? 0.01 : 0;
  s.domain.lo = Vec3(-beyond_x, -beyond_y, -0.01);
  s.domain.hi = Vec3(p.lx + beyond_x, p.ly + beyond_y, top + 0.05);
  s.domain.periodic = {!wall_x, !wall_y, false};
}

Packing pour_periodic(const SoilSettings& soil, double lx, double ly, double height, const Progress& progress) {
  PourSettings p;
  p.lx = lx;
  p.ly = ly;
  p.height = height;
  return pour(soil, p, progress);
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

Packing tile(const Packing& brick, int nx, int ny) {
  if (brick.walls) throw DemError("a packing poured into a box cannot be repeated");
  if (brick.slab && ny > 1) throw DemError("a packing poured between walls square to y cannot be repeated along y");
  Packing p = brick;
  p.grains = tile(brick.grains, brick.lx, brick.ly, nx, ny);
  p.lx = nx * brick.lx;
  p.ly = ny * brick.ly;
  return p;
}

void cut_surface(Packing& p, const std::function<double(double, double)>& height) {
  std::erase_if(p.grains, [&](const GrainState& g) {
    const double x = p.walls ? g.x[0] : g.x[0] - p.lx * std::floor(g.x[0] / p.lx),
                 y = p.walls || p.slab ? g.x[1] : g.x[1] - p.ly * std::floor(g.x[1] / p.ly);
    return g.x[2] > height(x, y);
  });
  if (p.grains.empty()) throw DemError("no grain is left below the surface asked for");
  double widest = 0;
  for (const GrainState& g : p.grains) widest = std::max(widest, 2 * g.radius);
  p.height = surface_height(p.grains, p.lx, p.ly, widest);
  p.bulk_density = total_mass(p.grains) / (p.lx * p.ly * p.height);
}

void freeze_edges(Packing& p, double border, double bottom) {
  for (GrainState& g : p.grains)
    g.frozen =
        g.x[2] < bottom || g.x[0] < border || g.x[0] >= p.lx - border || g.x[1] < border || g.x[1] >= p.ly - border;
}

void relax(Packing& p, const SoilSettings& soil, double limit, const Progress& progress) {
  SolverSettings s = solver_settings(soil);
  double top = 0;
  for (const GrainState& g : p.grains) top = std::max(top, g.x[2] + g.radius);
  PourSettings box;
  box.lx = p.lx;
  box.ly = p.ly;
  box.walls = p.walls;
  box.slab = p.slab;
  set_domain(s, box, top);
  Solver solver(s, p.grains);
  add_container(solver, box);
  Settling settling(2e-3, limit);
  while (settling.step(solver))
    if (progress) progress(settling.spent() / limit, solver.time());
  p.grains = solver.grains();
  p.residual_speed = settling.speed();
  for (GrainState& g : p.grains) g.v = g.w = Vec3::Zero();
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
