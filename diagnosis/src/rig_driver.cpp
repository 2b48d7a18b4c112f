#include "rig_driver.h"

#include <cmath>

namespace grouser::diagnosis {
namespace {

constexpr long in_ruts = 2;       // steps in one
constexpr double soft_rut = 0.7;  // of a pass's depth: the next one does not begin above it

/// A wheel that is moved by hand: keeps the terrain's clock and the last pose.
class HeldWheel {
 public:
  HeldWheel(Terrain& terrain, double radius, double speed, double spin)
      : terrain_(terrain), radius_(radius), speed_(speed), spin_(spin) {}

  /// Sets the wheel down at x, or lifts it there.
  void place(double x, double depth) { pose_ = {{x, 0, radius_ - depth}, pose_.q}; }
  void lift(double x) {
    place(x, -radius_);
    step(0, radius_ / speed_);
  }
  void travel(double length) { step(length, length / speed_); }

  Vec3 force = Vec3::Zero();  ///< [N] of the last step
  double torque = 0;          ///< [N m]

 private:
  void step(double length, double dt) {
    BodyMotion m;
    m.X_WB_begin = pose_;
    angle_ += spin_ * dt;
    pose_.p.x() += length;
    pose_.q = Quat(Eigen::AngleAxisd(angle_, Eigen::Vector3d::UnitY()));
    m.X_WB_end = pose_;
    m.V_WB_end.v = {length / dt, 0, 0};
    m.V_WB_end.w = {0, spin_, 0};
    BodyResult r;
    terrain_.step(time_, dt, {&m, 1}, {&r, 1});
    time_ += dt;
    force = r.impulse / dt;
    torque = -r.angular_impulse.y() / dt;
  }
  Terrain& terrain_;
  double radius_, speed_, spin_, angle_ = 0, time_ = 0;
  Pose pose_;
};

double contact_length(double radius, double depth) { return std::sqrt(depth * (2 * radius - depth)); }

}  // namespace

RigDriver::RigDriver(ModelInfo model, std::string options, std::string name, const RigNumerics& numerics)
    : model_(std::move(model)),
      options_(ConfigDocument::from_text(std::move(options), std::move(name))),
      numerics_(numerics) {
  options_.check();
  const double steps = std::max(1.0, std::round(numerics_.average_over / numerics_.step));
  numerics_.step = numerics_.average_over / steps;
}

std::unique_ptr<Terrain> RigDriver::make(const Soil& soil) const {
  auto terrain = model_.make({soil, ground_, options_.root(), 9.81});
  options_.check();
  return terrain;
}

std::vector<Effect> RigDriver::effects(const Soil& soil) const {
  const auto terrain = make(soil);
  if (!terrain->capabilities().continuous)
    throw ConfigError(
        options_.file(), 0, 0,
        "model '" + model_.id + "' integrates the wheel itself: it cannot be held at a depth as this rig does");
  return terrain->effects();
}

bool RigDriver::remembers(const Soil& soil) const { return make(soil)->capabilities().memory; }

std::optional<Rolled> RigDriver::roll(const Soil& soil, std::span<const Amplitude> effects, double radius, double width,
                                      double slip, double omega, std::span<const double> depths) const {
  const bool locked = slip <= -1;
  const double rim = radius * std::abs(omega), speed = locked ? rim : slip < 0 ? rim / (1 + slip) : rim * (1 - slip);
  if (!(speed > 0) || depths.empty()) return std::nullopt;
  for (const double z : depths)
    if (!(z > 0 && z < radius)) return std::nullopt;
  const RigNumerics& n = numerics_;
  try {
    const auto terrain = make(soil);
    terrain->add_body({"wheel", {"wheel", SmoothCylinder{radius, width}}, Pose()});
    for (const auto& [id, amplitude] : effects) terrain->set_effect(id, amplitude);
    HeldWheel wheel(*terrain, radius, speed, locked ? 0 : std::abs(omega));
    const long mean = std::lround(n.average_over / n.step);
    const auto whole = [](double length, double step) { return std::lround(std::ceil(length / step)); };
    Rolled out;
    for (std::size_t pass = 0; pass < depths.size(); ++pass) {
      const bool measured = pass + 1 == depths.size();
      const long run_in = whole(n.run_in * contact_length(radius, depths[pass]), n.average_over);
      const double start = -static_cast<double>(run_in) * n.average_over;
      if (pass > 0) {
        wheel.lift(start);
        out.rut = terrain->surface(n.average_over, 0).sinkage;
      }
      wheel.place(start, depths[pass]);
      for (long i = 0; i < run_in; ++i) wheel.travel(n.average_over);
      if (!measured) {  // a rut for all that the last pass will stand on
        const double reach =
            contact_length(radius, std::max(depths.back() - soft_rut * depths[pass], 0.1 * depths.back()));
        for (long i = whole((n.settle + 1) * reach, n.step) + mean; i > 0; --i) wheel.travel(n.step);
        continue;
      }
      const double below = std::max(depths[pass] - out.rut, 0.02 * depths[pass]);
      const long settle = whole(n.settle * contact_length(radius, below), n.step);
      // In a rut pressure sets in over the small depth by which the soil sprang back: finer steps.
      const long parts = pass > 0 ? in_ruts : 1;
      for (long i = 0; i < (settle + mean) * parts; ++i) {
        wheel.travel(n.step / static_cast<double>(parts));
        if (i < settle * parts) continue;
        out.drawbar += wheel.force.x(), out.vertical += wheel.force.z(), out.torque += wheel.torque;
      }
    }
    const auto count = static_cast<double>(mean * (depths.size() > 1 ? in_ruts : 1));
    out.drawbar /= count, out.vertical /= count, out.torque /= count;
    return out;
  } catch (const TerrainError&) {
    return std::nullopt;
  }
}

}  // namespace grouser::diagnosis
