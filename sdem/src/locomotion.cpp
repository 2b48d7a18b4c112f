#include "grouser/sdem/locomotion.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <stdexcept>
#include <string>

#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

namespace {

std::string lost(double s, double hub, double lowest) {
  char text[240];
  std::snprintf(
      text, sizeof text,
      "the wheel sinks out of the tables after %.4g m: its hub is %.4g m above the floor of the soil, and the "
      "tables begin at %.4g m",
      s, hub, lowest);
  return text;
}

}  // namespace

LocomotionRun run_locomotion(std::shared_ptr<const Tables> tables, const LocomotionCase& c) {
  if (!(c.slip < 1) || !(c.mass > 0) || !(c.width > 0) || !(c.time_step > 0) || !(c.distance > 0) || !(c.spin > 0))
    throw std::invalid_argument(
        "locomotion: slip below 1 and positive spin, mass, width, step and distance are wanted");
  const double r = tables->radius, v = (1 - c.slip) * r * c.spin, h = c.time_step, weight = c.mass * c.gravity;
  Slice slice(tables, c.slice);
  WheelState x{0, c.profile(0) + r + c.start, v, 0, c.spin};
  slice.lay(x.s, c.profile);
  const std::clock_t begin = std::clock();
  LocomotionRun run;
  std::vector<LocomotionSample>& out = run.samples;
  const auto steps = static_cast<std::size_t>(std::ceil(c.distance / v / h));
  out.reserve(steps);
  const double lowest = tables->part(Part::wheel_bottom).u.first;
  double behind = 0;  // integral of the velocity's error [m]
  for (std::size_t i = 0; i < steps; ++i) {
    const double floor = c.slice.floor + (c.local_height ? c.profile(x.s) : 0);
    slice.set_floor(floor);
    if (const double hub = x.z - floor; !(hub >= lowest)) throw TerrainError(lost(x.s, hub, lowest));
    const SliceForce f = slice.force(x, c.width);
    out.push_back({static_cast<double>(i) * h, x.s, x.z, x.vx, x.vz, f.fx, f.fz, f.torque, c.profile(x.s) - (x.z - r)});
    if (c.probe_vz != 0) {
      WheelState probe = x;
      probe.vz = c.probe_vz;
      out.back().fz_probe = slice.force(probe, c.width).fz;
    }
    if (c.watch) c.watch(out.back(), slice);
    behind += (v - x.vx) * h;
    x.vx += (f.fx + c.gain * behind) / c.mass * h;
    x.vz += (f.fz - weight) / c.mass * h;
    if (c.round_wheel && f.contacts > 0) x.vz = slice.rounded(x.vz, x.vx);
    x.s += x.vx * h;
    x.z += x.vz * h;
    slice.lay(x.s, c.profile);
    slice.move(x, h, f.fz, weight);
  }
  run.outside = slice.outside();
  run.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return run;
}

}  // namespace grouser::sdem
