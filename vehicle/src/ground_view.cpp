#include "ground_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grouser/terrain/ground_frame.h"

namespace grouser::vehicle {

namespace {

/// Index range of the rows and columns that are left, ends not included.
struct Left {
  std::size_t a, b;
  std::size_t size() const { return b - a; }
};

/// Takes away the border with the largest share of missing nodes until none is missing.
void clip(const std::vector<double>& z, std::size_t nx, Left& x, Left& y) {
  const auto share = [&](const Left& cols, const Left& rows) {
    std::size_t missing = 0;
    for (std::size_t j = rows.a; j < rows.b; ++j)
      for (std::size_t i = cols.a; i < cols.b; ++i) missing += std::isnan(z[j * nx + i]);
    return static_cast<double>(missing) / static_cast<double>(cols.size() * rows.size());
  };
  while (x.size() > 0 && y.size() > 0 && share(x, y) > 0) {
    const double worst[4] = {share({x.a, x.a + 1}, y), share({x.b - 1, x.b}, y), share(x, {y.a, y.a + 1}),
                             share(x, {y.b - 1, y.b})};
    switch (std::max_element(worst, worst + 4) - worst) {
      case 0:
        ++x.a;
        break;
      case 1:
        --x.b;
        break;
      case 2:
        ++y.a;
        break;
      default:
        --y.b;
    }
  }
}

}  // namespace

GroundView ground_view(const Ground& ground, std::vector<double> x, std::vector<double> y) {
  std::vector<double> z;
  z.reserve(x.size() * y.size());
  bool whole = true;
  for (const double b : y)
    for (const double a : x) try {
        z.push_back(ground.height(a, b));
      } catch (const GroundError&) {
        z.push_back(std::numeric_limits<double>::quiet_NaN());
        whole = false;
      }
  if (whole) return {std::move(x), std::move(y), std::move(z)};
  Left cols{0, x.size()}, rows{0, y.size()};
  clip(z, x.size(), cols, rows);
  if (cols.size() < 2 || rows.size() < 2) return {};
  GroundView v;
  for (std::size_t i = cols.a; i < cols.b; ++i) v.x.push_back(x[i]);
  for (std::size_t j = rows.a; j < rows.b; ++j) {
    v.y.push_back(y[j]);
    for (std::size_t i = cols.a; i < cols.b; ++i) v.height.push_back(z[j * x.size() + i]);
  }
  return v;
}

void write_ground_view(Recorder& file, const GroundView& v) {
  if (v.height.empty()) return;
  file.write_static({"ground.x", "m", "grid of the undisturbed ground", "W"}, v.x, {v.x.size()});
  file.write_static({"ground.y", "m", "grid of the undisturbed ground", "W"}, v.y, {v.y.size()});
  file.write_static({"ground.height", "m", "undisturbed ground, row per y", "W"}, v.height, {v.y.size(), v.x.size()});
}

std::string off_ground(const Ground& ground, const RunningGear& gear, const Vec3& p, const Vec3& axle, double reach) {
  const Vec3 side = 0.5 * gear.width() * axle, ahead = reach * gear.outer_radius() * axle.cross(Vec3::UnitZ());
  for (const double i : {0.0, -1.0, 1.0})
    for (const double j : {0.0, -1.0, 1.0}) {
      const Vec3 at = p + i * ahead + j * side;
      try {
        ground.height(at.x(), at.y());
      } catch (const GroundError& e) {
        return e.what();
      }
    }
  return {};
}

}  // namespace grouser::vehicle
