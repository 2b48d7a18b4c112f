// run_program run <scenario> <out> <terrain> <threads> <duration> | resume <out> <threads>: a process of its own, to be
// killed.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "grouser/models.h"
#include "grouser/vehicle/simulation.h"

int main(int argc, char** argv) try {
  using namespace grouser;
  const std::string what = argc > 1 ? argv[1] : "";
  vehicle::RunSummary s;
  if (what == "run" && argc == 7) {
    vehicle::RunOptions o;
    o.out = argv[3];
    o.terrain = argv[4];
    o.threads = std::atoi(argv[5]);
    if (std::atof(argv[6]) > 0) o.duration = std::atof(argv[6]);
    s = vehicle::run_scenario(argv[2], all_models(), o);
  } else if (what == "resume" && argc == 4) {
    s = vehicle::resume_run(argv[2], all_models(), std::atoi(argv[3]));
  } else {
    std::fprintf(stderr,
                 "usage: run_program run <scenario> <out> <terrain> <threads> <duration, 0 = the scenario's> | resume "
                 "<out> <threads>\n");
    return 2;
  }
  std::printf(
      "hash %s simulated %.3f s wall %.3f s bullet %.3f terrain %.3f output %.3f real-time %.1f residual %.3g drift "
      "%.3g mm mass %.3f kg\n",
      s.end_state_hash.c_str(), s.simulated_s, s.wall_s, s.bullet_s, s.terrain_s, s.output_s, s.simulated_s / s.wall_s,
      s.energy_residual_ratio, 1e3 * s.joint_drift_m, s.total_mass);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
