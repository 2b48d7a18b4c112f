#include "grouser/terrain/ground_slope.h"

#include <limits>

#include "ground_detail.h"

namespace grouser {

namespace {

using namespace ground_detail;

class SlopeGround final : public GroundShape<SlopeGround> {
 public:
  explicit SlopeGround(const SlopeSettings& p) : p_(p), f_(p.frame), tan_(std::tan(p.angle)) {}

  double at(double x, double y) const {
    const double s = f_.along(x, y);
    if (s <= 0) return 0;
    if (s < p_.transition) return tan_ * s * s / (2 * p_.transition);
    return tan_ * (s - 0.5 * p_.transition);
  }
  Vec3 normal(double x, double y) const override {
    const double s = f_.along(x, y);
    if (s <= 0) return Vec3::UnitZ();
    return f_.normal(s < p_.transition ? tan_ * s / p_.transition : tan_, 0);
  }
  double resolution() const override {
    return p_.transition > 0 ? p_.transition / 8 : std::numeric_limits<double>::infinity();
  }
  std::string describe() const override { return "slope " + number(degrees(p_.angle)) + " deg" + frame_text(p_.frame); }

 private:
  SlopeSettings p_;
  Frame f_;
  double tan_;
};

}  // namespace

GroundPtr slope_ground(const SlopeSettings& p) {
  check_frame(p.frame);
  require(std::abs(p.angle) <= pi / 3 + 1e-12, "slope: angle must be within -60..60 deg");
  require(p.transition >= 0 && std::isfinite(p.transition), "slope: transition must be at least 0");
  return std::make_shared<SlopeGround>(p);
}

}  // namespace grouser
