#include "sphere_averages.h"

#include <algorithm>
#include <cmath>

#include "grouser/dem/packing.h"
#include "grouser/terrain/wheel_motion.h"

namespace grouser::dem {

Averages::Averages(const AveragesSettings& s, const std::string& inputs, double radius, double width,
                   double slab)
    : set_(s), radius_(radius), width_(slab > 0 ? slab : width), slab_(slab), share_(slab > 0 ? width / slab : 1) {
  if (std::filesystem::exists(s.file))
    throw ResultsError(s.file.string() + ": is there already; averages of one case go to one file, name another");
  file_ = Recorder::create(s.file,
                           {"averages", inputs, "averages of grains and wheel", "dem.sphere", GROUSER_VERSION, 0}, 10);
  file_->set_attribute("inputs_hash", hash_text(inputs));
  file_->set_attribute("averaged_over_m", s.over);
  file_->set_attribute("every_m", s.every);
  for (const ChannelSpec& c :
       std::vector<ChannelSpec>{{"hub_position", "m", "mean over the window", "W", 3},
                                {"hub_velocity", "m/s", "mean over the window", "W", 3},
                                {"spin", "rad/s", "mean over the window", "C", 1},
                                {"force", "N", "grains on wheel, impulse over the window", "W", 3},
                                {"torque", "N m", "grains on wheel about the hub", "W", 3},
                                {"pressure", "Pa", "bins x (normal, along the rim, along the axle)", "C", 3 * kBins},
                                {"contacts", "1", "mean number of grains that touch", "", 1}})
    channels_.push_back(file_->add_channel(c));
  std::vector<double> angle;
  for (int k = 0; k < kBins; ++k) angle.push_back(-pi + 2 * pi * (k + 0.5) / kBins);
  file_->write_static({"angle", "rad", "middle of each bin, from the bottom, positive forward", "C", 1}, angle,
                      {static_cast<std::uint64_t>(kBins)});
}
Averages::~Averages() {
  try {
    file_->close();
  } catch (const std::exception&) {
  }
}

long Averages::next(double way, long left) const {
  if (!(way > 0)) return open_ ? std::min(left, kSampled) : left;
  const double to = open_ ? begin_ + set_.over : begin_, steps = std::ceil((to - path_) / way - 1e-9);
  const long wanted = steps < 1e9 ? static_cast<long>(steps) : left;
  return std::clamp(open_ ? std::min(wanted, kSampled) : wanted, 1L, left);
}

void Averages::begin(const Solver& solver) {
  open_ = true;
  samples_ = 0;
  const SurfaceReport r = solver.body(0);
  impulse_ = r.impulse;
  angular_ = r.angular_impulse;
  since_ = solver.time();
  hub_ = velocity_ = Vec3::Zero();
  spin_ = contacts_ = 0;
  pressure_.assign(3 * kBins, 0.0);
  grains_.clear();
}

void Averages::sample(const Solver& solver, const Pose& hub_W, double lx, double ly,
                      const std::function<bool(std::size_t)>& parked) {
  ++samples_;
  const Pose X = solver.pose(0);
  const Twist V = solver.twist(0);
  const Mat3 C = carrier_axes(X.q * Vec3::UnitY());
  hub_ += hub_W.p;
  velocity_ += V.v;
  spin_ += V.w.dot(C.col(1));
  const double area = radius_ * 2 * pi / kBins * width_;
  for (const BodyContact& c : solver.contacts(0)) {
    const Vec3 at = C.transpose() * c.at, f = C.transpose() * c.force;
    const double angle = std::atan2(at[0], -at[2]);
    const int bin = std::clamp(static_cast<int>((angle + pi) / (2 * pi) * kBins), 0, kBins - 1);
    const double s = std::sin(angle), k = std::cos(angle);
    double* p = pressure_.data() + 3 * bin;
    p[0] -= (f[0] * s - f[2] * k) / area;
    p[1] += (f[0] * k + f[2] * s) / area;
    p[2] += f[1] / area;
    contacts_ += 1;
  }
  const std::vector<GrainState> now = solver.grains();
  grains_.resize(now.size());
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (parked(k)) continue;
    Vec3 d = now[k].x - X.p;
    d[0] -= lx * std::round(d[0] / lx);
    d[1] -= ly * std::round(d[1] / ly);
    Sum& s = grains_[k];
    s.x += hub_W.p + d;
    s.v += now[k].v;
    s.radius = now[k].radius;
    ++s.n;
  }
}

void Averages::end(const Solver& solver, double dt) {
  const double n = samples_, span = std::max(solver.time() - since_, dt);
  const SurfaceReport r = solver.body(0);
  const Vec3 hub = hub_ / n, velocity = velocity_ / n, force = share_ * (r.impulse - impulse_) / span;
  Vec3 torque = share_ * (r.angular_impulse - angular_) / span;
  if (slab_ > 0) torque.x() = torque.z() = 0;  // lever arms along the axle are known up to whole widths only
  for (double& p : pressure_) p /= n;
  const auto put = [&](std::size_t c, std::span<const double> x) { file_->set(channels_[c], x); };
  put(0, {hub.data(), 3});
  put(1, {velocity.data(), 3});
  file_->set(channels_[2], spin_ / n);
  put(3, {force.data(), 3});
  put(4, {torque.data(), 3});
  put(5, pressure_);
  file_->set(channels_[6], contacts_ / n);
  std::vector<double> x, v, radius, number;
  for (std::size_t k = 0; k < grains_.size(); ++k) {
    const Sum& s = grains_[k];
    if (s.n != samples_) continue;
    for (int a = 0; a < 3; ++a) {
      x.push_back(s.x[a] / n);
      v.push_back(s.v[a] / n);
    }
    radius.push_back(s.radius);
    number.push_back(static_cast<double>(k));
  }
  const std::string head = "grains." + std::to_string(windows_) + ".";
  const std::uint64_t count = radius.size();
  if (count > 0) {
    file_->write_static({head + "position", "m", "mean over the window", "W", 3}, x, {count, 3});
    file_->write_static({head + "velocity", "m/s", "mean over the window", "W", 3}, v, {count, 3});
    file_->write_static({head + "radius", "m", "", "", 1}, radius, {count});
    file_->write_static({head + "number", "1", "of the grain in the solver", "", 1}, number, {count});
  }
  file_->end_frame(solver.time());
  open_ = false;
  ++windows_;
  while (begin_ < path_) begin_ += set_.every;
}

}  // namespace grouser::dem
