#include "bench_check.h"

#include <algorithm>
#include <random>

namespace grouser::diagnosis {

double bench_sd(const Search& s, int entry) {
  double load = 0, speed = 0, force = 0, torque = 0;
  for (const Run& r : s.series().runs()) {
    load = std::max(load, r.load), speed = std::max(speed, r.omega);
    if (std::isfinite(r.value[0])) force = std::max(force, std::abs(r.value[0]));
    if (std::isfinite(r.value[1])) torque = std::max(torque, std::abs(r.value[1]));
  }
  const auto reading = [&](std::size_t channel) {
    return s.noise().scale[channel] * s.usual_sd()[channel] / 2;  // four readings
  };
  switch (static_cast<Map>(entry - model_effects)) {
    case Map::torque_offset:
      return reading(1);
    case Map::torque_viscous:
      return reading(1) / speed;
    case Map::torque_bearing:
      return reading(1) / load;
    case Map::drawbar_bias:
      return reading(0);
    case Map::bed_slope:
      return 0.1 * 0.017453292519943295;
    case Map::sinkage_datum:
      return reading(2);
    case Map::rig_compliance:
      return reading(2) / load;
    case Map::wheel_radius_error:
    case Map::load_error:
      return 0.002;
    case Map::drawbar_gain:
      return reading(0) / std::max(force, 1e-9);
    case Map::torque_gain:
      return reading(1) / std::max(torque, 1e-9);
  }
  return INFINITY;
}

double bench_chance(double x, double spread, double sd) {
  constexpr int draws = 400;
  const double with = sd * sd + spread * spread, without = sd * sd;
  std::mt19937_64 random(71);
  std::normal_distribution<double> normal;
  int shown = 0, cleared = 0;
  for (int i = 0; i < draws; ++i) {
    const double e = normal(random);
    const auto ln_odds = [&](double z) {
      return -0.5 * ((z - x) * (z - x) / with + std::log(with) - z * z / without - std::log(without));
    };
    shown += ln_odds(x + e * std::sqrt(with)) > std::log(decisive) ? 1 : 0;
    cleared += ln_odds(e * sd) < -std::log(decisive) ? 1 : 0;
  }
  return std::min(shown, cleared) / static_cast<double>(draws);
}

}  // namespace grouser::diagnosis
