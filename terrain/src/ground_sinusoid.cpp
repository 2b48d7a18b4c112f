#include "grouser/terrain/ground_sinusoid.h"

#include "ground_detail.h"

namespace grouser {

namespace {

using namespace ground_detail;

class SinusoidGround final : public GroundShape<SinusoidGround> {
 public:
  explicit SinusoidGround(const SinusoidSettings& p) : p_(p), f_(p.frame) {}

  double at(double x, double y) const {
    const double s = f_.along(x, y);
    if ((p_.bounded_start && s <= 0) || s >= p_.length) return 0;
    return weight(s) * p_.amplitude * std::sin(p_.wavenumber * s + p_.phase);
  }
  Vec3 normal(double x, double y) const override {
    const double s = f_.along(x, y);
    if ((p_.bounded_start && s <= 0) || s >= p_.length) return Vec3::UnitZ();
    const double a = p_.wavenumber * s + p_.phase;
    return f_.normal(p_.amplitude * (weight(s) * p_.wavenumber * std::cos(a) + weight_slope(s) * std::sin(a)), 0);
  }
  // 64 samples per period keep linear interpolation within 0.12 % of the amplitude.
  double resolution() const override { return 2 * pi / p_.wavenumber / 64; }
  std::string describe() const override {
    std::string t =
        "sinusoid, amplitude " + number(p_.amplitude * 1e3) + " mm, period " + number(2e3 * pi / p_.wavenumber) + " mm";
    if (p_.run_in > 0) t += ", run-in " + number(p_.run_in) + " m";
    if (std::isfinite(p_.length)) t += ", length " + number(p_.length) + " m";
    return t + frame_text(p_.frame);
  }

 private:
  double weight(double s) const {
    double w = 1;
    if (p_.run_in > 0) {
      if (p_.bounded_start) w *= smooth(s / p_.run_in);
      if (std::isfinite(p_.length)) w *= smooth((p_.length - s) / p_.run_in);
    }
    return w;
  }
  // The two ramps do not overlap, so their slopes add.
  double weight_slope(double s) const {
    double g = 0;
    if (p_.run_in > 0) {
      if (p_.bounded_start) g += smooth_slope(s / p_.run_in);
      if (std::isfinite(p_.length)) g -= smooth_slope((p_.length - s) / p_.run_in);
      g /= p_.run_in;
    }
    return g;
  }

  SinusoidSettings p_;
  Frame f_;
};

}  // namespace

GroundPtr sinusoid_ground(const SinusoidSettings& p) {
  check_frame(p.frame);
  require(p.amplitude >= 0 && std::isfinite(p.amplitude), "sinusoid: amplitude must be at least 0");
  require(p.wavenumber > 0 && std::isfinite(p.wavenumber), "sinusoid: wavenumber must be positive");
  require(std::isfinite(p.phase), "sinusoid: phase must be finite");
  require(p.run_in >= 0 && std::isfinite(p.run_in), "sinusoid: run_in must be at least 0");
  require(p.length > 0, "sinusoid: the end must lie beyond the start");
  const bool bounded = p.bounded_start || std::isfinite(p.length);
  require(p.run_in == 0 || bounded, "sinusoid: run_in needs a start or an end");
  require(2 * p.run_in <= p.length, "sinusoid: run_in must be at most half the length");
  if (p.run_in == 0) {
    constexpr double zero = 1e-6;
    require(!p.bounded_start || std::abs(std::sin(p.phase)) < zero,
            "sinusoid: phase " + number(degrees(p.phase)) +
                " deg makes a jump at the start; give run_in or a phase of 0 or 180 deg");
    require(!std::isfinite(p.length) || std::abs(std::sin(p.wavenumber * p.length + p.phase)) < zero,
            "sinusoid: the end makes a jump; give run_in or end a whole number of half periods after the start");
  }
  return std::make_shared<SinusoidGround>(p);
}

}  // namespace grouser
