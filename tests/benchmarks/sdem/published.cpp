// What a step of the published surrogate costs, library and literal procedure side by side, on tables of the published size: 108 velocity
// nodes, cells of 4 mm, points 2.5 mm apart, steps of 0.7 ms; a wheel that rolls at a held depth, its soil moving and its vertical velocity
// changing in every step. Processor time, best of five and of two.
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>

#include "../../sdem/literal.h"
#include "grouser/sdem/slice.h"

namespace {

using namespace grouser;

constexpr double kStep = 7e-4, kSpin = 0.29, kSpeed = 0.015, kDepth = 4e-3,
                 kWay = 0.05;  // [s], [rad/s], [m/s], [m], [m]
constexpr int kPoints = 1100;  // Table 5.4

double vertical(int i) { return 2e-3 * std::sin(0.1 * i); }
double since(std::clock_t begin) { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; }

}  // namespace

int main() {
  auto made = test::random_tables(1);
  for (std::size_t p = 0; p < 4; ++p)  // centimetres a second, not metres
    for (auto* v : {&made.parts[p].x, &made.parts[p].z})
      for (float& x : *v) x *= 0.005F;
  const auto tables = std::make_shared<const sdem::Tables>(made);
  const double z = test::kRadius - kDepth;
  const int steps = static_cast<int>(kWay / kSpeed / kStep);
  double library = 1e9, literal = 1e9, sum = 0;
  for (int k = 0; k < 5; ++k) {
    sdem::SliceSettings settings;
    settings.gate = false;
    settings.floor = -test::kBed;
    sdem::Slice slice(tables, settings);
    const std::clock_t begin = std::clock();
    for (int i = 0; i < steps; ++i) {
      const sdem::WheelState x{i * kStep * kSpeed, z, kSpeed, vertical(i), kSpin};
      slice.lay(x.s, [](double) { return 0.0; });
      slice.move(x, kStep, 0, 0);
      sum += slice.force(x, test::kWidth).fz;
    }
    library = std::min(library, since(begin) / steps);
  }
  for (int k = 0; k < 2; ++k) {
    test::Literal row{*tables, {}, -test::kBed};
    for (int i = 0; i < kPoints; ++i) row.points.push_back({(i - kPoints / 2) * 0.0025, 0});
    const std::clock_t begin = std::clock();
    for (int i = 0; i < steps; ++i) {
      const auto V = row.velocity(kSpin, kSpeed, vertical(i));
      row.move(i * kStep * kSpeed, z, V, kStep, true);
      sum += row.force(i * kStep * kSpeed, z, V, test::kWidth)[1];
    }
    literal = std::min(literal, since(begin) / steps);
  }
  std::printf("library: %.2f us a step, %.0f times real time; literal: %.0f us a step, %.1f times real time (%g)\n",
              1e6 * library, kStep / library, 1e6 * literal, kStep / literal, sum);
}
