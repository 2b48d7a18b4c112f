#pragma once
// The published procedure written down as it is told, without regard for cost: every value by interpolation in all five dimensions at once, in
// double, one point after the other. Shares nothing with the library but the tables.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "synthetic.h"

namespace grouser::test {

/// Tables full of random numbers: speeds in soil parts, pressures in wheel parts, all of size 1.
inline sdem::Tables random_tables(unsigned seed, bool coarse = false) {
  sdem::Tables t = empty_tables(coarse);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> any(-1, 1);
  for (sdem::Grid& g : t.parts)
    for (auto* values : {&g.x, &g.z})
      for (float& f : *values) f = any(random);
  return t;
}

/// Linear in each of (w, vx, vz, u, v): sum over 32 corners.
inline std::pair<double, double> literal_value(const sdem::Tables& t, std::size_t part,
                                               const std::array<double, 5>& at) {
  const sdem::Grid& g = t.parts[part];
  const auto places = [](const sdem::Axis& a) {
    std::vector<double> x;
    for (int i = 0; i < a.count; ++i) x.push_back(a.first + (a.last - a.first) * i / (a.count - 1));
    return x;
  };
  const std::array<std::vector<double>, 5> axes{t.w, t.vx, t.vz, places(g.u), places(g.v)};
  std::array<std::size_t, 5> low{};
  std::array<double, 5> share{};
  for (std::size_t d = 0; d < 5; ++d) {
    std::size_t i = 0;
    while (i + 2 < axes[d].size() && axes[d][i + 1] <= at[d]) ++i;
    low[d] = i;
    share[d] = (at[d] - axes[d][i]) / (axes[d][i + 1] - axes[d][i]);
  }
  double x = 0, z = 0;
  for (unsigned corner = 0; corner < 32; ++corner) {
    double weight = 1;
    std::array<std::size_t, 5> i{};
    for (std::size_t d = 0; d < 5; ++d) {
      const bool up = (corner >> d) & 1u;
      weight *= up ? share[d] : 1 - share[d];
      i[d] = low[d] + (up ? 1 : 0);
    }
    const std::size_t node = (i[0] * t.vx.size() + i[1]) * t.vz.size() + i[2];
    const std::size_t k =
        (node * static_cast<std::size_t>(g.u.count) + i[3]) * static_cast<std::size_t>(g.v.count) + i[4];
    x += weight * static_cast<double>(g.x[k]);
    z += weight * static_cast<double>(g.z[k]);
  }
  return {x, z};
}

/// A wheel among soil points, forwards only.
struct Literal {
  const sdem::Tables& t;
  std::vector<std::array<double, 2>> points;
  double floor, band = 0.05;
  double r() const { return t.radius; }

  std::array<double, 3> velocity(double w, double vx, double vz) const {
    return {w, vx, std::abs(vz) <= band * std::abs(vx) ? 0 : vz};
  }
  void move(double s, double z, const std::array<double, 3>& V, double dt, bool gate_open) {
    const double m = t.part(sdem::Part::soil_right).v.last;
    for (auto& p : points) {
      const double dx = p[0] - s, dz = p[1] - z;
      if (gate_open && std::abs(dx) <= m && std::abs(dz) <= m) {
        // Bottom, top, left, right of Table 5.2.
        const std::size_t part = dx < -r() ? 2 : dx > r() ? 3 : dz > 0 ? 1 : 0;
        const auto [x, y] = literal_value(t, part, {V[0], V[1], V[2], dz, dx});
        p[0] += dt * x;
        p[1] += dt * y;
      }
      const double ax = p[0] - s, az = p[1] - z, d = std::sqrt(ax * ax + az * az);
      if (d < r() - 0.0005) {
        p[0] = s + ax / d * (r() - 0.0005);
        p[1] = z + az / d * (r() - 0.0005);
      }
    }
  }
  /// (fx, fz, torque) with the trapezoid between neighbours by angle.
  std::array<double, 3> force(double s, double z, const std::array<double, 3>& V, double width) const {
    std::vector<std::array<double, 4>> on;  // angle, px, pz, along the rim
    for (const auto& p : points) {
      const double dx = p[0] - s, dz = p[1] - z;
      if (std::sqrt(dx * dx + dz * dz) >= r()) continue;
      const auto [x, y] = dz <= 0 ? literal_value(t, 4, {V[0], V[1], V[2], z - floor, std::atan2(dx, -dz)})
                                  : literal_value(t, 5, {V[0], V[1], V[2], dz, std::atan2(dx, dz)});
      const double a = std::atan2(dx, -dz);
      on.push_back({a, x, y, x * std::cos(a) + y * std::sin(a)});
    }
    std::sort(on.begin(), on.end());
    std::array<double, 3> f{};
    for (std::size_t i = 1; i < on.size(); ++i) {
      const double arc = r() * (on[i][0] - on[i - 1][0]);
      if (arc > 0.01) continue;
      f[0] += 0.5 * arc * width * (on[i][1] + on[i - 1][1]);
      f[1] += 0.5 * arc * width * (on[i][2] + on[i - 1][2]);
      f[2] += 0.5 * arc * width * r() * (on[i][3] + on[i - 1][3]);
    }
    return f;
  }
};

}  // namespace grouser::test
