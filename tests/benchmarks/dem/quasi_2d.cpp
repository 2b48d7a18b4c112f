// Why a slab of grains between smooth walls wants a small restitution (Table 5.3): a cylinder is pressed into a slab
// between walls, and into slabs periodic across, by several laws of damping. One line of CSV per case.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "grouser/dem/packing.h"

using namespace grouser;
using namespace grouser::dem;

namespace {

constexpr double kLength = 0.16, kDepth = 0.05, kRadius = 0.025;
constexpr double kSpeed = 0.0125, kSinkage = 0.01, kSample = 2e-3;

struct Case {
  const char* across;  ///< walls or periodic
  double width, restitution;
  const char* law;  ///< implicit: this program's; explicit: LIGGGHTS' dampers and cap, and its step
  double dt;
};

void run(const Case& c, unsigned seed) {
  SoilSettings soil;  // Table 4.2
  soil.seed = seed;
  soil.dt = 8e-6;
  PourSettings p;
  p.lx = kLength;
  p.ly = c.width;
  p.height = kDepth;
  p.slab = c.across[0] == 'w';
  // One packing per seed and width: poured with the restitution of Table 4.2.
  const Packing bed = cached_packing(soil, p, "runs/quasi_2d/beds");
  SolverSettings s;
  s.materials = soil.materials;
  s.law = soil.law;
  s.materials.pair(0, 0).restitution = c.restitution;
  s.dt = c.dt;
  if (c.law[0] == 'e') {
    s.law.damping = Damping::explicit_;
    s.law.cap = Cap::springs;
  }
  const double beyond = p.slab ? 0.01 : 0;
  s.domain.lo = Vec3(0, -beyond, -0.01);
  s.domain.hi = Vec3(kLength, c.width + beyond, 0.3);
  s.domain.periodic = {true, !p.slab, false};
  Solver solver(s, bed.grains);
  solver.add_floor(0, 1);
  const int sides = solver.add_body({});
  int one = -1;
  if (p.slab) {
    one = solver.add_plane(sides, Vec3::Zero(), Vec3::UnitY(), 1);
    solver.add_plane(sides, Vec3(0, c.width, 0), -Vec3::UnitY(), 1);
  }
  solver.step_for(0.1);
  double top = 0;
  for (const GrainState& g : solver.grains())
    if (std::fabs(g.x[0] - kLength / 2) < kRadius) {
      const double x = g.x[0] - kLength / 2, reach = kRadius + g.radius;
      top = std::max(top, g.x[2] + std::sqrt(reach * reach - x * x));
    }
  BodySettings b;
  b.X_WB.p = Vec3(kLength / 2, c.width / 2, top + 1e-6);
  b.V_W.v = Vec3(0, 0, -kSpeed);
  const int wheel = solver.add_body(b);
  solver.add_cylinder(wheel, kRadius, 10.0, 0);
  double fastest = 0, fastest_deep = 0, kinetic = 0, most_kinetic = 0, sum = 0, sum2 = 0, mean_end = 0, wall = 0,
         most_wall = 0, touching = 0;
  int n = 0, bursts = 0, end = 0;
  double before = 0, wall_before = one < 0 ? 0 : std::fabs(solver.surface(one).impulse[1]);
  std::vector<double> force;
  try {
    for (double t = 0; t < kSinkage / kSpeed; t += kSample) {
      solver.step_for(kSample);
      const double z = solver.body(wheel).impulse[2], f = (z - before) / kSample;
      before = z;
      force.push_back(f);
      double away = 0;
      for (const GrainState& g : solver.grains()) {
        fastest = std::max(fastest, g.v.norm());
        // Beyond a radius of the cylinder from its surface; upwards: what falls through pores is no explosion.
        const Vec3 d = g.x - solver.pose(wheel).p;
        const double x = d[0] - kLength * std::round(d[0] / kLength);
        if (std::hypot(x, d[2]) > 2 * kRadius) away = std::max(away, g.v[2]);
      }
      fastest_deep = std::max(fastest_deep, away);
      bursts += away > 0.1;
      const double e = solver.kinetic_energy();
      kinetic += e;
      most_kinetic = std::max(most_kinetic, e);
      ++n;
      if (t > 0.8 * kSinkage / kSpeed) {
        mean_end += f;
        touching += 2 * solver.counters().touching;
        if (one >= 0) {
          const double y = std::fabs(solver.surface(one).impulse[1]);
          wall += (y - wall_before) / kSample / (kLength * kDepth);
          most_wall = std::max(most_wall, (y - wall_before) / kSample / (kLength * kDepth));
        }
        ++end;
      }
      if (one >= 0) wall_before = std::fabs(solver.surface(one).impulse[1]);
    }
    // Noise: what a straight line over 50 ms does not follow, share of the mean of the last half.
    constexpr std::size_t w = 25;
    double mean = 0;
    for (std::size_t k = force.size() / 2; k + w <= force.size(); k += w) {
      double m = 0, slope = 0, xx = 0;
      for (std::size_t j = 0; j < w; ++j) m += force[k + j] / w;
      for (std::size_t j = 0; j < w; ++j) {
        const double x = static_cast<double>(j) - (w - 1) / 2.0;
        slope += x * force[k + j];
        xx += x * x;
      }
      slope /= xx;
      for (std::size_t j = 0; j < w; ++j) {
        const double r = force[k + j] - m - slope * (static_cast<double>(j) - (w - 1) / 2.0);
        sum2 += r * r;
        sum += 1;
      }
      mean += m * w;
    }
    fmt::print("{},{:g},{:g},{},{:g},{},{},{:.4g},{:.4g},{:.4g},{:.4g},{},{:.4g},{:.4g},{:.4g},{:.4g},{:.4g},\n",
               c.across, 1e3 * c.width, c.restitution, c.law, 1e6 * c.dt, seed, bed.grains.size(),
               bed.grains[0].density, mean_end / end / c.width, std::sqrt(sum2 / sum) / (mean / sum), fastest_deep,
               bursts, fastest, 1e6 * kinetic / n, 1e6 * most_kinetic, touching / end, wall / std::max(1, end));
  } catch (const DemError& e) {
    fmt::print("{},{:g},{:g},{},{:g},{},{},,,,,,,,,,,\"{}\"\n", c.across, 1e3 * c.width, c.restitution, c.law,
               1e6 * c.dt, seed, bed.grains.size(), e.what());
  }
  std::fflush(stdout);
}

}  // namespace

/// quasi_2d FIRST_SEED LAST_SEED [implicit | explicit]
int main(int argc, char** argv) {
  const int first = argc > 1 ? std::atoi(argv[1]) : 1, last = argc > 2 ? std::atoi(argv[2]) : 1;
  const bool peers = argc > 3 && argv[3][0] == 'e';
  fmt::print(
      "across,width_mm,restitution,law,dt_us,seed,grains,density_kg_m3,force_N_per_m,force_noise,fastest_up_away_m_s,"
      "bursts,fastest_m_s,kinetic_uJ,kinetic_most_uJ,contacts_per_grain,wall_Pa,stopped\n");
  for (int seed = first; seed <= last; ++seed)
    for (const double e : {0.06, 0.4, 0.9})
      for (const Case& c : {Case{"walls", 0.03, e, "implicit", 8e-6}, Case{"periodic", 0.03, e, "implicit", 8e-6},
                            Case{"periodic", 0.06, e, "implicit", 8e-6}, Case{"walls", 0.03, e, "explicit", 2.2e-6},
                            Case{"periodic", 0.03, e, "explicit", 2.2e-6}})
        if (peers == (c.law[0] == 'e')) run(c, static_cast<unsigned>(seed));
}
