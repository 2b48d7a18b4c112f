#include "grouser/terrain/rigid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "grouser/terrain/path_work.h"

namespace grouser {

namespace {

constexpr const char* kDefaults =
    R"(# model rigid: hard ground. Every key is optional; `soil` = the value of the soil file's rigid section.
stiffness: soil             # [N/m] > 0, of each wheel's contact
damping: soil               # [N s/m] >= 0, normal; never more than the spring force
friction: soil              # [1] >= 0, Coulomb coefficient
rolling_resistance: soil    # [1] >= 0, torque / (normal force * radius)
tangential_stiffness: soil  # [N/m] > 0 of the stick spring
tangential_damping: soil    # [N s/m] >= 0; soil: the normal damping
relaxation_length: contact  # [m] > 0, rolling distance in which the stick spring rolls off; contact: the contact length
strips: 3                   # [1] 1..15 discs across the width
samples_per_radius: 24      # [1] 4..400 ground samples per wheel radius
)";

struct Parameters {
  RigidSoil soil;
  double tangential_damping = 0;
  double relaxation_length = 0;  ///< 0 = contact length
  PatchOptions patch;
};

Parameters read(const TerrainArgs& args) {
  const ConfigNode& o = args.options;
  Parameters p;
  p.soil = args.soil.rigid.value_or(RigidSoil{});
  const auto soil_or = [&](const char* key, const char* unit, double value, Range range) {
    if (!o.has(key)) return value;
    if (const ConfigNode n = o.node(key); n.is_scalar() && n.as_text() == "soil") return value;
    return o.quantity_or(key, value, unit, range);
  };
  if (o.present()) {
    p.soil.stiffness = soil_or("stiffness", "N/m", p.soil.stiffness, {0, 1e12, true, false});
    p.soil.damping = soil_or("damping", "N s/m", p.soil.damping, Range::between(0, 1e12));
    p.soil.friction = soil_or("friction", "1", p.soil.friction, Range::between(0, 5));
    p.soil.rolling_resistance = soil_or("rolling_resistance", "1", p.soil.rolling_resistance, Range::between(0, 1));
    p.soil.tangential_stiffness =
        soil_or("tangential_stiffness", "N/m", p.soil.tangential_stiffness, {0, 1e12, true, false});
  }
  if (p.soil.tangential_stiffness == 0) p.soil.tangential_stiffness = p.soil.stiffness;
  p.tangential_damping = p.soil.damping;
  if (o.present()) {
    p.tangential_damping = soil_or("tangential_damping", "N s/m", p.soil.damping, Range::between(0, 1e12));
    const ConfigNode length = o.node("relaxation_length");
    if (length.present() && !(length.is_scalar() && length.as_text() == "contact"))
      p.relaxation_length = length.as_quantity("m", {0, 1e3, true, false});
    p.patch.strips = static_cast<int>(o.integer_or("strips", 3, 1, 15));
    p.patch.samples_per_radius = static_cast<int>(o.integer_or("samples_per_radius", 24, 4, 400));
    o.finish();
  }
  return p;
}

class Rigid final : public Terrain {
 public:
  Rigid(const Parameters& p, GroundPtr ground) : Terrain(std::move(ground)), p_(p) {}
  std::string id() const override { return "rigid"; }
  Capabilities capabilities() const override { return {}; }

 private:
  struct Wheel {
    double radius, width, slip_radius;
    PatchFinder finder;
    Vec2 u = Vec2::Zero();                          ///< bristle in (forward, lateral) of the patch [m]
    double roll = 0;                                ///< q of R3
    double elastic = 0, rolled = 0;                 ///< [J] stored in the springs and in the rolling element
    double spent = 0, integration = 0, placed = 0;  ///< [J] of the last step; placed: held when the wheel was set down
    bool fresh = true;                              ///< no step yet
    Vec6 g = Vec6::Zero();                          ///< generalised normal of the last step, zero without contact
    double sinkage = 0;                             ///< of the last step [m]
    double along = std::numeric_limits<double>::quiet_NaN();  ///< WheelPose::along of the last step [m]
  };

  void do_add_body(const BodySpec& b) override {
    wheels_.push_back({b.gear.outer_radius(), b.gear.width(), b.gear.radius(), PatchFinder(p_.patch)});
  }

  void do_step(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    parallel_for(static_cast<int>(motions.size()), [&](int i) {
      advance(wheels_[i], wheel_motion(bodies()[i], motions[i], wheels_[i].radius, wheels_[i].width), c.dt, results[i]);
    });
    double stored = 0;
    for (const Wheel& w : wheels_) {  // in the order of the bodies, whatever the threads did
      stored += w.elastic + w.rolled;
      ledger().dissipated += w.spent;
      ledger().integration += w.integration;
      ledger().external += w.placed;
    }
    ledger().stored = stored;
  }

  void advance(Wheel& wheel, const WheelMotion& motion, double dt, BodyResult& result) const {
    const WheelMotion m = moved_on(motion, wheel.along, dt);
    wheel.along = m.pose.along;
    const ContactPatch patch = wheel.finder.find(m.pose, ground());
    const double elastic_before = wheel.elastic, rolled_before = wheel.rolled, roll_before = wheel.roll;
    wheel.spent = wheel.integration = wheel.placed = 0;
    const bool fresh = std::exchange(wheel.fresh, false);
    if (!patch.contact) {
      clear_result(result);
      wheel.integration = elastic_before;  // the normal spring was released within the step, past its last impulse
      wheel.spent = rolled_before;
      wheel.u.setZero();
      wheel.g.setZero();
      wheel.sinkage = 0;
      wheel.roll = wheel.elastic = wheel.rolled = 0;
      return;
    }
    const RigidSoil& s = p_.soil;
    Vec6 V;
    V << m.V.v, m.V.w;

    // Normal: spring from the potential, damper limited by the spring (R1).
    const double h = patch.sinkage, rate = -patch.g.dot(V);
    const double spring = s.stiffness * h;
    const double damper = std::clamp(s.damping * rate, -spring, spring);
    const double N = spring + damper;
    const bool limited = std::abs(s.damping * rate) > spring;
    const double kn = limited ? (rate > 0 ? 2 * s.stiffness : 0.0) : s.stiffness;
    const double dn = limited ? 0.0 : s.damping;
    Vec6 wrench = N * patch.g;
    Mat6 K = -kn * patch.g * patch.g.transpose();
    Mat6 D = -dn * patch.g * patch.g.transpose();

    // Tangential: bristle at the contact point (R2). Rows a: sliding velocity of the wheel's surface = -a . V.
    const Vec3 arm = patch.arm_W - (m.pose.radius - h) * patch.normal_W;
    Eigen::Matrix<double, 6, 2, Eigen::DontAlign> a;
    a.col(0) << patch.forward_W, arm.cross(patch.forward_W);
    a.col(1) << patch.lateral_W, arm.cross(patch.lateral_W);
    const Vec2 slide = -(a.transpose() * V);
    const double rolling = std::abs(m.pose.radius * m.spin);
    const double sigma = p_.relaxation_length > 0 ? p_.relaxation_length : patch.chord;
    const double x = rolling * dt / sigma, keep = std::exp(-x);
    const double share = x > 1e-8 ? (1 - keep) / x : 1.0;
    const Vec2 u0 = wheel.u;
    Vec2 u = u0 * keep + slide * (share * dt);
    const double kt = s.tangential_stiffness, dtan = p_.tangential_damping;
    Vec2 T = kt * u + dtan * slide;
    const double cap = s.friction * N, size = T.norm();
    Eigen::Matrix2d tangent = Eigen::Matrix2d::Identity();
    if (size > cap) {
      const Vec2 e = T / size;
      T = cap * e;
      u = T / kt;  // sliding: the spring alone holds what friction can carry
      tangent = (cap / size) * (tangent - e * e.transpose());
      const Vec6 along = a * e;  // the cone follows the normal force
      K -= s.friction * kn * along * patch.g.transpose();
      D -= s.friction * dn * along * patch.g.transpose();
    }
    wrench += a * T;
    const Mat6 stick = a * tangent * a.transpose();
    K -= kt * share * keep * stick;
    D -= (dtan + kt * share * dt * (1 - keep)) * stick;
    wheel.u = u;

    // Rolling resistance (R3), a Dahl element in the angle of the wheel.
    const double moment = s.rolling_resistance * N * m.pose.radius;
    if (moment > 0) {
      wheel.roll = wheel.roll * keep + (m.spin < 0 ? -1.0 : 1.0) * (1 - keep);
      const Vec3 axis = m.pose.axis_W;
      wrench.tail<3>() -= moment * wheel.roll * axis;
      const double stiffness = moment * m.pose.radius / sigma * std::max(0.0, 1 - std::abs(wheel.roll));
      K.bottomRightCorner<3, 3>() -= stiffness * axis * axis.transpose();
    }

    // Energy: elastic parts are functions of the state; losses from force times the velocity that is lost.
    const double to_bristle = kt * u.dot(u - u0);
    const double per_roll = s.rolling_resistance * N * sigma;
    const double per_roll_before = roll_before != 0 ? 2 * rolled_before / (roll_before * roll_before) : per_roll;
    wheel.elastic = 0.5 * spring * h + 0.5 * kt * u.squaredNorm();
    wheel.rolled = 0.5 * per_roll * wheel.roll * wheel.roll;
    wheel.spent = damper * rate * dt + T.dot(slide) * dt - to_bristle +
                  (moment * std::abs(m.spin) * dt - 0.5 * (per_roll - per_roll_before)) * wheel.roll * wheel.roll;
    // The host's step does end-of-step force times displacement: its error for the normal spring is that less the force's work on the way,
    // for the bristle and the rolling element that less what they take at the stiffness the step began with.
    const auto force = [&s](double depth) { return s.stiffness * depth; };
    Pressing begin{wheel.sinkage, -wheel.g.dot(V)};
    if (fresh) {
      begin = Pressing::of(wheel.finder.find(earlier(m.pose, m.V, dt), ground()), m.V);
      wheel.placed = 0.5 * s.stiffness * begin.sinkage * begin.sinkage;
    }
    const Pressing end{h, rate};
    const double tolerance = path_tolerance(dt, m.V, force(begin.sinkage), begin, spring, end);
    const double by_roll = (m.spin < 0 ? -1.0 : 1.0) * wheel.roll - wheel.roll * wheel.roll;
    wheel.integration = spring * rate * dt -
                        PathWork(wheel.finder, ground(), m, dt, tolerance, force).between(begin, end) +
                        0.5 * kt * (u - u0).squaredNorm() + moment * std::abs(m.spin) * dt * by_roll -
                        0.5 * per_roll_before * (wheel.roll * wheel.roll - roll_before * roll_before);
    wheel.sinkage = h;
    wheel.g = patch.g;

    const Wrench f{wrench.head<3>(), wrench.tail<3>()};
    fill_result(m, patch, f, K, D, dt, result);
    const Slip slip = slip_of(wheel.slip_radius * m.spin, m.V.v.dot(patch.forward_W), m.V.v.dot(patch.lateral_W));
    result.report.slip = slip.slip;
    result.report.slip_angle = slip.angle;
    result.report.exit_angle = -patch.angle;
  }

  void do_preview(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) override {
    const std::vector<Wheel> wheels = wheels_;
    const EnergyLedger before = energy();
    do_step(c, motions, results);
    wheels_ = wheels;
    ledger() = before;
  }

  void do_traverse(State& s) override {
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto group = s.group("wheel" + std::to_string(i));
      s.field("bristle", wheels_[i].u);
      s.field("rolling", wheels_[i].roll);
      s.field("elastic", wheels_[i].elastic);
      s.field("rolled", wheels_[i].rolled);
      s.field("fresh", wheels_[i].fresh);
      s.field("normal", wheels_[i].g);
      s.field("sinkage", wheels_[i].sinkage);
      s.field("along", wheels_[i].along);
    }
  }

  Parameters p_;
  std::vector<Wheel> wheels_;
};

}  // namespace

ModelInfo rigid_model() {
  return {"rigid",
          "hard ground: spring-damper along the contact normal, Coulomb friction with stick, rolling resistance",
          "any ground shape, stick on slopes, rolling resistance, any running gear as a cylinder",
          "no sinkage worth the name, no ruts, no soil strength; lugs and mesh detail are not resolved",
          kDefaults,
          [](const TerrainArgs& a) -> std::unique_ptr<Terrain> { return std::make_unique<Rigid>(read(a), a.ground); }};
}

}  // namespace grouser
