#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "ground_view.h"
#include "rig_case.h"
#include "visual_mesh.h"

namespace grouser::vehicle {

namespace {

const std::vector<ChannelSpec>& channel_specs() {
  static const std::vector<ChannelSpec> specs{
      {"wheel.position", "m", "wheel centre", "W", 3},
      {"wheel.orientation", "1", "unit quaternion w x y z", "W", 4},
      {"wheel.sinkage", "m", "local surface to lowest point, positive down", "", 1},
      {"wheel.sinkage_profile", "m", "undisturbed profile(x) - (z - r), dissertation eq 3.7", "", 1},
      {"wheel.slip", "1", "(r w - v)/max(|r w|, |v|)", "", 1},
      {"wheel.slip_angle", "rad", "atan(v_y/v_x)", "", 1},
      {"wheel.normal_force", "N", "soil on wheel along z", "C", 1},
      {"wheel.drawbar_pull", "N", "soil on wheel along x, positive forward", "C", 1},
      {"wheel.side_force", "N", "soil on wheel along y", "C", 1},
      {"wheel.driving_torque", "N m", "torque that the soil asks, positive when driving", "C", 1},
      {"wheel.motor_torque", "N m", "torque of the rig's motor", "C", 1},
      {"wheel.angular_speed", "rad/s", "spin", "C", 1},
      {"wheel.travel_speed", "m/s", "along x", "C", 1},
      {"wheel.entry_angle", "rad", "theta_f", "C", 1},
      {"wheel.contact_point", "m", "centre of the contact", "W", 3},
      {"wheel.force", "N", "soil on wheel", "W", 3},
      {"energy.soil_work", "J", "work of the soil on the wheel", "", 1},
      {"energy.soil_stored", "J", "recoverable energy in the soil", "", 1},
      {"energy.soil_dissipated", "J", "energy lost in the soil", "", 1}};
  return specs;
}

void write_ground(Recorder& file, const RigSpec& spec, const RigCase& c) {
  const HeldMotion held(spec, c);
  const double run = held.end() - held.settle - 0.5 * held.ramp;
  const double r = spec.wheel.outer_radius();
  const double x_a = std::min(spec.x, spec.x + held.v_x * run) - 3 * r,
               x_b = std::max(spec.x, spec.x + held.v_x * run) + 3 * r;
  const double y_a = std::min(spec.y, spec.y + held.v_y * run) - 2 * spec.wheel.width(),
               y_b = std::max(spec.y, spec.y + held.v_y * run) + 2 * spec.wheel.width();
  const double cell = std::max({r / 10, (x_b - x_a) / 400, (y_b - y_a) / 400});
  std::vector<double> xs, ys;
  for (double x = x_a; x < x_b + 0.5 * cell; x += cell) xs.push_back(x);
  for (double y = y_a; y < y_b + 0.5 * cell; y += cell) ys.push_back(y);
  write_ground_view(file, ground_view(*spec.ground, std::move(xs), std::move(ys)));
}

/// The wheel as a vehicle of one body, for the mesh that vehicles show.
void write_wheel_mesh(Recorder& file, const RunningGear& gear) {
  VehicleSpec v;
  v.links.resize(1);
  v.joints.resize(1);
  v.wheels.push_back({"wheel", 0, 0, gear});
  const VisualMesh m = visual_mesh(v, 0);
  file.write_static({"mesh.wheel.vertices", "m", "shape for the 3-D view", "B"}, m.vertices,
                    {m.vertices.size() / 3, 3});
  file.write_static({"mesh.wheel.triangles", "1", "vertex indices", ""}, m.triangles, {m.triangles.size() / 3, 3});
}

std::string assumptions_json(const std::vector<Assumption>& list) {
  nlohmann::json out = nlohmann::json::array();
  for (const Assumption& a : list)
    out.push_back({{"file", std::filesystem::path(a.file).filename().string()},
                   {"key", a.key},
                   {"value", a.value},
                   {"why", a.why}});
  return out.dump();
}

}  // namespace

std::string case_name(const RigCase& c) {
  char text[96];
  if (c.mode == RigCase::Mode::slip)
    std::snprintf(text, sizeof text, "%s, slip %g", c.group.c_str(), c.slip);
  else if (c.mode == RigCase::Mode::torque)
    std::snprintf(text, sizeof text, "%s, torque %g N m", c.group.c_str(), c.torque);
  else
    std::snprintf(text, sizeof text, "%s, digging", c.group.c_str());
  return text;
}

RigRecord::RigRecord(const RigSpec& spec, const RigCase& c, const std::filesystem::path& folder, FileLock& lock)
    : spec_(spec), case_(c), lock_(lock) {
  const HeldMotion held(spec, c);
  window_begin_ = held.end() - spec.average_over * held.run;
  frame_interval_ = 1 / spec.output_rate;
  const std::lock_guard guard(lock_);
  std::filesystem::create_directories(folder);
  RunAttributes a;
  a.kind = "rig";
  a.scenario = spec.text;
  a.title = spec.title + ": " + case_name(c);
  a.terrain = spec.model;
  a.version = GROUSER_VERSION;
  a.seed = spec.seed;
  file_ = std::make_unique<Recorder>(Recorder::create(folder / "run.h5", a));
  for (const ChannelSpec& s : channel_specs()) channels_.push_back(file_->add_channel(s));
  file_->set_attribute("effects", spec.effects);
  file_->set_attribute("bodies", "wheel");
  file_->set_attribute("wheels", "wheel");
  file_->set_attribute("ground", spec.ground->describe());
  file_->set_attribute("gravity", spec.gravity);
  file_->set_attribute("total_mass_kg", spec.mass(c));
  file_->set_attribute("assumptions", assumptions_json(spec.assumptions));
  file_->set_attribute("status", "running");
  write_ground(*file_, spec, c);
  write_wheel_mesh(*file_, spec.wheel);
}

RigRecord::~RigRecord() {
  const std::lock_guard guard(lock_);
  file_.reset();
}

void RigRecord::add(const RigSample& s, const EnergyLedger& energy) {
  const Vec3& p = s.X_WB.p;
  const double depth = spec_.ground->height(p.x(), p.y()) - (p.z() - spec_.wheel.radius());
  const double reach = 2 * spec_.wheel.outer_radius();
  if (!p.allFinite() || !s.V_WB.v.allFinite() || !s.V_WB.w.allFinite() || std::abs(depth) > reach) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "%s: the wheel is lost at t = %.4f s: z = %.4g m, eq 3.7 sinkage %.4g m, spin %.4g rad/s",
                  case_name(case_).c_str(), s.t, p.z(), depth, s.V_WB.w.y());
    throw RigError(text);
  }
  if (s.tau >= 0 && s.tau <= spec_.settle) greatest_before_ramp_ = std::max(greatest_before_ramp_, s.vertical_force);
  if (s.tau > window_begin_) {
    drawbar_.push_back(s.report.drawbar_pull);
    torque_.push_back(s.report.driving_torque);
    side_.push_back(s.report.side_force);
    normal_.push_back(s.vertical_force);
    sinkage_.push_back(s.report.sinkage);
    profile_.push_back(depth);
    spin_.push_back(s.V_WB.w.y());
    speed_.push_back(s.V_WB.v.x());
  }
  if (s.t < next_frame_ - 1e-9) return;
  next_frame_ = s.t + frame_interval_;
  const std::lock_guard guard(lock_);
  std::size_t k = 0;
  auto vector = [&](const Vec3& v) { file_->set(channels_[k++], std::span<const double>(v.data(), 3)); };
  auto scalar = [&](double v) { file_->set(channels_[k++], v); };
  const Quat& q = s.X_WB.q;
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  vector(p);
  file_->set(channels_[k++], std::span<const double>(wxyz, 4));
  scalar(s.report.sinkage);
  scalar(depth);
  scalar(s.report.slip);
  scalar(s.report.slip_angle);
  scalar(s.report.normal_force);
  scalar(s.report.drawbar_pull);
  scalar(s.report.side_force);
  scalar(s.report.driving_torque);
  scalar(s.motor_torque);
  scalar(s.V_WB.w.y());
  scalar(s.V_WB.v.x());
  scalar(s.report.entry_angle);
  vector(s.report.point_W);
  vector(s.report.force_W);
  scalar(energy.work_on_bodies);
  scalar(energy.stored);
  scalar(energy.dissipated);
  file_->end_frame(s.t);
}

void RigRecord::finish(RigRow& row, const std::string& hash) {
  const double load = case_.load, r = spec_.wheel.radius();
  // Below a tenth of the load (times the radius, of the radius) a relative drift is not asked for.
  row.drawbar_pull = series(drawbar_, 0.1 * load);
  row.driving_torque = series(torque_, 0.1 * load * r);
  row.side_force = series(side_, 0.1 * load);
  row.normal_force = series(normal_, 0.1 * load);
  row.sinkage = series(sinkage_, 0.1 * r);
  row.sinkage_profile = series(profile_, 0.1 * r);
  row.angular_speed = series(spin_, 1).mean;
  row.travel_speed = series(speed_, 1).mean;
  row.slip_symmetric = slip_of(SlipDefinition::symmetric, r, row.angular_speed, row.travel_speed);
  row.slip_rim = slip_of(SlipDefinition::rim, r, row.angular_speed, row.travel_speed);
  row.touch_down_overshoot = greatest_before_ramp_ / load - 1;
  row.end_state_hash = hash;
  const std::pair<const char*, const Series*> all[] = {
      {"drawbar_pull [N]", &row.drawbar_pull}, {"driving_torque [N m]", &row.driving_torque},
      {"side_force [N]", &row.side_force},     {"normal_force [N]", &row.normal_force},
      {"sinkage [m]", &row.sinkage},           {"sinkage_profile [m]", &row.sinkage_profile}};
  row.stationary = true;
  row.note.clear();
  for (const auto& [name, s] : all) {
    if (s->stationary) continue;
    row.stationary = false;
    char text[96];
    std::snprintf(text, sizeof text, "%s%s drifts by %.3g", row.note.empty() ? "" : "; ", name, s->drift);
    row.note += drawbar_.size() < 40 ? (row.note.empty() ? "fewer than 40 samples" : "") : text;
  }
  const std::lock_guard guard(lock_);
  file_->set_attribute("end_state_hash", hash);
  file_->set_attribute("simulated_s", row.simulated_s);
  file_->set_attribute("timing.wall_s", row.wall_s);
  file_->set_attribute("timing.terrain_s", row.terrain_s);
  file_->set_attribute("status", "finished");
  file_->close();
}

void RigRecord::warn(const std::string& what) {
  if (what.empty()) return;
  const std::lock_guard guard(lock_);
  file_->set_attribute("warnings", nlohmann::json({what}).dump());
}

void RigRecord::fail(const std::string& why) {
  const std::lock_guard guard(lock_);
  file_->set_attribute("status", "stopped: " + why);
  file_->close();
}

double touch_height(const Ground& ground, const RunningGear& gear, double x, double y) {
  const double r = gear.outer_radius(), b = 0.5 * gear.width();
  double z = ground.height(x, y) + r;
  constexpr int n = 128;
  for (int i = -n; i <= n; ++i) {
    const double d = r * i / n, up = std::sqrt(std::max(0.0, r * r - d * d));
    for (const double side : {-b, 0.0, b}) z = std::max(z, ground.height(x + d, y + side) + up);
  }
  return z;
}

}  // namespace grouser::vehicle
