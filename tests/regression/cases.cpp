// The cases: prescribed motions of one wheel, each ended by a few numbers. Nothing here depends on the model.
#include "regression/cases.h"

#include <cmath>
#include <functional>
#include <stdexcept>

#include "grouser/terrain/loaders.h"

namespace grouser::test {

namespace {

constexpr double dt = 1e-3;
constexpr double degree = pi / 180;

struct WheelState {
  Vec3 hub = Vec3::Zero(), velocity = Vec3::Zero();
  double turn = 0, spin = 0;
};
using Path = std::function<WheelState(double)>;

class Waves : public Ground {
 public:
  double height(double x, double) const override { return 0.004 * std::sin(2 * pi * x / 0.3); }
  double resolution() const override { return 0.01; }
  std::string describe() const override { return "sinusoid, 4 mm, 0.3 m"; }
};

/// One wheel that follows a path, and what it felt.
class Run {
 public:
  Run(const Subject& subject, GroundPtr ground) {
    static const std::string folder = std::string(GROUSER_SOURCE_DIR) + "/examples";
    static const Soil soil = load_soil_file(folder + "/soils/mojave_martian_simulant.yaml");
    const RunningGear gear = load_running_gear_file(folder + "/wheels/" + subject.wheel + ".yaml");
    const ConfigDocument options = ConfigDocument::from_text(subject.options + "\n", "options.yaml");
    terrain_ =
        subject.model.make({soil, std::move(ground), subject.options.empty() ? ConfigNode{} : options.root(), 9.81});
    options.check();
    terrain_->add_body({"wheel", gear, {}});
    radius_ = gear.outer_radius();
  }
  double radius() const { return radius_; }

  void follow(const Path& path, double duration) {
    const int n = static_cast<int>(std::lround(duration / dt));
    for (int i = 0; i < n; ++i) step(path, i);
  }
  /// Follow the path until the normal force reaches `load`.
  double sinkage_at(double load, const Path& path, double longest) {
    for (int i = 0; i * dt < longest; ++i) {
      step(path, i);
      const ContactReport& b = reports_.back();
      if (b.normal_force < load) continue;
      if (i == 0) return b.sinkage;
      const ContactReport& a = reports_[reports_.size() - 2];
      return a.sinkage + (b.sinkage - a.sinkage) * (load - a.normal_force) / (b.normal_force - a.normal_force);
    }
    throw std::runtime_error(terrain_->id() + " does not carry the load of the regression cases");
  }
  const ContactReport& last() const { return reports_.back(); }
  const EnergyLedger& energy() const { return terrain_->energy(); }
  double mean(double ContactReport::*x) const {
    double s = 0;
    for (const ContactReport& r : reports_) s += r.*x;
    return s / static_cast<double>(reports_.size());
  }
  double rms(double ContactReport::*x) const {
    double s = 0;
    for (const ContactReport& r : reports_) s += r.*x * (r.*x);
    return std::sqrt(s / static_cast<double>(reports_.size()));
  }

 private:
  void step(const Path& path, int i) {
    auto pose = [](const WheelState& s) {
      return Pose{s.hub, Quat(Eigen::AngleAxisd(s.turn, Eigen::Vector3d::UnitY()))};
    };
    const WheelState a = path(i * dt), b = path((i + 1) * dt);
    const BodyMotion m{pose(a), pose(b), {b.velocity, Vec3(0, b.spin, 0)}, {}};
    BodyResult r;
    terrain_->step(i * dt, dt, {&m, 1}, {&r, 1});
    reports_.push_back(r.report);
  }

  std::unique_ptr<Terrain> terrain_;
  std::vector<ContactReport> reports_;
  double radius_ = 0;
};

std::vector<Channel> forces(const Run& run) {
  const ContactReport& c = run.last();
  const double N = std::abs(c.normal_force);
  return {{"normal_force", "N", c.normal_force, N},
          {"drawbar_pull", "N", c.drawbar_pull, N},
          {"side_force", "N", c.side_force, N},
          {"driving_torque", "N m", c.driving_torque, N * run.radius()}};
}

Case press(const Subject& model, double sinkage) {
  Run run(model, flat_ground());
  const double speed = 0.02;
  run.follow(
      [&](double t) {
        WheelState s;
        s.hub.z() = run.radius() - std::min(speed * t, sinkage);
        s.velocity.z() = speed * t < sinkage + 1e-9 ? -speed : 0;
        return s;
      },
      sinkage / speed + 0.1);
  const ContactReport& c = run.last();
  const int mm = static_cast<int>(std::lround(1000 * sinkage));
  return {"press_" + std::to_string(mm) + "mm",
          "pressed straight down at 20 mm/s to a sinkage of " + std::to_string(mm) + " mm and held for 0.1 s, no spin",
          {{"normal_force", "N", c.normal_force, std::abs(c.normal_force)}, {"sinkage", "m", c.sinkage, sinkage}}};
}

/// Sinkage [m] at which the wheel, pressed slowly on flat ground, carries `load` [N]: so that every model is asked
/// about a load that it can meet. Interpolated between two steps of 2 um.
double static_sinkage(const Subject& model, double load) {
  Run run(model, flat_ground());
  const double speed = 0.002;
  auto path = [&](double t) { return WheelState{Vec3(0, 0, run.radius() - speed * t), Vec3(0, 0, -speed), 0, 0}; };
  return run.sinkage_at(load, path, 0.5 * run.radius() / speed);
}

Case roll(const Subject& model, double sinkage, double slip, double angle, const std::string& name) {
  Run run(model, flat_ground());
  const double speed = 0.05;
  const Vec3 v(speed * std::cos(angle), speed * std::sin(angle), 0);
  const double spin = (slip >= 0 ? v.x() / (1 - slip) : v.x() * (1 + slip)) / run.radius();
  run.follow([&](double t) { return WheelState{Vec3(0, 0, run.radius() - sinkage) + t * v, v, spin * t, spin}; }, 6.0);
  char what[200];
  std::snprintf(what, sizeof what,
                "rolled 0.3 m at 50 mm/s at the static sinkage of 115 N: slip %g, slip angle %g deg; forces at the end",
                slip, angle / degree);
  return {name, what, forces(run)};
}

Case side(const Subject& model, double sinkage) {
  Run run(model, flat_ground());
  run.follow(
      [&](double t) {
        return WheelState{Vec3(0, 0.02 * t, run.radius() - sinkage), Vec3(0, 0.02, 0), 0, 0};
      },
      1.0);
  return {"side_slip",
          "locked wheel pushed 20 mm to the left at 20 mm/s at the static sinkage of 115 N; forces at the end",
          forces(run)};
}

Case shake(const Subject& model, double sinkage) {
  Run run(model, flat_ground());
  const double w = 2 * pi * 5, a = 2e-4;
  run.follow(
      [&](double t) {
        return WheelState{Vec3(a * std::sin(w * t), 0, run.radius() - sinkage), Vec3(a * w * std::cos(w * t), 0, 0), 0,
                          0};
      },
      1.0);
  const double N = run.mean(&ContactReport::normal_force), force = run.rms(&ContactReport::drawbar_pull);
  return {"standstill_shake",
          "locked wheel shaken along by 0.2 mm at 5 Hz for 1 s at the static sinkage of 115 N",
          {{"normal_force_mean", "N", N, N},
           {"drawbar_pull_rms", "N", force, N},
           {"drawbar_pull_mean", "N", run.mean(&ContactReport::drawbar_pull), N},
           {"dissipated", "J", run.energy().dissipated, run.energy().gross}}};
}

Case rough(const Subject& model) {
  Run run(model, std::make_shared<Waves>());
  const double speed = 0.3, spin = speed / 0.8 / run.radius();
  run.follow(
      [&](double t) {
        return WheelState{Vec3(speed * t, 0, run.radius() - 0.006), Vec3(speed, 0, 0), spin * t, spin};
      },
      3.0);
  const double N = run.rms(&ContactReport::normal_force);
  return {
      "rough_pass",
      "slip 0.2 over 0.9 m of a sinusoid of 4 mm and 0.3 m at 0.3 m/s, hub 6 mm below touch-down on the mean ground",
      {{"normal_force_mean", "N", run.mean(&ContactReport::normal_force), N},
       {"normal_force_rms", "N", N, N},
       {"drawbar_pull_mean", "N", run.mean(&ContactReport::drawbar_pull), N},
       {"drawbar_pull_rms", "N", run.rms(&ContactReport::drawbar_pull), N},
       {"driving_torque_mean", "N m", run.mean(&ContactReport::driving_torque), N * run.radius()},
       {"dissipated", "J", run.energy().dissipated, run.energy().gross}}};
}

}  // namespace

std::vector<Case> run_cases(const Subject& model) {
  std::vector<Case> all;
  for (const double depth : {0.002, 0.005, 0.010}) all.push_back(press(model, depth));
  const double sinkage = static_sinkage(model, 115);
  all.push_back({"static_sinkage", "pressed slowly until it carries 115 N", {{"sinkage", "m", sinkage, sinkage}}});
  const std::vector<std::pair<double, std::string>> slips{
      {-0.3, "brake_0.3"}, {0.0, "coast"}, {0.3, "drive_0.3"}, {0.7, "drive_0.7"}};
  for (const double angle : {0.0, 10.0})
    for (const auto& [slip, name] : slips)
      all.push_back(roll(model, sinkage, slip, angle * degree, name + (angle > 0 ? "_angle_10" : "")));
  all.push_back(side(model, sinkage));
  all.push_back(shake(model, sinkage));
  all.push_back(rough(model));
  return all;
}

}  // namespace grouser::test
