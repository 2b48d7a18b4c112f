// How many times faster than real time sdem.v2 is, for one wheel on one core with everything counted: Terrain::step with pose, report,
// linearisation, ledger and rut. Host steps of 1 ms and 1/240 s, flat and sinusoid, with the fluctuation of grains. Processor time, best of five.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <numbers>

#include "grouser/sdem/v2.h"
#include "grouser/terrain/loaders.h"

namespace {

using namespace grouser;

struct Sinusoid : Ground {
  double height(double x, double) const override { return 9.75e-3 * std::sin(32.2 * x); }
  double resolution() const override { return 5e-3; }
  std::string describe() const override { return "sinusoid"; }
};

constexpr double kRadius = 0.065, kWidth = 0.03, kLoad = 5.4, kSpeed = 0.05, kSeconds = 20;

double measure(const GroundPtr& ground, double dt) {
  const auto folder = std::filesystem::path(GROUSER_SOURCE_DIR) / "examples";
  const Soil soil = load_soil_file(folder / "15_quasi_2d/soil_constant.yaml");
  const auto given = ConfigDocument::from_text(
      "options: {law: " + (folder / "17_surrogate_by_direction/law.h5").string() + "}", "options");
  const auto terrain = sdem::v2_model().make({soil, ground, given.root().map("options"), 9.81});
  given.check();
  terrain->add_body({"wheel", {"wheel", SmoothCylinder{kRadius, kWidth}}, {}});
  double x = 0, z = ground->height(0, 0) + kRadius + 5e-3, vz = 0, turn = 0, force = 0, stiff = 0;
  const double m = kLoad / 9.81, spin = 1.25 * kSpeed / kRadius;
  const int n = static_cast<int>(kSeconds / dt);
  const std::clock_t begin = std::clock();
  for (int k = 0; k < n; ++k) {
    vz = (m * vz + dt * (force - kLoad)) / (m + stiff * dt * dt);
    BodyMotion motion{{Vec3(x, 0, z), Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()))}, {}, {}, {}};
    x += kSpeed * dt;
    z += vz * dt;
    turn += spin * dt;
    motion.X_WB_end = {Vec3(x, 0, z), Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()))};
    motion.V_WB_end = {Vec3(kSpeed, 0, vz), Vec3(0, spin, 0)};
    BodyResult r;
    terrain->step(k * dt, dt, {&motion, 1}, {&r, 1});
    force = r.impulse.z() / dt;
    stiff = r.linearisation ? -r.linearisation->dF_dx(2, 2) : 0;
  }
  return kSeconds / (static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
}

}  // namespace

int main() {
  for (const bool rough : {false, true})
    for (const double dt : {1e-3, 1.0 / 240}) {
      double best = 0;
      for (int k = 0; k < 5; ++k)
        best = std::max(best, measure(rough ? std::make_shared<Sinusoid>() : flat_ground(), dt));
      std::printf("%s, host step %.4g ms: %.0f times real time a wheel and core\n", rough ? "sinusoid" : "flat",
                  1e3 * dt, best);
    }
}
