// The published carrier (grouser/sdem/locomotion.h) over tables, one row a run: forces and sinkage over the same share of the way as the
// grains', and what the hypotheses about the sinkage need.   surrogate_hypotheses TABLES.h5 [SPIN_deg/s MASS_kg WIDTH_mm] >results/v1.csv
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>

#include "grouser/sdem/locomotion.h"
#include "grouser/terrain/terrain.h"
#include "track.h"

namespace {

using grouser::TerrainError;
using grouser::sdem::Grid;
using grouser::sdem::LocomotionCase;
using grouser::sdem::LocomotionRun;
using grouser::sdem::LocomotionSample;
using grouser::sdem::Part;
using grouser::sdem::Slice;
using grouser::sdem::Tables;
using TablesPtr = std::shared_ptr<const Tables>;

// Velocities are three times the published ones and so is the step: what a step may round away, m dead_band vx/dt, and the damping of the
// ramp times dt/m then are the published ones.
constexpr double kTimeStep = 3 * 7e-4;                                             // [s]
double spin = 51 * 3.14159265358979323846 / 180, mass = 5.4 / 9.81, width = 0.03;  // [rad/s], [kg], [m], as the grains

/// Tables as they are and changed in one thing, by name.
std::map<std::string, TablesPtr> changed(const TablesPtr& t) {
  std::map<std::string, TablesPtr> out{{"", t}};
  const std::size_t down = [&] {
    std::size_t k = 0;
    while (k + 1 < t->vz.size() && t->vz[k + 1] < 0) ++k;
    return k;
  }();
  const auto blank = [](Grid& g) {
    for (std::size_t k = 0; k < g.x.size(); ++k)
      if (g.known[k] == 0.0F) g.x[k] = g.z[k] = 0;
  };
  Tables step = *t, pressure = *t, soil = *t, still = *t;
  // No ramp: at and above no vertical velocity the soil bears what it bears at the slowest downward node.
  for (const Part part : {Part::wheel_bottom, Part::wheel_top}) {
    Grid& g = step.part(part);
    for (std::size_t w = 0; w < t->w.size(); ++w)
      for (std::size_t x = 0; x < t->vx.size(); ++x)
        for (std::size_t k = 0; k < g.plane(); ++k) {
          const std::size_t from = t->node(w, x, down) * g.plane() + k, to = t->node(w, x, down + 1) * g.plane() + k;
          g.x[to] = g.x[from];
          g.z[to] = g.z[from];
        }
    blank(pressure.part(part));
  }
  for (const Part part : {Part::soil_bottom, Part::soil_top, Part::soil_left, Part::soil_right}) {
    blank(soil.part(part));
    still.part(part).x.assign(still.part(part).x.size(), 0.0F);
    still.part(part).z = still.part(part).x;
  }
  for (const auto& [name, tables] :
       {std::pair{"no_ramp", &step}, {"known_pressure", &pressure}, {"known_soil", &soil}, {"still_soil", &still}})
    out[name] = std::make_shared<const Tables>(*tables);
  return out;
}

/// Share of the cells that the pressures of this state come from which runs gave.
double known_share(const Tables& t, const Slice& slice, double s, double z, double vx) {
  const Grid& g = t.part(Part::wheel_bottom);
  const auto below = [](double x, double first, double step, int count) {
    return std::clamp(static_cast<int>((x - first) / step), 0, count - 2);
  };
  std::size_t ix = 0, iz = 0;
  while (ix + 2 < t.vx.size() && t.vx[ix + 1] < vx) ++ix;
  while (iz + 2 < t.vz.size() && t.vz[iz + 1] < 0) ++iz;
  double known = 0, n = 0;
  for (std::size_t i = 0; i < slice.size(); ++i) {
    const double dx = slice.s_of(i) - s, dz = slice.z_of(i) - z;
    if (dz > 0 || std::hypot(dx, dz) >= t.radius) continue;
    const int a = below(z - slice.settings().floor, g.u.first, g.u.step(), g.u.count),
              b = below(std::atan2(dx, -dz), g.v.first, g.v.step(), g.v.count);
    for (int corner = 0; corner < 16; ++corner, ++n)
      known += static_cast<double>(g.known[g.index(
          t.node(0, ix + static_cast<std::size_t>(corner & 1), iz + static_cast<std::size_t>(corner >> 1 & 1)),
          a + (corner >> 2 & 1), b + (corner >> 3))]);
  }
  return n > 0 ? known / n : std::nan("");
}

struct Variant {
  const char* name;
  double band = 0.05;
  bool gate = true;
  const char* tables = "";
  double floor = 0;  // [m] added to its height
  bool local = false;
  double step = kTimeStep;  // [s]
};

void row(const std::map<std::string, TablesPtr>& all, bool rough, double slip, double load, const Variant& how) {
  const TablesPtr& t = all.at(how.tables);
  LocomotionCase c;
  c.slip = slip;
  c.spin = spin;
  c.mass = mass;
  c.width = width;
  c.time_step = how.step;
  c.gravity = 9.81 * load;  // the mass stays, so the carrier's gain means the same
  c.slice.dead_band = how.band;
  c.slice.gate = how.gate;
  c.slice.floor = how.floor - t->bed_depth;
  c.local_height = how.local;
  c.distance = rough ? track::kRough : track::kFlat;
  if (rough) c.profile = track::sinusoid;
  double v1 = 0;
  for (const double v : t->vz)
    if (v < 0) v1 = -v;  // the slowest downward node
  const double weight = c.mass * c.gravity, from = track::kFrom * c.distance, v = (1 - slip) * t->radius * spin;
  std::printf("%s,%.3g,%.3g,%s,", rough ? "sinusoid" : "flat", slip, weight, how.name);
  track::Moments ahead, behind, known, up;
  const auto watch = [&](const LocomotionSample& s, const Slice& slice) {
    if (s.s < from || static_cast<long>(s.t / c.time_step) % 50 != 0) return;
    for (double d = track::kAheadFrom; d <= track::kAheadTo; d += track::kColumn) {
      ahead.add(slice.height(s.s + d) - c.profile(s.s + d));
      behind.add(slice.height(s.s - d - track::kBehind) - c.profile(s.s - d - track::kBehind));
    }
    known.add(known_share(*t, slice, s.s, s.z, s.vx));
  };
  try {
    c.probe_vz = v1;
    for (const LocomotionSample& s : run_locomotion(t, c).samples)
      if (s.s >= from) up.add(s.fz_probe / weight);
    c.probe_vz = -v1;  // the same run once more, looking down
    c.watch = watch;
    const LocomotionRun r = run_locomotion(t, c);
    track::Moments drawbar, torque, depth, hub, ground, down, steep;
    double shut = 0;
    for (const LocomotionSample& s : r.samples) {
      if (s.s < from) continue;
      drawbar.add(s.fx), torque.add(s.torque), depth.add(s.sinkage), hub.add(s.z), down.add(s.fz_probe / weight);
      ground.add(c.profile(s.s)), steep.add(std::abs(s.vz / s.vx));
      shut += s.fz < weight;
    }
    std::printf("%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%lld,%.3g,\n",
                drawbar.mean(), drawbar.sd(), torque.mean(), torque.sd(), 1e3 * depth.mean(), 1e3 * depth.sd(),
                1e3 * r.samples.back().sinkage, 1e3 * hub.sd(), 1e3 * ground.sd(), 1e3 * ahead.mean(),
                1e3 * behind.mean(), down.mean(), up.mean(), 2 * v1 / (v1 + how.band * v), steep.mean(), shut / down.n,
                known.mean(), static_cast<long long>(r.outside), r.seconds);
  } catch (const TerrainError& e) {
    std::printf(",,,,,,,,,,,,,,,,,,,\"%s\"\n", e.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 5) {
    std::fprintf(stderr, "usage: surrogate_hypotheses TABLES.h5 [SPIN_deg/s MASS_kg WIDTH_mm]\n");
    return 2;
  }
  if (argc == 5) {
    spin = std::atof(argv[2]) * 3.14159265358979323846 / 180;
    mass = std::atof(argv[3]);
    width = 1e-3 * std::atof(argv[4]);
  }
  try {
    const auto t = std::make_shared<const Tables>(Tables::read(argv[1]));
    const auto all = changed(t);
    std::printf("# tables %s\n", t->hash_text().c_str());
    std::printf(
        "ground,slip_rim,load_N,variant,drawbar_N,drawbar_sd_N,torque_Nm,torque_sd_Nm,sinkage_mm,sinkage_sd_mm,"
        "sinkage_end_mm,hub_sd_mm,ground_sd_mm,ahead_mm,behind_mm,down_over_weight,up_over_weight,down_expected,"
        "vz_over_vx,gate_shut,known,outside,processor_s,stopped\n");
    for (const bool rough : {false, true})
      for (const double slip : {-0.7, -0.5, -0.3, -0.15, 0.0, 0.15, 0.3, 0.5, 0.7}) {
        for (const Variant& v :
             {Variant{"published"}, Variant{"band_2", 0.02}, Variant{"band_1", 0.01}, Variant{"band_0", 0},
              Variant{"no_gate", 0.05, false}, Variant{"no_ramp", 0.05, true, "no_ramp"},
              Variant{"known_pressure", 0.05, true, "known_pressure"}, Variant{"known_soil", 0.05, true, "known_soil"},
              Variant{"still_soil", 0.05, true, "still_soil"}, Variant{"floor_2mm_up", 0.05, true, "", 2e-3},
              Variant{"floor_2mm_down", 0.05, true, "", -2e-3},
              Variant{"published_step", 0.05, true, "", 0, false, 7e-4}})
          row(all, rough, slip, 1, v);
        if (rough) row(all, rough, slip, 1, {"local_height", 0.05, true, "", 0, true});
      }
    for (const double load : {0.6, 1.4})
      for (const double slip : {-0.5, 0.0, 0.5}) row(all, false, slip, load, {"published"});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
