#include "grouser/terrain/ground_grid.h"

#include <algorithm>

#include "ground_bilinear.h"
#include "grouser/terrain/ground_extent.h"

namespace grouser {

namespace {

using namespace ground_detail;

class HeightMapGround final : public GroundShape<HeightMapGround>, public GroundWithData {
 public:
  HeightMapGround(HeightGrid g, Outside outside, std::string name)
      : field_(std::move(g)), outside_(outside), name_(std::move(name)) {}

  double at(double x, double y) const {
    if (outside_ != Outside::extend) return field_.height(place(x, y));
    Place p;
    field_.locate(field_.u(x), field_.v(y), p);
    return field_.height(p);
  }
  Vec3 normal(double x, double y) const override {
    const Place p = place(x, y);
    const Vec2 g = field_.gradient(p);
    return normal_from_gradient(g.x() * p.sign_u, g.y() * p.sign_v);
  }
  std::string beyond_data(double x, double y) const override {
    if (outside_ != Outside::extend) return {};
    const double u = field_.u(x), v = field_.v(y);
    if (u >= 0 && u <= field_.u_max && v >= 0 && v <= field_.v_max) return {};
    return "height map " + name_ + ": outside its edge, whose heights continue";
  }
  double resolution() const override { return std::min(field_.grid.dx, field_.grid.dy); }
  std::string describe() const override {
    static const char* const beyond[] = {"edge extended", "mirrored", "repeated", "error beyond"};
    const HeightGrid& g = field_.grid;
    return "height map " + name_ + ", " + std::to_string(g.nx) + " x " + std::to_string(g.ny) + " nodes, " +
           number(g.dx) + " x " + number(g.dy) + " m, x " + number(g.x0) + ".." + number(g.x0 + (g.nx - 1) * g.dx) +
           " m, y " + number(g.y0) + ".." + number(g.y0 + (g.ny - 1) * g.dy) + " m, " +
           beyond[static_cast<int>(outside_)];
  }

 private:
  Place place(double x, double y) const {
    double u = field_.u(x), v = field_.v(y);
    Place p;
    if (outside_ == Outside::mirror) {
      p.sign_u = mirror(u, field_.u_max);
      p.sign_v = mirror(v, field_.v_max);
    } else if (!(u >= 0 && u <= field_.u_max && v >= 0 && v <= field_.v_max)) {
      // A point that misses the edge by rounding is on it.
      constexpr double e = 1e-6;
      if (outside_ == Outside::error && !(u >= -e && u <= field_.u_max + e && v >= -e && v <= field_.v_max + e))
        beyond(x, y);
      p.sign_u = u < 0 || u > field_.u_max ? 0 : 1;
      p.sign_v = v < 0 || v > field_.v_max ? 0 : 1;
    }
    field_.locate(u, v, p);
    return p;
  }

  [[noreturn]] void beyond(double x, double y) const {
    const HeightGrid& g = field_.grid;
    throw GroundError("height map " + name_ + ": the point (" + number(x) + ", " + number(y) +
                      ") m is outside its extent x " + number(g.x0) + ".." + number(g.x0 + (g.nx - 1) * g.dx) +
                      " m, y " + number(g.y0) + ".." + number(g.y0 + (g.ny - 1) * g.dy) + " m, and 'outside' is error");
  }

  BilinearField field_;
  Outside outside_;
  std::string name_;
};

}  // namespace

void ground_detail::check_grid(const HeightGrid& g, const std::string& name) {
  require(g.nx >= 2 && g.ny >= 2, name + ": a height grid needs at least 2 x 2 nodes");
  require(g.dx > 0 && g.dy > 0 && std::isfinite(g.dx) && std::isfinite(g.dy), name + ": the spacing must be positive");
  require(std::isfinite(g.x0) && std::isfinite(g.y0), name + ": the lower left node must be finite");
  require(g.z.size() == static_cast<std::size_t>(g.nx) * static_cast<std::size_t>(g.ny),
          name + ": " + std::to_string(g.z.size()) + " heights for " + std::to_string(g.nx) + " x " +
              std::to_string(g.ny) + " nodes");
  for (std::size_t i = 0; i < g.z.size(); ++i)
    require(std::isfinite(g.z[i]), name + ": height of node " + std::to_string(i % static_cast<std::size_t>(g.nx)) +
                                       ", " + std::to_string(i / static_cast<std::size_t>(g.nx)) + " is not finite");
}

GroundPtr height_map_ground(HeightGrid grid, Outside outside, std::string name) {
  check_grid(grid, name);
  require(outside != Outside::repeat,
          name + ": a height map can be extended, mirrored or end in an error, not repeated");
  return std::make_shared<HeightMapGround>(std::move(grid), outside, std::move(name));
}

}  // namespace grouser
