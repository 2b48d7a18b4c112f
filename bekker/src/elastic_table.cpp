#include "elastic_table.h"

#include <algorithm>
#include <cmath>

#include "gauss_rule.h"

namespace grouser::bekker {

namespace {
constexpr int kCells = 256;
}

ElasticTable::ElasticTable(const WheelSize& wheel, const SoilLaw& soil, Method method, int points)
    : radius_(wheel.outer_radius()) {
  // s = sqrt(h/(2r)) = sin(theta_f/2); dE/ds = Fz 4 r s.
  fill([&](double s) {
    return 4 * radius_ * s * steady_force(wheel, soil, 2 * std::asin(s), {}, 0, method, {points, 0}, 1).Fz;
  });
}

ElasticTable::ElasticTable(double radius, const std::function<double(double)>& force) : radius_(radius) {
  fill([&](double s) { return 4 * radius_ * s * force(2 * radius_ * s * s); });
}

void ElasticTable::fill(const std::function<double(double)>& slope) {
  const GaussRule& rule = gauss_rule(4);
  energy_.assign(kCells + 1, 0);
  slope_.assign(kCells + 1, 0);
  for (int i = 0; i < kCells; ++i) {
    double cell = 0;
    for (int k = 0; k < rule.n; ++k) cell += rule.w[k] / kCells * slope((i + rule.x[k]) / kCells);
    energy_[i + 1] = energy_[i] + cell;
    slope_[i + 1] = slope((i + 1.0) / kCells * (i + 1 == kCells ? 1 - 1e-9 : 1));
  }
}

ElasticTable::Value ElasticTable::at(double sinkage) const {
  const double s = std::sqrt(std::clamp(sinkage / (2 * radius_), 0.0, 1.0));
  if (s <= 0) return {0, 0};
  const int i = std::min(static_cast<int>(s * kCells), kCells - 1);
  const double x = s * kCells - i, e0 = energy_[i], e1 = energy_[i + 1];
  const double m0 = slope_[i] / kCells, m1 = slope_[i + 1] / kCells;
  const double a = 2 * (e0 - e1) + m0 + m1, b = 3 * (e1 - e0) - 2 * m0 - m1;
  const double ds = (3 * a * x * x + 2 * b * x + m0) * kCells;
  return {((a * x + b) * x + m0) * x + e0, ds / (4 * radius_ * s)};
}

}  // namespace grouser::bekker
