#include <algorithm>
#include <cmath>
#include <cstdio>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

namespace {

/// Two walls that carry one pressure. Their speed follows the error and its integral; `gain` [m/s per Pa] makes the pressure
/// of an elastic sample follow in `follow` [s].
class Servo {
 public:
  Servo(double gain, double follow, double limit) : gain_(gain), slow_(2 * follow), limit_(limit) {}
  /// Speed outwards after `dt` with this mean pressure [Pa] in place of the aim.
  double speed(double pressure, double aim, double dt) {
    const double error = pressure - aim, next = sum_ + error * dt / slow_, v = gain_ * (error + next);
    // At its limit the integral waits.
    if (std::fabs(v) < limit_) sum_ = next;
    return std::clamp(v, -limit_, limit_);
  }
  void traverse(State& s) { s.field("servo", sum_); }

 private:
  double gain_, slow_, limit_, sum_ = 0;
};

class Triaxial final : public SoilTest {
 public:
  Triaxial(const SoilSettings& soil, const Packing& bed, const TriaxialSettings& test) : test_(test) {
    table_.columns = {"axial_strain", "volumetric_strain",      "deviator_Pa", "axial_Pa",
                      "confining_Pa", "mobilised_friction_deg", "void_ratio"};
    double top = 0, mass = 0;
    for (const GrainState& g : bed.grains) {
      top = std::max(top, g.x[2] + g.radius);
      const double v = 4.0 / 3 * pi * g.radius * g.radius * g.radius;
      solid_ += v;
      mass += g.density * v;
    }
    SolverSettings s = solver_settings(soil);
    s.gravity = Vec3::Zero();
    s.ledger = test.ledger;
    const double room = 0.5 * test.side;
    s.domain.lo = Vec3(-room, -room, -0.02);
    s.domain.hi = Vec3(test.side + room, test.side + room, top + 0.05);
    s.domain.periodic = {false, false, false};
    solver_ = std::make_unique<Solver>(s, bed.grains);
    interval_ = std::max(1L, std::lround(1e-4 / soil.dt));
    const Vec3 far(test.side, test.side, top + 1e-5);
    for (int k = 0; k < 3; ++k)
      for (int end = 0; end < 2; ++end) {
        BodySettings b;
        if (end == 1) b.X_WB.p[k] = far[k];
        wall_[k][end] = solver_->add_body(b);
        solver_->add_plane(wall_[k][end], Vec3::Zero(), (end == 1 ? -1 : 1) * Vec3::Unit(k), 1);
      }
    // Stiffness of the sample as of a random packing of smooth spheres (Walton 1987: K = 0.42 (p E*^2)^(1/3) at 0.6 solid and six
    // contacts), half as much again for one-sided compression. The walls follow in twice the time of sound through it.
    const Material& m = soil.materials.materials[0];
    const double modulus = 0.63 * std::cbrt(test.pressure * std::pow(m.young / (2 * (1 - m.poisson * m.poisson)), 2));
    const double density = mass / (test.side * test.side * top), sound = std::sqrt(modulus / density);
    for (int k = 0; k < 3; ++k) {
      const double follow = 2 * far[k] / sound, gain = far[k] / (modulus * follow);
      // Both sides move, or the lid alone.
      servo_.emplace_back(k < 2 ? gain / 2 : gain, follow, test.wall_speed);
    }
  }

  bool advance() override {
    if (complete()) return false;
    if (resting_) {
      press();
    } else {
      sample();
    }
    return !complete();
  }

  double left() const override {
    const double shear = test_.strain / test_.strain_rate;
    return resting_ ? std::max(0.0, test_.rest - spent_) + shear
                    : shear * (1 - static_cast<double>(table_.rows.size()) / test_.samples);
  }

  std::vector<std::pair<std::string, double>> notes() const override {
    std::vector<std::pair<std::string, double>> out{{"pressing_s", spent_},     {"height_m", start_[2]},
                                                    {"width_x_m", start_[0]},   {"width_y_m", start_[1]},
                                                    {"pressed_x_Pa", held_[0]}, {"pressed_y_Pa", held_[1]},
                                                    {"pressed_z_Pa", held_[2]}, {"confining_worst_share", worst_}};
    if (test_.ledger) {
      const Ledger l = solver_->ledger();
      out.emplace_back("work_J", l.bodies);
      out.emplace_back("ledger_residual_J", l.residual());
    }
    return out;
  }

 protected:
  void own_state(State& s) override {
    s.field("resting", resting_);
    s.field("spent", spent_);
    s.field("held_twice", held_twice_);
    s.field("start", start_);
    s.field("held", held_);
    s.field("worst", worst_);
    for (Servo& v : servo_) v.traverse(s);
  }

 private:
  bool complete() const { return static_cast<int>(table_.rows.size()) == test_.samples; }
  Vec3 size() const {
    Vec3 out;
    for (int k = 0; k < 3; ++k) out[k] = solver_->pose(wall_[k][1]).p[k] - solver_->pose(wall_[k][0]).p[k];
    return out;
  }
  /// Outward impulse of each pair, half of the two together [N s].
  Vec3 impulses() const {
    Vec3 out;
    for (int k = 0; k < 3; ++k)
      out[k] = 0.5 * (solver_->body(wall_[k][1]).impulse[k] - solver_->body(wall_[k][0]).impulse[k]);
    return out;
  }
  static Vec3 areas(const Vec3& size) { return {size[1] * size[2], size[0] * size[2], size[0] * size[1]}; }
  void set_wall(int k, int end, double speed) {
    Twist V;
    V.v[k] = speed;
    solver_->set_motion(wall_[k][end], V);
  }

  /// One interval of control; the mean pressures [Pa]. `lid`: speed downwards, or the servo when below zero.
  Vec3 control(double lid) {
    const Vec3 before = impulses(), a = areas(size());
    const double t = solver_->time();
    solver_->step(interval_);
    const double dt = solver_->time() - t;
    const Vec3 p = (impulses() - before).cwiseQuotient(a) / dt;
    for (int k = 0; k < 3; ++k) {
      if (k == 2 && lid >= 0) {
        set_wall(2, 1, -lid);
        continue;
      }
      const double v = servo_[static_cast<std::size_t>(k)].speed(p[k], test_.pressure, dt);
      set_wall(k, 1, v);
      if (k < 2) set_wall(k, 0, -v);
    }
    return p;
  }

  /// 20 ms under the same pressure on all sides.
  void press() {
    const long n = std::max(1L, std::lround(0.02 / (solver_->time_step() * static_cast<double>(interval_))));
    held_ = Vec3::Zero();
    const double t = solver_->time();
    for (long k = 0; k < n; ++k) held_ += control(-1) / static_cast<double>(n);
    spent_ += solver_->time() - t;
    const bool held = (held_ / test_.pressure - Vec3::Ones()).cwiseAbs().maxCoeff() < kHeld,
               quiet = rms_speed(solver_->grains()) < test_.rest_speed;
    const bool at_rest = held && quiet && held_twice_, late = spent_ >= test_.rest;
    held_twice_ = held && quiet;
    if (late && !held) {
      char text[250];
      std::snprintf(
          text, sizeof text,
          "triaxial: after %.3g s the walls carry %.4g, %.4g and %.4g Pa along x, y and z instead of %.4g Pa; allow a "
          "longer 'rest' or a faster 'wall_speed'",
          spent_, held_[0], held_[1], held_[2], test_.pressure);
      throw DemError(text);
    }
    if (!at_rest && !late) return;
    resting_ = false;
    start_ = size();
    set_wall(2, 1, -test_.strain_rate * start_[2]);
  }

  void sample() {
    const double lid = test_.strain_rate * start_[2], length = test_.strain / test_.strain_rate / test_.samples;
    // Samples end at whole intervals of control; the last one ends with the strain asked for.
    const double due = (static_cast<double>(table_.rows.size()) + 1) * length * lid;
    Vec3 p = Vec3::Zero();
    double n = 0;
    const double one = solver_->time_step() * static_cast<double>(interval_) * lid;
    do {
      p += control(lid);
      ++n;
    } while (start_[2] - size()[2] + 0.5 * one < due);
    p /= n;
    const Vec3 now = size();
    const double confining = 0.5 * (p[0] + p[1]), deviator = p[2] - confining, volume = now.prod() / start_.prod();
    for (int k = 0; k < 2; ++k) worst_ = std::max(worst_, std::fabs(p[k] / test_.pressure - 1));
    table_.rows.push_back({1 - now[2] / start_[2], 1 - volume, deviator, p[2], confining,
                           std::asin(std::clamp(deviator / (p[2] + confining), -1.0, 1.0)) * 180 / pi,
                           now.prod() / solid_ - 1});
  }

  static constexpr double kHeld = 0.01;  ///< of the pressure, mean of 20 ms
  TriaxialSettings test_;
  double solid_ = 0, spent_ = 0, worst_ = 0;
  long interval_ = 1;
  bool resting_ = true, held_twice_ = false;
  int wall_[3][2] = {};
  std::vector<Servo> servo_;
  Vec3 start_ = Vec3::Zero(), held_ = Vec3::Zero();
};

}  // namespace

PourSettings pour_settings(const TriaxialSettings& t) {
  PourSettings p;
  p.lx = p.ly = t.side;
  p.height = t.height;
  p.walls = true;
  return p;
}

std::unique_ptr<SoilTest> make_triaxial(const SoilSettings& soil, const Packing& bed, const TriaxialSettings& test) {
  if (!(test.side > 0 && test.height > 0 && test.pressure > 0 && test.strain_rate > 0 && test.wall_speed > 0 &&
        test.rest > 0 && test.rest_speed >= 0))
    throw DemError("triaxial: side, height, pressure, strain_rate, wall_speed and rest must be positive");
  if (!(test.strain > 0 && test.strain <= 0.5)) throw DemError("triaxial: strain must be above 0 and at most 0.5");
  if (test.wall_speed < test.strain_rate * test.height) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "triaxial: side walls at %.3g m/s cannot follow a lid that moves at %.3g m/s; a faster wall_speed or a "
        "lower strain_rate is needed",
        test.wall_speed, test.strain_rate * test.height);
    throw DemError(text);
  }
  if (test.samples < 1) throw DemError("triaxial: at least one sample");
  if (!bed.walls || bed.lx != test.side || bed.ly != test.side)
    throw DemError("triaxial: the packing must have been poured into a box as wide as the test");
  return std::make_unique<Triaxial>(soil, bed, test);
}

}  // namespace grouser::dem
