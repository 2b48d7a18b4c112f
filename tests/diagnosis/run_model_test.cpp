// Slopes of the runs against differences of the runs themselves.
#include "../../diagnosis/src/run_model.h"

#include <gtest/gtest.h>

#include <chrono>

namespace grouser::diagnosis {
namespace {

bekker::EffectWheel wheel() { return {0.13, 0.16, 0.16, {}}; }
std::array<double, soil_count> soil() {
  return {std::log(254.1e3), 1.387, 139.28, 0.606, std::log(0.5151e-3), 0.18, 0.32};
}

Run run(double slip, double load, double omega, int pass) {
  Run r;
  r.slip = slip, r.load = load, r.omega = omega, r.pass = pass, r.order = 0.4;
  return r;
}

// Every effect at its typical size in turn, five runs, all inputs. Central differences of step h err by h^2 and by 1e-9/h of the
// equilibrium's own tolerance: 2e-4 of the slope or of what a typical amplitude does is below any misprint.
TEST(RunModel, SlopesAgreeWithDifferences) {
  const diagnosis::Run runs[] = {run(-0.5, 60, 0.3, 2), run(-0.1, 225, 0.9, 1), run(0, 115, 0.1, 2),
                                 run(0.1, 170, 0.3, 1), run(0.6, 115, 0.9, 2)};
  const std::size_t n = effect_entries().size();
  for (std::size_t on = 0; on <= n; ++on)
    for (const diagnosis::Run& r : runs) {
      Inputs in = plain_inputs(soil());
      if (on < n) in[soil_count + on] = effect_entries()[on].typical;
      double theta = 0;
      Outputs y;
      Slopes d;
      ASSERT_TRUE(model_run(wheel(), r, in, Wanted::all, {}, theta, y, &d));
      for (std::size_t i = 0; i < in.size(); ++i) {
        if ((on == 3 || on == 4) && std::abs(r.slip) < 0.2)
          continue;  // the floor of the speed is met: a kink between the points
        if (r.slip == 0 &&
            (i == soil_count + 26 || i == soil_count + 9 || i == soil_count + 11 || on == 4 || on == 9 || on == 11))
          continue;  // true kinks there
        const double size = i < soil_count ? (i == 2 ? 100 : 0.1) : std::abs(effect_entries()[i - soil_count].typical),
                     h = 1e-4 * size;
        Outputs up, down;
        double t = theta;
        Inputs p = in;
        p[i] += h;
        if (!model_run(wheel(), r, p, Wanted::value, {}, t, up, nullptr)) continue;
        p[i] -= 2 * h;
        ASSERT_TRUE(model_run(wheel(), r, p, Wanted::value, {}, t, down, nullptr));
        const double scale[3] = {10, 1, 0.01};
        for (std::size_t c = 0; c < 3; ++c) {
          const double by_difference = (up[c] - down[c]) / (2 * h);
          EXPECT_NEAR(d(static_cast<int>(c), static_cast<int>(i)), by_difference,
                      2e-4 * (std::abs(by_difference) + scale[c] / size))
              << "effect " << (on < n ? effect_entries()[on].id : "none") << " input " << i << " channel " << c
              << " slip " << r.slip;
        }
      }
    }
}

}  // namespace
}  // namespace grouser::diagnosis
