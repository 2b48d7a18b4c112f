#include "grouser/terrain/ground.h"

#include <limits>

#include "ground_detail.h"

namespace grouser {

Vec3 Ground::normal(double x, double y) const {
  constexpr double d = 0.5e-3;
  return ground_detail::normal_from_gradient((height(x + d, y) - height(x - d, y)) / (2 * d),
                                             (height(x, y + d) - height(x, y - d)) / (2 * d));
}

namespace {

class FlatGround final : public ground_detail::GroundShape<FlatGround> {
 public:
  explicit FlatGround(double z) : z_(z) {}
  double at(double, double) const { return z_; }
  Vec3 normal(double, double) const override { return Vec3::UnitZ(); }
  double resolution() const override { return std::numeric_limits<double>::infinity(); }
  std::string describe() const override { return z_ == 0 ? "flat" : "flat at " + ground_detail::number(z_) + " m"; }

 private:
  double z_;
};

}  // namespace

GroundPtr flat_ground(double z) {
  ground_detail::require(std::isfinite(z), "flat: height must be finite");
  return std::make_shared<FlatGround>(z);
}

}  // namespace grouser
