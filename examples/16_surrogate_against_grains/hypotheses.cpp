// The published carrier (grouser/sdem/locomotion.h) over tables, as one row a run: forces and sinkage over the same window as the grains',
// and what the hypotheses about the sinkage need.   surrogate_hypotheses TABLES.h5 [SPIN_deg/s MASS_kg WIDTH_mm] >results/v1.csv
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "grouser/sdem/locomotion.h"

namespace {

using grouser::sdem::LocomotionCase;
using grouser::sdem::LocomotionRun;
using grouser::sdem::LocomotionSample;
using grouser::sdem::Tables;

double spin = 51 * 3.14159265358979323846 / 180, mass = 0.55, width = 0.03;  // [rad/s], [kg], [m], of flat.yaml
constexpr double kAmplitude = 9.75e-3, kWavenumber = 32.2;                   // [m], [rad/m], of sinusoid.yaml
constexpr double kRunIn = 0.05, kStart = 0.03;                               // [m]

struct Moments {
  double sum = 0, square = 0, n = 0;
  void add(double x) { sum += x, square += x * x, n += 1; }
  double mean() const { return sum / n; }
  double sd() const { return std::sqrt(std::max(0.0, square / n - mean() * mean())); }
};

/// As the rig's ground: zero until kStart, its amplitude reached kRunIn later.
double sinusoid(double s) {
  if (s <= kStart) return 0;
  const double u = std::min(1.0, (s - kStart) / kRunIn);
  return kAmplitude * u * u * (3 - 2 * u) * std::sin(kWavenumber * (s - kStart));
}

void row(const std::shared_ptr<const Tables>& t, const std::string& ground, double slip, double load, double band,
         bool gate) {
  LocomotionCase c;
  c.slip = slip;
  c.spin = spin;
  c.mass = mass;
  c.width = width;
  c.gravity = 9.81 * load;  // the mass stays, so the carrier's gain means the same
  c.slice.dead_band = band;
  c.slice.gate = gate;
  c.slice.floor = -t->bed_depth;
  c.distance = ground == "flat" ? 0.25 : 0.3;
  const double from = ground == "flat" ? 0.1 : 0.3 * (1 - 0.6505);
  if (ground != "flat") c.profile = sinusoid;
  for (const double v : t->vz)
    if (v < 0) c.probe_vz = v;  // the slowest downward node
  const LocomotionRun r = run_locomotion(t, c);
  const double down = -c.probe_vz;
  c.probe_vz = down;  // the same run once more, looking up
  const LocomotionRun again = run_locomotion(t, c);
  Moments drawbar, torque, depth, hub, ground_z, probe, up, steep;
  double shut = 0;
  const double weight = c.mass * c.gravity;
  for (const LocomotionSample& s : again.samples)
    if (s.s >= from) up.add(s.fz_probe / weight);
  for (const LocomotionSample& s : r.samples) {
    if (s.s < from) continue;
    drawbar.add(s.fx), torque.add(s.torque), depth.add(s.sinkage), hub.add(s.z), probe.add(s.fz_probe / weight);
    ground_z.add(c.profile(s.s)), steep.add(std::abs(s.vz / s.vx));
    shut += s.fz < weight;
  }
  const double v = (1 - slip) * t->radius * spin, v1 = down;
  std::printf("%s,%.3g,%.3g,%.3g,%d,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%lld,%.3g\n",
              ground.c_str(), slip, weight, band, gate, drawbar.mean(), drawbar.sd(), torque.mean(), torque.sd(),
              1e3 * depth.mean(), 1e3 * depth.sd(), 1e3 * r.samples.back().sinkage, 1e3 * hub.sd(), 1e3 * ground_z.sd(),
              probe.mean(), up.mean(), 2 * v1 / (v1 + band * v), steep.mean(), shut / probe.n,
              static_cast<long long>(r.outside), r.seconds);
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
    std::printf("# tables %s\n", t->hash_text().c_str());
    std::printf(
        "ground,slip_rim,load_N,band,gate,drawbar_N,drawbar_sd_N,torque_Nm,torque_sd_Nm,sinkage_mm,sinkage_sd_mm,"
        "sinkage_end_mm,hub_sd_mm,ground_sd_mm,down_over_weight,up_over_weight,down_expected,vz_over_vx,gate_shut,"
        "outside,"
        "processor_s\n");
    for (const char* ground : {"flat", "sinusoid"})
      for (const double slip : {-0.7, -0.5, -0.3, -0.15, 0.0, 0.15, 0.3, 0.5, 0.7}) {
        for (const double band : {0.05, 0.02, 0.01, 0.0}) row(t, ground, slip, 1, band, true);
        row(t, ground, slip, 1, 0.05, false);
      }
    for (const double load : {0.6, 1.4})
      for (const double slip : {-0.5, 0.0, 0.5}) row(t, "flat", slip, load, 0.05, true);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
