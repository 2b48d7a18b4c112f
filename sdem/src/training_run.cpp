// One training run on grains.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "grouser/dem/sphere.h"
#include "grouser/sdem/training.h"
#include "grouser/terrain/soil_points.h"
#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

namespace {

constexpr double kStep = 5e-4;    ///< [s] of the host
constexpr double kDown = 0.02;    ///< [m/s] of the wheel that is lowered
constexpr double kUp = 0.01;      ///< [m/s] of the wheel that is let go
constexpr double kRest = 0.1;     ///< [s] after it was lowered
constexpr double kRamp = 0.2;     ///< [s] to its velocity
constexpr double kClear = 0.002;  ///< [m] over the soil at the start
constexpr double kGravity = 9.81;
constexpr int kProfileEvery = 10;  ///< samples

class Training {
 public:
  Training(const TrainingPlan& p, const TrainingRun& r, const std::function<void(double)>& progress)
      : p_(p), r_(r), progress_(progress) {
    char text[400];
    std::snprintf(text, sizeof text,
                  "options: {slab: %.9g m, depth: %.9g m, relief: %.9g m, datum: 0 m, reach: %.9g m, period: [%.9g m, "
                  "%.9g m], sides: %s, seed: %d}",
                  p.slab, p.depth, p.relief, p.reach, p.period, p.slab, p.walls ? "walls" : "periodic", r.seed);
    const auto given = ConfigDocument::from_text(text, "grains");
    terrain_ = dem::sphere_model().make({p.soil, r.ground, given.root().map("options"), kGravity});
    given.check();
    terrain_->add_body({"wheel", {p.wheel, SmoothCylinder{p.radius, p.width}}, {}});
    points_ = dynamic_cast<const SoilPoints*>(terrain_.get());
  }

  TrainingRecord run() {
    at_ = Vec3(r_.start, 0, top_under(r_.start) + p_.radius + kClear);
    advance(0, 0, -kDown);  // pouring is not counted
    const std::clock_t begin = std::clock();
    profile();
    if (r_.kind == TrainingRun::Kind::press)
      press();
    else
      roll();
    record_.processor = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return std::move(record_);
  }

 private:
  /// Highest place of the ground that a wheel over x can touch, as height of its lowest point.
  double top_under(double x) const {
    double top = -1e300;
    for (int i = -60; i <= 60; ++i) {
      const double d = p_.radius * i / 60.0;
      top = std::max(top, r_.ground->height(x + d, 0) - p_.radius + std::sqrt(p_.radius * p_.radius - d * d));
    }
    return top;
  }

  /// One step at this velocity; Fz of the step is force_[2].
  void advance(double vx, double spin, double vz) {
    BodyMotion m{pose(), {}, {}, {}};
    at_ += kStep * Vec3(vx, 0, vz);
    turn_ += kStep * spin;
    m.X_WB_end = pose();
    m.V_WB_end.v = Vec3(vx, 0, vz);
    m.V_WB_end.w = Vec3(0, spin, 0);
    BodyResult r;
    terrain_->step(t_, kStep, {&m, 1}, {&r, 1});
    t_ = terrain_->time();
    force_ = r.impulse / kStep;
    stiffness_ = r.linearisation ? std::max(0.0, -r.linearisation->dF_dx(2, 2)) : 0;
    sum_ += force_;
    sum_torque_ += r.angular_impulse.y() / kStep;
    way_ += kStep * Vec3(vx, 0, vz);
    vz_ = vz;
    if (++steps_ * kStep >= p_.sample - 1e-9) sample(spin);
  }
  Pose pose() const { return {at_, Quat(Eigen::AngleAxisd(turn_, Vec3::UnitY()))}; }

  /// The same with the height free: as a host does, with the stiffness that the terrain tells it.
  void advance_free(double vx, double spin) {
    const double m = r_.load / kGravity;
    advance(vx, spin, (m * vz_ + kStep * (force_.z() - r_.load)) / (m + stiffness_ * kStep * kStep));
  }

  void sample(double spin) {
    const double n = steps_;
    const auto put = [](std::vector<float>& to, double x) { to.push_back(static_cast<float>(x)); };
    put(record_.time, t_);
    put(record_.x, at_.x());
    put(record_.z, at_.z());
    put(record_.vx, way_.x() / (n * kStep));
    put(record_.vz, way_.z() / (n * kStep));
    put(record_.spin, spin);
    put(record_.fx, sum_.x() / n);
    put(record_.fz, sum_.z() / n);
    put(record_.torque, sum_torque_ / n);
    put(record_.free, free_ ? 1 : 0);
    sum_ = way_ = Vec3::Zero();
    sum_torque_ = steps_ = 0;
    if (record_.time.size() % kProfileEvery == 0) profile();
  }

  /// Rounded to 10 um, so that files are small.
  void profile() {
    const double c = p_.column;
    const int rows = std::max(1, static_cast<int>(std::lround(p_.slab / c)));
    const double cy = p_.slab / rows;
    const std::int64_t first = static_cast<std::int64_t>(std::floor(at_.x() / c)) - TrainingRecord::kBehind;
    std::vector<double> top(static_cast<std::size_t>(TrainingRecord::kColumns * rows), -1e300);
    for (const auto& g : points_->soil_points(1000000)) {
      const double rad = g[3];
      for (auto i = static_cast<std::int64_t>(std::floor((g[0] - rad) / c)); static_cast<double>(i) * c <= g[0] + rad;
           ++i) {
        if (i < first || i >= first + TrainingRecord::kColumns) continue;
        const double dx = (static_cast<double>(i) + 0.5) * c - g[0];
        for (int j = static_cast<int>(std::floor((g[1] - rad) / cy)); j * cy <= g[1] + rad; ++j) {
          const double dy = (j + 0.5) * cy - g[1], h = rad * rad - dx * dx - dy * dy;
          if (h <= 0) continue;
          const auto at = static_cast<std::size_t>((i - first) * rows + ((j % rows) + rows) % rows);
          top[at] = std::max(top[at], g[2] + std::sqrt(h));
        }
      }
    }
    record_.profile_sample.push_back(static_cast<std::int64_t>(record_.time.size()));
    record_.profile_column.push_back(first);
    for (int i = 0; i < TrainingRecord::kColumns; ++i) {
      double sum = 0;
      int n = 0;
      for (int j = 0; j < rows; ++j)
        if (const double h = top[static_cast<std::size_t>(i * rows + j)]; h > -1e299) {
          sum += h;
          ++n;
        }
      record_.profile.push_back(2 * n < rows ? std::numeric_limits<float>::quiet_NaN()
                                             : static_cast<float>(std::round(1e5 * sum / n) / 1e5));
    }
  }

  void tell(double done) const {
    if (progress_) progress_(std::min(1.0, done));
  }

  void press() {
    for (std::size_t k = 0; k < r_.press.size(); ++k) {
      // Means over a sample decide: single grains click.
      while (mean_force() < r_.press[k]) advance(0, 0, -kUp);
      while (mean_force() > 0.02 * r_.press[k]) advance(0, 0, kUp / 4);
      tell(static_cast<double>(k + 1) / static_cast<double>(r_.press.size()));
    }
  }
  double mean_force() {
    recent_ += (force_.z() - recent_) * 0.2;
    return recent_;
  }

  double held_z(double x) const {
    const double u = 2 * pi * (x - r_.start) / r_.length;
    return r_.ground->height(x, 0) + p_.radius - r_.depth - r_.swing * (std::sin(u) + 0.5 * std::sin(2.7 * u));
  }

  void roll() {
    const bool held = r_.kind == TrainingRun::Kind::held;
    if (held) {
      while (at_.z() - kDown * kStep > held_z(r_.start)) advance(0, 0, -kDown);
    } else {
      while (force_.z() < r_.load) advance(0, 0, -kDown);
      free_ = true;
      for (int k = 0; k * kStep < kRest; ++k) advance_free(0, 0);
    }
    double ramp = 0, rest = r_.rest, way = 0;
    const double part = r_.distance / static_cast<double>(r_.slips.size());
    while (way < r_.distance) {
      const double s = r_.slips[std::min(r_.slips.size() - 1, static_cast<std::size_t>(way / part))];
      if (rest > 0 && way >= 0.5 * r_.distance) {
        rest -= kStep;
        ramp = 0;
        step_to(held, 0, 0);
        continue;
      }
      ramp = std::min(1.0, ramp + kStep / kRamp);
      const double vx = ramp * (s > 0 ? p_.speed * (1 - s) : p_.speed),
                   rim = ramp * (s > 0 ? p_.speed : p_.speed / (1 - s));
      step_to(held, vx, rim / p_.radius);
      way += vx * kStep;
      tell(way / r_.distance);
    }
  }
  void step_to(bool held, double vx, double spin) {
    if (!held) return advance_free(vx, spin);
    const double to = held_z(at_.x() + vx * kStep), most = kDown * kStep;
    advance(vx, spin, std::clamp(to - at_.z(), -most, most) / kStep);
  }

  const TrainingPlan& p_;
  const TrainingRun& r_;
  const std::function<void(double)>& progress_;
  std::unique_ptr<Terrain> terrain_;
  const SoilPoints* points_ = nullptr;
  Vec3 at_ = Vec3::Zero(), force_ = Vec3::Zero(), sum_ = Vec3::Zero(), way_ = Vec3::Zero();
  double t_ = 0, turn_ = 0, vz_ = 0, stiffness_ = 0, sum_torque_ = 0, recent_ = 0;
  int steps_ = 0;
  bool free_ = false;
  TrainingRecord record_;
};

}  // namespace

TrainingRecord simulate(const TrainingPlan& p, const TrainingRun& r, const std::function<void(double)>& progress) {
  return Training(p, r, progress).run();
}

}  // namespace grouser::sdem
