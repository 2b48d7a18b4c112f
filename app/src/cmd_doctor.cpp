// grouser doctor: this build, this machine, and a quarter of a second of every terrain model.
#include <LinearMath/btScalar.h>
#include <fmt/core.h>
#include <sundials/sundials_config.h>
#include <unistd.h>

#include <Eigen/Core>
#include <chrono>
#include <thread>

#include "commands.h"
#include "grouser/models.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

struct Check {
  bool good = true;
  void line(bool ok, const std::string& what, const std::string& found) {
    fmt::print("{}  {:<28} {}\n", ok ? "ok  " : "BAD ", what, found);
    good = good && ok;
  }
};

/// Microseconds per wheel and step of a model: a wheel pressed 5 mm into the soil that rolls at 10 % slip.
double cost_us(Terrain& terrain, const RunningGear& gear) {
  terrain.add_body({"wheel", gear, {}});
  const double v = 0.2, w = v / (0.9 * gear.radius()), dt = 1e-3;
  BodyMotion m;
  m.X_WB_begin.p = {0, 0, gear.radius() - 0.005};
  m.V_WB_end = {{v, 0, 0}, {0, w, 0}};
  BodyResult r;
  const auto begin = std::chrono::steady_clock::now();
  constexpr int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    m.X_WB_end = m.X_WB_begin;
    m.X_WB_end.p.x() += v * dt;
    terrain.step(i * dt, dt, std::span(&m, 1), std::span(&r, 1));
    m.X_WB_begin = m.X_WB_end;
  }
  const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - begin;
  return spent.count() / steps;
}

void check_results_file(Check& c) {
  const fs::path file = fs::temp_directory_path() / fmt::format("grouser-doctor-{}.h5", static_cast<long>(getpid()));
  try {
    {
      Recorder r = Recorder::create(file, {"run", "", "doctor", "none", GROUSER_VERSION, 0});
      const int x = r.add_channel({"x", "m", "probe", "W", 1});
      for (int i = 0; i < 10; ++i) {
        r.set(x, i);
        r.end_frame(i);
      }
    }
    const bool same = RunFile(file).read("x").back() == 9;
    c.line(same, "HDF5 write and read", same ? "10 frames" : "values differ");
  } catch (const std::exception& e) {
    c.line(false, "HDF5 write and read", e.what());
  }
  std::error_code ignored;
  fs::remove(file, ignored);
}

}  // namespace

int doctor() {
  Check c;
  fmt::print("grouser {}, {} {}, {} threads\n", GROUSER_VERSION,
#ifdef __clang__
             "clang", __clang_version__,
#else
             "g++", __VERSION__,
#endif
             std::thread::hardware_concurrency());
  c.line(sizeof(btScalar) == 8, "Bullet, double precision", fmt::format("{}", btGetVersion()));
  c.line(true, "Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION));
  c.line(true, "SUNDIALS", SUNDIALS_VERSION);
  check_results_file(c);
  try {
    const fs::path library = library_folder();
    c.line(true, "library", library.string());
    const Soil soil = load_soil_file(library / "soils" / "mojave_martian_simulant.yaml");
    const RunningGear gear = load_running_gear_file(library / "wheels" / "mit_wheel.yaml");
    for (const ModelInfo& m : all_models().models()) {
      if (m.id == "dem.sphere" && !soil.dem.present()) {  // pouring a bed takes longer than a person waits here
        c.line(true, m.id, fmt::format("not tried: soil '{}' has no grains", soil.name));
        continue;
      }
      if (m.id == "sdem.v1" || m.id == "sdem.v2") {
        c.line(true, m.id,
               m.id == "sdem.v1" ? "not tried: it needs tables (grouser sdem build)"
                                 : "not tried: it needs a law (grouser sdem fit)");
        continue;
      }
      const auto terrain = m.make({soil, flat_ground(), {}, 9.81});
      c.line(true, m.id, fmt::format("{:.1f} us per wheel and step", cost_us(*terrain, gear)));
    }
  } catch (const std::exception& e) {
    c.line(false, "library or models", e.what());
  }
  fmt::print("{}\n", c.good ? "all well" : "something is wrong, see BAD above");
  return c.good ? 0 : 1;
}

}  // namespace grouser::app
