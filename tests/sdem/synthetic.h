#pragma once
// Tables whose content is a formula, so that what comes out of them is known otherwise.
#include <cmath>
#include <functional>
#include <memory>

#include "grouser/sdem/tables.h"
#include "grouser/terrain/types.h"

namespace grouser::test {

/// (w, vx, vz, u, v) -> two components, as the parts of Tables have them.
using TableFunction = std::function<std::pair<double, double>(double w, double vx, double vz, double u, double v)>;

inline void fill(sdem::Tables& t, sdem::Part part, const TableFunction& f) {
  sdem::Grid& g = t.part(part);
  for (std::size_t a = 0; a < t.w.size(); ++a)
    for (std::size_t b = 0; b < t.vx.size(); ++b)
      for (std::size_t c = 0; c < t.vz.size(); ++c)
        for (int i = 0; i < g.u.count; ++i)
          for (int j = 0; j < g.v.count; ++j) {
            const auto [x, z] = f(t.w[a], t.vx[b], t.vz[c], g.u.at(i), g.v.at(j));
            const std::size_t k = g.index(t.node(a, b, c), i, j);
            g.x[k] = static_cast<float>(x);
            g.z[k] = static_cast<float>(z);
            g.known[k] = 1;
          }
}

inline constexpr double kRadius = 0.065, kWidth = 0.03, kBed = 0.155;  // [m], of the dissertation's wheel and bed

/// Nodes and grids of the published plan, values zero; coarse: a few nodes and cells, for tests that write files.
inline sdem::Tables empty_tables(bool coarse = false) {
  sdem::Tables t;
  t.title = "synthetic";
  t.source = "a formula";
  t.wheel = "wheel";
  t.radius = kRadius;
  t.width = kWidth;
  t.bed_depth = kBed;
  t.soil = "diameter_smallest_m 0.0025\n";
  t.inputs = "formula";
  t.w = {0, 15 * pi / 180, 20 * pi / 180};
  t.vx = {0, 0.007, 0.014, 0.021, 0.028, 0.035};
  t.vz = {-0.01, -0.00625, -0.0025, 0.0025, 0.00625, 0.01};
  sdem::GridSettings grid;
  if (coarse) {
    t.w = {0, 20 * pi / 180};
    t.vx = {0, 0.02, 0.035};
    grid.cell = 0.012;
  }
  t.shape(grid);
  return t;
}

/// A soil like Bekker's with n = 1: pressure normal to the rim, `k` times the depth under the undisturbed surface [Pa/m], growing with the
/// speed of sinking by vz/rate; soil does not move by itself. Tension, where the rim is above the surface, stays in the table.
inline sdem::Tables bekker_tables(double k, double rate, bool coarse = false) {
  sdem::Tables t = empty_tables(coarse);
  fill(t, sdem::Part::wheel_bottom, [=](double, double, double vz, double height, double theta) {
    const double p = k * (kBed - height + kRadius * std::cos(theta)) * (1 - vz / rate);
    return std::pair{-p * std::sin(theta), p * std::cos(theta)};
  });
  return t;
}

inline std::shared_ptr<const sdem::Tables> shared(sdem::Tables t) {
  return std::make_shared<const sdem::Tables>(std::move(t));
}

}  // namespace grouser::test
