// CPU time per wheel and step of every registered model, on flat and on rough ground, at rest and rolling.
#include <cstdio>
#include <ctime>
#include <vector>

#include "grouser/models.h"
#include "helpers.h"

namespace {
double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
}  // namespace

int main() {
  using namespace grouser;
  Soil soil;
  soil.bekker = test::mojave();
  const GroundPtr flat = flat_ground();
  const GroundPtr rough = test::ground_of([](double x, double) { return 0.01 * (x - std::floor(x)); }, 1e-3);
  for (const ModelInfo& model : all_models().models()) {
    if (model.id == "sdem.v1" || model.id == "sdem.v2") continue;  // need files made from grains
    for (const auto& [name, ground] : {std::pair{"flat", flat}, std::pair{"rough", rough}})
      for (const double vx : {0.0, 0.3}) {
        auto terrain = model.make({soil, ground, {}, 9.81});
        for (int i = 0; i < 4; ++i) terrain->add_body({"wheel", test::mit_wheel(), {}});
        std::vector<BodyMotion> motions(4);
        std::vector<BodyResult> results(4);
        const int n = 20000;
        const double dt = 1e-3, start = cpu_seconds();
        for (int k = 0; k < n; ++k) {
          for (BodyMotion& m : motions) {
            m.X_WB_end.p = Vec3(vx * k * dt, 0, 0.125);
            m.V_WB_end = {{vx, 0.02 * vx, 0}, {0, vx / 0.13 / 0.9, 0}};
          }
          terrain->step(k * dt, dt, motions, results);
        }
        std::printf("%-14s %-5s v %.1f m/s: %7.0f ns per wheel and step\n", model.id.c_str(), name, vx,
                    (cpu_seconds() - start) / n / 4 * 1e9);
      }
  }
}
