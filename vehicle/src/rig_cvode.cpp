// The rig as an initial-value problem: height, vertical speed and, torque-driven, spin. Nothing of Bullet or the adapter is used.
#include <chrono>
#include <cmath>

#include "grouser/vehicle/ode.h"
#include "rig_case.h"

namespace grouser::vehicle {

namespace {

enum { Z, VZ, ANGLE, SPIN, SIZE };

/// The force law between two commits: the terrain remembers what it had at t0, and is asked about trial motions from there.
class Wheel {
 public:
  Wheel(const RigSpec& spec, const RigCase& c, Terrain& terrain, double mass, double inertia)
      : held_(spec, c),
        terrain_(terrain),
        mass_(mass),
        inertia_(inertia),
        load_(c.load),
        dt_(spec.time_step),
        torque_driven_(c.mode == RigCase::Mode::torque),
        lowering_speed_(spec.lowering_speed) {}

  bool lowering = false;
  double touched = 0;  ///< [s] time of touch-down: the clock of the held motion starts there

  BodyMotion motion(double t, std::span<const double> y) const {
    const double tau = t - touched, share = lowering ? 0 : held_.share(tau), far = lowering ? 0 : held_.travelled(tau);
    BodyMotion m;
    m.X_WB_begin = committed_;
    const double angle = torque_driven_ ? y[ANGLE] : held_.w * far;
    m.X_WB_end = {{held_.x0 + held_.v_x * far, held_.y0 + held_.v_y * far, y[Z]},
                  Quat(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()))};
    m.V_WB_end.v = {held_.v_x * share, held_.v_y * share, lowering ? -lowering_speed_ : y[VZ]};
    m.V_WB_end.w = {0, torque_driven_ ? y[SPIN] : held_.w * share, 0};
    return m;
  }

  Wrench wrench(double t, std::span<const double> y) {
    // A model may divide by dt: never ask for less than a millionth of the step between commits.
    const double dt = std::max(t - time_, 1e-6 * dt_);
    const BodyMotion m = motion(t, y);
    terrain_.preview(time_, dt, {&m, 1}, {&result_, 1});
    return {result_.impulse / dt, result_.angular_impulse / dt};
  }

  void rhs(double t, std::span<const double> y, std::span<double> dy) {
    if (lowering) {
      std::fill(dy.begin(), dy.end(), 0.0);
      dy[Z] = -lowering_speed_;
      return;
    }
    const Wrench f = wrench(t, y);
    dy[Z] = y[VZ];
    dy[VZ] = (f.f.z() - load_) / mass_;
    dy[ANGLE] = torque_driven_ ? y[SPIN] : 0;
    dy[SPIN] = torque_driven_ ? (f.t.y() + held_.torque * held_.share(t - touched)) / inertia_ : 0;
  }

  /// Advance the terrain's memory to t and take the answer for the record.
  RigSample commit(double t, std::span<const double> y) {
    const double dt = t - time_;
    const BodyMotion m = motion(t, y);
    terrain_.step(time_, dt, {&m, 1}, {&result_, 1});
    RigSample s;
    s.t = t;
    s.tau = lowering ? -1 : t - touched;
    s.X_WB = m.X_WB_end;
    s.V_WB = m.V_WB_end;
    s.report = result_.report;
    s.vertical_force = result_.impulse.z() / dt;
    s.motor_torque = torque_driven_ ? held_.torque * held_.share(s.tau) : s.report.driving_torque;
    committed_ = m.X_WB_end;
    time_ = t;
    return s;
  }

  void start(const Pose& p) { committed_ = p; }
  double end() const { return touched + held_.end(); }
  double load() const { return load_; }

 private:
  HeldMotion held_;
  Terrain& terrain_;
  double mass_, inertia_, load_, dt_;
  bool torque_driven_;
  double lowering_speed_;
  double time_ = 0;
  Pose committed_;
  BodyResult result_;
};

}  // namespace

std::string run_cvode(const CaseContext& x, RigRow& row) {
  const RigSpec& spec = x.spec;
  const double r = spec.wheel.outer_radius(), mass = spec.mass(x.c);
  const auto terrain = x.make_terrain();
  terrain->add_body({"wheel", spec.wheel, Pose()});
  Wheel wheel(spec, x.c, *terrain, mass, spec.spin_inertia.value_or(0.5 * mass * r * r));
  wheel.lowering = spec.lower;
  const double z0 = spec.lower ? touch_height(*spec.ground, spec.wheel, spec.x, spec.y) + 1e-4 : start_height(x);
  std::vector<double> y(SIZE, 0.0);
  y[Z] = z0;
  wheel.start({{spec.x, spec.y, z0}, Quat::Identity()});

  OdeOptions options;
  options.relative = 1e-8;
  options.absolute = {1e-9 * r, 1e-9, 1e-8, 1e-8};
  Ode ode(
      0, y, [&](double t, auto state, auto dy) { wheel.rhs(t, state, dy); }, options);
  // Root 0: the wheel leaves or meets the undisturbed ground. Root 1, while lowering: the soil carries the load.
  ode.watch(2, [&](double t, std::span<const double> state, std::span<double> g) {
    const Vec3 p = wheel.motion(t, state).X_WB_end.p;
    g[0] = state[Z] - touch_height(*spec.ground, spec.wheel, p.x(), p.y());
    g[1] = wheel.lowering ? wheel.wrench(t, state).f.z() - wheel.load() : 1.0;
  });

  const double give_up = spec.settle + 4 * r / spec.lowering_speed;
  double told = 0, committed = 0;
  for (long i = 1; wheel.lowering || committed < wheel.end() - 1e-9 * spec.time_step; ++i) {
    const double next = committed + spec.time_step;
    bool released = false;
    while (ode.advance(next) == Ode::Stop::root) {
      released = wheel.lowering && ode.crossings()[1] > 0;
      if (released) break;
      ode.restart(ode.time(), ode.state());  // the force has a kink here
    }
    if (ode.time() > committed) x.record.add(wheel.commit(ode.time(), ode.state()), terrain->energy());
    committed = ode.time();
    if (released) {
      wheel.lowering = false;
      wheel.touched = committed;
      ode.restart(committed, ode.state());  // from rest: lowering holds the speed outside of the state
    }
    if (wheel.lowering && committed > give_up)
      throw RigError(case_name(x.c) + ": lowered for " + std::to_string(committed) + " s without finding the load of " +
                     std::to_string(x.c.load) + " N");
    if (i % 256 == 0) {
      x.progress(committed - told);
      told = committed;
    }
  }
  x.progress(committed - told);
  row.simulated_s = committed;
  State end;
  terrain->traverse(end);
  end.field("height", y[Z] = ode.state()[Z]);
  return end.hash_text();
}

}  // namespace grouser::vehicle
