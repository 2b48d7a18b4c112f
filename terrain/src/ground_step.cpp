#include "grouser/terrain/ground_step.h"

#include <algorithm>

#include "ground_detail.h"

namespace grouser {

namespace {

using namespace ground_detail;

class StepGround final : public GroundShape<StepGround> {
 public:
  explicit StepGround(const StepSettings& p) : p_(p), f_(p.frame) {}

  double at(double x, double y) const {
    const double s = f_.along(x, y);
    if (s >= p_.ramp) return p_.height;
    return s <= 0 ? 0 : p_.height * (s / p_.ramp);
  }
  Vec3 normal(double x, double y) const override {
    const double s = f_.along(x, y);
    return s > 0 && s < p_.ramp ? f_.normal(p_.height / p_.ramp, 0) : Vec3::UnitZ();
  }
  double resolution() const override { return std::max(p_.ramp, 1e-3); }
  std::string describe() const override {
    return "step " + number(p_.height * 1e3) + " mm" + (p_.ramp > 0 ? ", ramp " + number(p_.ramp * 1e3) + " mm" : "") +
           frame_text(p_.frame);
  }

 private:
  StepSettings p_;
  Frame f_;
};

}  // namespace

GroundPtr step_ground(const StepSettings& p) {
  check_frame(p.frame);
  require(std::isfinite(p.height), "step: height must be finite");
  require(p.ramp == 0 || (p.ramp >= 1e-3 && std::isfinite(p.ramp)), "step: ramp must be 0 (vertical) or at least 1 mm");
  return std::make_shared<StepGround>(p);
}

}  // namespace grouser
