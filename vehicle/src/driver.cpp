#include "grouser/vehicle/driver.h"

#include <algorithm>
#include <cmath>

#include "ranges.h"
#include "vehicle_reader.h"

namespace grouser::vehicle {

namespace {

void stand(Command& out) {
  for (WheelCommand& w : out.wheels) w = {WheelCommand::Mode::speed, 0.0};
  for (double& s : out.steer) s = 0;
}

/// Ackermann: each kingpin turns about the same centre. `reference_x`: axle that does not steer.
void steer_by_curvature(const VehicleSpec& v, double curvature, Command& out) {
  double reference_x = 0;
  int n = 0;
  for (const WheelSpec& w : v.wheels) {
    const bool steered = std::any_of(v.steering.begin(), v.steering.end(), [&](const SteerSpec& s) {
      return std::abs(v.joints[s.joint].anchor_V.x() - v.links[w.link].X_VB.p.x()) <
             0.25 * std::max(1e-9, v.wheelbase());
    });
    if (!steered) reference_x += v.links[w.link].X_VB.p.x(), ++n;
  }
  if (n) reference_x /= n;
  for (std::size_t i = 0; i < v.steering.size(); ++i) {
    const JointSpec& j = v.joints[v.steering[i].joint];
    const double ahead = j.anchor_V.x() - reference_x,
                 angle = std::atan2(curvature * ahead, 1 - curvature * j.anchor_V.y());
    out.steer[i] = j.axis_V.z() >= 0 ? angle : -angle;
  }
}

/// One steering angle for all kingpins: that of a bicycle.
void steer_by_angle(const VehicleSpec& v, double angle, Command& out) {
  steer_by_curvature(v, std::tan(angle) / std::max(1e-9, v.wheelbase()), out);
}

void rim_speeds(const VehicleSpec& v, double left, double right, Command& out) {
  for (std::size_t i = 0; i < v.wheels.size(); ++i)
    out.wheels[i] = {WheelCommand::Mode::speed, (v.wheels[i].left ? left : right) / v.wheels[i].gear.radius()};
}

constexpr const char* no_steered_joint =
    "the vehicle has no steered joint; turn it by its wheels: driver type 'path', or 'open_loop' with 'left' and "
    "'right'";

class OpenLoop final : public Driver {
 public:
  struct Row {
    double time = 0;
    std::vector<double> value;
    double steer = 0;
  };
  OpenLoop(const ConfigNode& n, const VehicleSpec& v) : v_(v) {
    bool torque = false, any_speed = false;
    for (const ConfigNode& r : n.list("table")) {
      Row row;
      row.time = r.quantity("time", "s", ranges::pause);
      if (!rows_.empty() && row.time <= rows_.back().time)
        r.error_at("time", "times of the table must rise from row to row");
      row.value.assign(v.wheels.size(), 0.0);
      int given = 0;
      if (r.has("speed")) {
        ++given;
        const double speed = r.quantity("speed", "m/s", ranges::speed);
        for (std::size_t i = 0; i < v.wheels.size(); ++i)
          row.value[i] = speed / std::max(1e-9, v.wheels[i].gear.radius());
      }
      if (r.has("left") || r.has("right")) {
        ++given;
        const double left = r.quantity("left", "rad/s", ranges::spin),
                     right = r.quantity("right", "rad/s", ranges::spin);
        for (std::size_t i = 0; i < v.wheels.size(); ++i) row.value[i] = v.wheels[i].left ? left : right;
      }
      if (r.has("wheels")) {
        ++given;
        std::vector<std::string> names;
        for (const WheelSpec& w : v.wheels) names.push_back(w.name);
        const ConfigNode wheels = r.map("wheels");
        for (const std::string& name : wheels.keys()) {
          const double speed = wheels.quantity(name, "rad/s", ranges::spin);
          const int i = index_of(name, names);
          if (i < 0)
            wheels.error_at(name, unknown_name("wheel", name, names));
          else
            row.value[i] = speed;
        }
      }
      any_speed = any_speed || given > 0;
      if (r.has("torque")) {
        ++given;
        torque = true;
        row.value.assign(v.wheels.size(), r.quantity("torque", "N m", ranges::any));
      }
      if (given != 1)
        r.error("a row of the table needs exactly one of 'speed', 'left' with 'right', 'wheels', 'torque'");
      row.steer = r.quantity_or("steer", 0.0, "rad", Range::between(-1.4, 1.4));
      if (row.steer != 0 && v.steering.empty()) r.error_at("steer", no_steered_joint);
      r.finish();
      rows_.push_back(row);
    }
    if (torque && any_speed) n.error_at("table", "rows with 'torque' and rows with speeds cannot be mixed");
    mode_ = torque ? WheelCommand::Mode::torque : WheelCommand::Mode::speed;
  }
  void command(double t, double, const VehicleView&, Command& out) override {
    stand(out);
    if (t < 0 || rows_.empty()) return;
    std::size_t i = 1;
    while (i < rows_.size() && rows_[i].time < t) ++i;
    const Row& b = rows_[std::min(i, rows_.size() - 1)];
    const Row& a = rows_[i - 1];
    const double u = b.time > a.time ? std::clamp((t - a.time) / (b.time - a.time), 0.0, 1.0) : 0.0;
    for (std::size_t k = 0; k < out.wheels.size(); ++k)
      out.wheels[k] = {mode_, a.value[k] + u * (b.value[k] - a.value[k])};
    if (!out.steer.empty()) steer_by_angle(v_, a.steer + u * (b.steer - a.steer), out);
  }
  double asked_speed() const override {
    double most = 0;
    for (const Row& r : rows_)
      for (std::size_t i = 0; i < v_.wheels.size() && mode_ == WheelCommand::Mode::speed; ++i)
        most = std::max(most, std::abs(r.value[i]) * v_.wheels[i].gear.radius());
    return most;
  }
  std::vector<Vec2> reach(double duration) const override {
    // Travel without slip; turns are covered by the margin around it.
    double turning = 0;
    for (const Row& r : rows_)
      for (std::size_t i = 0; i < v_.wheels.size(); ++i)
        turning = std::max(turning, std::abs(r.value[i] - r.value[0]) + std::abs(r.steer));
    const double fastest = mode_ == WheelCommand::Mode::torque ? 1 : asked_speed();
    const double x = fastest * duration;
    if (turning == 0) return {Vec2(0, 0), Vec2(x, 0)};
    return {Vec2(-x, -x), Vec2(x, x)};
  }

 private:
  VehicleSpec v_;
  std::vector<Row> rows_;
  WheelCommand::Mode mode_ = WheelCommand::Mode::speed;
};

/// PI on the forward speed; its output is the rim speed asked of the motors.
struct SpeedLoop {
  double target = 0, ramp = 1, kp = 0.5, ki = 0.5;
  double integral = 0;
  void read(const ConfigNode& n) {
    target = n.quantity("speed", "m/s", ranges::speed);
    ramp = n.quantity_or("ramp", 1.0, "s", ranges::duration);
    kp = n.quantity_or("proportional_gain", 0.5, "1", ranges::non_negative);
    ki = n.quantity_or("integral_gain", 1.0, "1/s", ranges::non_negative);
  }
  double rim_speed(double t, double dt, double v) {
    const double want = target * std::clamp(t / ramp, 0.0, 1.0), e = want - v;
    // At most half the target is added for slip: a stuck vehicle must not wind up.
    const double bound = 0.5 * std::abs(target);
    integral = std::clamp(integral + ki * e * dt, -bound, bound);
    return want + kp * e + integral;
  }
};

class SpeedHold final : public Driver {
 public:
  SpeedHold(const ConfigNode& n, const VehicleSpec& v) : v_(v) {
    loop_.read(n);
    steer_ = n.quantity_or("steer", 0.0, "rad", Range::between(-1.4, 1.4));
    if (steer_ != 0 && v.steering.empty()) n.error_at("steer", no_steered_joint);
  }
  void command(double t, double dt, const VehicleView& view, Command& out) override {
    stand(out);
    if (t < 0) return;
    const double rim = loop_.rim_speed(t, dt, view.speed);
    rim_speeds(v_, rim, rim, out);
    steer_by_angle(v_, steer_, out);
  }
  void traverse(State& s) override { s.field("speed_integral", loop_.integral); }
  double asked_speed() const override { return std::abs(loop_.target); }
  std::vector<Vec2> reach(double duration) const override {
    const double x = loop_.target * duration;
    if (steer_ == 0) return {Vec2(0, 0), Vec2(x, 0)};
    return {Vec2(-std::abs(x), -std::abs(x)), Vec2(std::abs(x), std::abs(x))};
  }

 private:
  VehicleSpec v_;
  SpeedLoop loop_;
  double steer_ = 0;
};

class Path final : public Driver {
 public:
  Path(const ConfigNode& n, const VehicleSpec& v, const Pose& start) : v_(v) {
    loop_.read(n);
    if (loop_.target <= 0) n.error_at("speed", "a path is driven forward: the speed must be positive");
    lookahead_ = n.quantity_or("lookahead", std::max(0.3, 1.2 * v.wheelbase()), "m", ranges::size);
    tolerance_ = n.quantity_or("tolerance", 0.5 * lookahead_, "m", ranges::size);
    turn_gain_ = n.quantity_or("turn_gain", 1.5, "1", ranges::positive);
    points_.push_back(start.p.head<2>());
    const Vec3 x = start.q * Vec3(Vec3::UnitX()), y = start.q * Vec3(Vec3::UnitY());
    for (const ConfigNode& p : n.list("waypoints")) {
      // As a list of its own: [x, y].
      const std::vector<ConfigNode> xy = p.items();
      if (xy.size() != 2) {
        p.error("a waypoint is [x, y], e.g. [2 m, 0.5 m]");
        continue;
      }
      const double a = xy[0].as_quantity("m", ranges::place), b = xy[1].as_quantity("m", ranges::place);
      relative_.push_back(Vec2(a, b));
      points_.push_back(start.p.head<2>() + a * x.head<2>() + b * y.head<2>());
    }
  }
  void command(double t, double dt, const VehicleView& view, Command& out) override {
    stand(out);
    if (t < 0 || done()) return;
    while (next_ < points_.size() && (points_[next_] - view.position).norm() < tolerance_) ++next_;
    if (done()) return;
    const Vec2 goal = goal_point(view.position);
    const Vec2 d = goal - view.position;
    const double c = std::cos(view.yaw), s = std::sin(view.yaw);
    const double ahead = c * d.x() + s * d.y(), left = -s * d.x() + c * d.y(), L2 = std::max(1e-6, d.squaredNorm());
    // A goal behind the vehicle asks for the tightest turn that the look-ahead allows.
    const double tightest = 2 / lookahead_;
    const double curvature = ahead > 0 ? std::clamp(2 * left / L2, -tightest, tightest) : std::copysign(tightest, left);
    const double rim = loop_.rim_speed(t, dt, view.speed);
    if (v_.steering.empty()) {
      const double turn = turn_gain_ * curvature * 0.5 * v_.track();
      rim_speeds(v_, rim * (1 - turn), rim * (1 + turn), out);
    } else {
      rim_speeds(v_, rim, rim, out);
      steer_by_curvature(v_, curvature, out);
    }
  }
  bool done() const override { return next_ >= points_.size(); }
  void traverse(State& s) override {
    s.field("speed_integral", loop_.integral);
    s.field("next_waypoint", next_);
  }
  double asked_speed() const override { return std::abs(loop_.target); }
  std::vector<Vec2> reach(double) const override {
    std::vector<Vec2> all = relative_;
    all.push_back(Vec2::Zero());
    return all;
  }

 private:
  /// Point of the path one look-ahead away, on the leg to the next waypoint.
  Vec2 goal_point(const Vec2& p) const {
    const Vec2 a = points_[next_ - 1], b = points_[next_], ab = b - a;
    const double length = std::max(1e-9, ab.norm());
    const double along = std::clamp((p - a).dot(ab) / length, 0.0, length);
    const Vec2 foot = a + ab * (along / length);
    const double off = (p - foot).norm();
    const double ahead = off < lookahead_ ? std::sqrt(lookahead_ * lookahead_ - off * off) : 0.0;
    return a + ab * (std::min(length, along + std::max(ahead, 0.25 * lookahead_)) / length);
  }

  VehicleSpec v_;
  SpeedLoop loop_;
  double lookahead_ = 1, tolerance_ = 0.5, turn_gain_ = 1.5;
  std::vector<Vec2> points_, relative_;
  std::size_t next_ = 1;
};

}  // namespace

std::unique_ptr<Driver> make_driver(const ConfigNode& n, const VehicleSpec& v, const Pose& start) {
  if (!n.present()) return nullptr;
  const std::size_t before = n.errors();
  const std::string type = n.choice("type", {"open_loop", "speed_hold", "path"});
  if (n.errors() != before) return nullptr;  // of a type that nobody knows nobody knows the keys
  std::unique_ptr<Driver> d;
  if (type == "speed_hold")
    d = std::make_unique<SpeedHold>(n, v);
  else if (type == "path")
    d = std::make_unique<Path>(n, v, start);
  else
    d = std::make_unique<OpenLoop>(n, v);
  n.finish();
  return d;
}

}  // namespace grouser::vehicle
