// Particle-steps per second on a settled bed: processor time on one thread, wall clock on several, least of repeats.
// bench_dem_speed BED.csv.gz LX LY [tiles_x tiles_y] [key=value ..]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "bed_file.h"

using namespace grouser;

/// Processor time of all threads [s]: what other programs take away does not count, what they slow down does.
static double processor_time() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr,
                 "bench_dem_speed BED.csv.gz LX LY [tiles_x tiles_y] [dt=] [steps=] [warm=] [repeat=] [threads=] "
                 "[isa=] [skin=] [full=1] [rate=1]\n");
    return 2;
  }
  const double lx = std::atof(argv[2]), ly = std::atof(argv[3]);
  int tx = 1, ty = 1, at = 4;
  if (argc > 5 && !std::strchr(argv[4], '=')) tx = std::atoi(argv[4]), ty = std::atoi(argv[5]), at = 6;
  double dt = 2.2e-6;
  long steps = 2000, warm = 20000;
  int repeat = 5, threads = 1;
  bool full = false, rate = false, spread = false;
  std::string isa;
  dem::LawSettings law;
  dem::SolverSettings s;
  for (; at < argc; ++at) {
    const std::string a = argv[at], key = a.substr(0, a.find('=')), v = a.substr(a.find('=') + 1);
    if (key == "dt") dt = std::atof(v.c_str());
    if (key == "steps") steps = std::atol(v.c_str());
    if (key == "warm") warm = std::atol(v.c_str());
    if (key == "repeat") repeat = std::atoi(v.c_str());
    if (key == "threads") threads = std::atoi(v.c_str());
    if (key == "isa") isa = v;
    if (key == "skin") s.skin = std::atof(v.c_str());
    if (key == "full") full = v == "1";
    if (key == "rate") rate = v == "1";
    if (key == "cap" && v == "springs") law.cap = dem::Cap::springs;
    if (key == "explicit") law.damping = dem::Damping::explicit_;
    if (key == "print") spread = v == "1";
  }
  auto grains = read_bed(argv[1], lx, ly, tx, ty);
  s.domain.hi = Vec3(lx * tx, ly * ty, 0.4);
  s.dt = dt;
  s.threads = threads;
  s.isa = isa;
  s.precision = full ? dem::Precision::full : dem::Precision::single;
  if (rate) {
    law.rolling = dem::RollingCoefficient::rate;
    s.materials.pairs[0].rolling = 6.75e8;
  }
  s.law = law;
  try {
    dem::Solver solver(s, std::move(grains));
    solver.add_floor();
    if (warm > 0) {
      solver.set_drag(50);
      solver.step(warm / 2);
      solver.set_drag(0);
      solver.step(warm / 2);
    }
    double best = 1e30, lists = 0;
    for (int k = 0; k < repeat; ++k) {
      const double before = solver.counters().seconds_lists;
      const auto t0 = std::chrono::steady_clock::now();
      const double c0 = processor_time();
      solver.step(steps);
      const double t = threads > 1 ? std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count()
                                   : processor_time() - c0;
      if (t < best) best = t, lists = (solver.counters().seconds_lists - before) / t;
      if (spread)
        std::printf("%d: %.3f s, kinetic energy %.3e J, weight on floor %.4f N\n", k, t, solver.kinetic_energy(),
                    -solver.body(0).force[2]);
    }
    const dem::Counters c = solver.counters();
    std::printf(
        "%s %zu grains, dt %.2g s, %d thread(s): %.1f M particle-steps/s (%.2f ns), %.2f touching, %.2f listed, %.2f "
        "candidates per grain, "
        "lists %.1f %% of time, %llu refreshes, %llu rebuilds in %llu steps, %.0f bytes per grain, kinetic energy %.2e "
        "J, stable step %.2e s\n",
        solver.isa(), c.grains, dt, threads, static_cast<double>(c.grains) * static_cast<double>(steps) / best / 1e6,
        best / static_cast<double>(c.grains) / static_cast<double>(steps) * 1e9, c.touching,
        static_cast<double>(c.listed) / static_cast<double>(c.grains),
        static_cast<double>(c.candidates) / static_cast<double>(c.grains), 100 * lists,
        static_cast<unsigned long long>(c.refreshes), static_cast<unsigned long long>(c.rebuilds),
        static_cast<unsigned long long>(c.steps), static_cast<double>(c.bytes) / static_cast<double>(c.grains),
        solver.kinetic_energy(), solver.stable_step());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
