#pragma once
// Tables at one velocity of the wheel: the nodes around it blended once, so that only two dimensions are left to interpolate.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "grouser/sdem/tables.h"

namespace grouser::sdem {

/// Of the wheel, in the sense of the tables (forward and spin not negative).
struct Velocity {
  double w = 0, vx = 0, vz = 0;  ///< [rad/s], [m/s]
  bool operator==(const Velocity&) const = default;
};

struct Pair {
  double x = 0, z = 0;
};

/// Multilinear interpolation of a table in (w, vx, vz) and two more axes, in an order that needs two dimensions per point.
///
/// at(part, u, v) = sum over the 8 velocity nodes around V of weight times the bilinear value of that node. Exact for values that are linear in
/// every axis. Rows of a part are blended when they are first asked for at a velocity and kept until the velocity changes.
/// Cost: a new velocity 8 multiplications per value of the rows in use; a point 4 per component.
class Blend {
 public:
  explicit Blend(std::shared_ptr<const Tables> tables);
  /// V must lie within the nodes (see `outside`).
  void set(const Velocity& V);
  const Velocity& velocity() const { return velocity_; }
  /// u, v must lie within the part's axes.
  Pair at(Part part, double u, double v);
  const Tables& tables() const { return *tables_; }

 private:
  struct Corner {
    std::size_t node;
    float weight;
  };
  struct Rows {
    std::vector<float> x, z;
    std::vector<std::uint8_t> ready;  ///< of each row
  };
  void blend_row(std::size_t part, int row);

  std::shared_ptr<const Tables> tables_;
  Velocity velocity_{-1e300, -1e300, -1e300};
  std::vector<Corner> corners_;
  std::array<Rows, 6> rows_;
};

/// Says which coordinate of V lies outside the nodes and by what, "" when none does.
std::string outside(const Tables& t, const Velocity& V);
/// The nearest velocity within the nodes.
Velocity nearest(const Tables& t, Velocity V);

}  // namespace grouser::sdem
