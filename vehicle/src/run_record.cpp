#include "run_record.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ground_view.h"
#include "grouser/terrain/soil_points.h"
#include "visual_mesh.h"

namespace grouser::vehicle {

namespace {

struct Named {
  const char *name, *unit, *description;
};
constexpr Named vehicle_channels[] = {{"speed", "m/s", "velocity of the chassis along its heading"},
                                      {"distance", "m", "horizontal distance travelled by the chassis"},
                                      {"roll", "rad", "about x, positive left side up"},
                                      {"pitch", "rad", "about y, positive nose down"},
                                      {"yaw", "rad", "about z, positive to the left"},
                                      {"vertical_acceleration", "m/s^2", "of the chassis origin, mean over the frame"},
                                      {"power", "W", "mechanical power of all motors, mean over the frame"},
                                      {"motor_energy", "J", "mechanical work of all motors"},
                                      {"battery_energy", "J", "energy taken from the battery"}};
constexpr Named energy_channels[] = {
    {"motor", "J", "work of drive and steering motors"},
    {"kinetic", "J", "kinetic energy"},
    {"potential", "J", "potential energy of gravity, relative to the start"},
    {"spring", "J", "energy stored in springs and stops"},
    {"damper", "J", "energy lost in dampers, stops and bearings"},
    {"soil_work", "J", "work of the terrain's impulses on the wheels, terrain's own account"},
    {"soil_stored", "J", "recoverable energy in the soil, relative to the start"},
    {"soil_dissipated", "J", "energy dissipated in the soil"},
    {"implicit_correction", "J", "work of the implicit correction of the soil impulses"},
    {"integration", "J", "error of the time step in vehicle and soil, from its own formulas"},
    {"joints", "J", "work of the joint constraints"},
    {"residual", "J", "what does not close"}};

std::string join(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& n : names) all += (all.empty() ? "" : ",") + n;
  return all;
}

void write_ground(Recorder& rec, const Scenario& s, const Driver& driver) {
  // Box around what the driver means to drive over.
  double lo[2] = {1e30, 1e30}, hi[2] = {-1e30, -1e30};
  const double size = 0.6 * std::max(s.vehicle.wheelbase(), s.vehicle.track()) + 0.6;
  for (const Vec2& p : driver.reach(s.duration)) {
    const Vec3 w = s.start * Vec3(p.x(), p.y(), 0);
    for (int k = 0; k < 2; ++k) {
      lo[k] = std::min(lo[k], w[k] - size);
      hi[k] = std::max(hi[k], w[k] + size);
    }
  }
  constexpr double most = 60000;  // cells: enough to see, small enough for the report
  double step = std::min(0.05, 0.1 * s.vehicle.wheelbase());
  step = std::max(step, std::sqrt((hi[0] - lo[0]) * (hi[1] - lo[1]) / most));
  std::vector<double> axis[2];
  for (int k = 0; k < 2; ++k) {
    const int n = std::max(2, static_cast<int>((hi[k] - lo[k]) / step) + 1);
    for (int i = 0; i < n; ++i) axis[k].push_back(lo[k] + i * step);
  }
  write_ground_view(rec, ground_view(*s.ground, std::move(axis[0]), std::move(axis[1])));
}

}  // namespace

void RunTotals::traverse(State& s) {
  auto g = s.group("run");
  s.field("step", step);
  s.field("distance", distance);
  s.field("drift", drift);
  s.field("frame_vertical_speed", frame_vertical_speed);
  s.field("frame_motor", frame_motor);
  s.field("soil_work_0", soil_0.work_on_bodies);
  s.field("soil_stored_0", soil_0.stored);
  s.field("soil_dissipated_0", soil_0.dissipated);
  s.field("soil_external_0", soil_0.external);
  s.field("soil_integration_0", soil_0.integration);
}

Attitude attitude(const Quat& q) {
  const Mat3 R = q.toRotationMatrix();
  return {std::atan2(R(2, 1), R(2, 2)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)), std::atan2(R(1, 0), R(0, 0))};
}

VehicleView view_of(const VehicleWorld& w) {
  const Pose X = w.pose(0);
  VehicleView v;
  v.position = X.p.head<2>();
  v.yaw = attitude(X.q).yaw;
  const Vec3 velocity = w.twist(0).v;
  v.speed = velocity.x() * std::cos(v.yaw) + velocity.y() * std::sin(v.yaw);
  return v;
}

double total_residual(const VehicleEnergy& e, const EnergyLedger& soil, const EnergyLedger& soil_0) {
  return e.residual() - (soil.residual() - soil_0.residual());
}

RunRecord RunRecord::create(const std::filesystem::path& file, const Scenario& s, const std::string& text,
                            const Driver& driver) {
  RunAttributes a;
  a.kind = "run";
  a.scenario = text;
  a.title = s.title;
  a.terrain = s.model;
  a.version = GROUSER_VERSION;
  a.seed = s.seed;
  RunRecord r(Recorder::create(file, a, 200));
  Recorder& rec = r.recorder_;
  const VehicleSpec& v = s.vehicle;

  r.add_channels(v);
  std::vector<std::string> bodies, wheels;
  for (const LinkSpec& l : v.links) bodies.push_back(l.name);
  for (const WheelSpec& w : v.wheels) wheels.push_back(w.name);
  write_ground(rec, s, driver);
  for (std::size_t i = 0; i < v.links.size(); ++i) {
    const VisualMesh m = visual_mesh(v, static_cast<int>(i));
    if (m.triangles.empty()) continue;
    rec.write_static({"mesh." + v.links[i].name + ".vertices", "m", "shape for the 3-D view", "B"}, m.vertices,
                     {m.vertices.size() / 3, 3});
    rec.write_static({"mesh." + v.links[i].name + ".triangles", "1", "vertex indices", ""}, m.triangles,
                     {m.triangles.size() / 3, 3});
  }
  nlohmann::json assumed = nlohmann::json::array();
  for (const Assumption& x : s.assumptions)
    assumed.push_back({{"file", std::filesystem::path(x.file).filename().string()},
                       {"key", x.key},
                       {"value", x.value},
                       {"why", x.why}});
  rec.set_attribute("assumptions", assumed.dump());
  rec.set_attribute("effects", s.effects);
  rec.set_attribute("bodies", join(bodies));
  rec.set_attribute("wheels", join(wheels));
  rec.set_attribute("ground", s.ground->describe());
  rec.set_attribute("gravity", s.gravity);
  rec.set_attribute("total_mass_kg", v.total_mass());
  rec.set_attribute("status", "running");
  return r;
}

RunRecord RunRecord::resume(const std::filesystem::path& file, const Scenario& s, std::uint64_t frames) {
  RunRecord r(Recorder::resume(file, frames, 200));
  r.add_channels(s.vehicle);
  r.recorder_.set_attribute("status", "running");
  return r;
}

void RunRecord::add_channels(const VehicleSpec& v) {
  Recorder& rec = recorder_;
  for (const LinkSpec& l : v.links) {
    BodyChannels c;
    c.position = rec.add_channel({l.name + ".position", "m", "centre of mass", "W", 3});
    c.orientation = rec.add_channel({l.name + ".orientation", "1", "quaternion w x y z, body to world", "W", 4});
    bodies_.push_back(c);
  }
  for (const WheelSpec& w : v.wheels) {
    auto add = [&](const char* name, const char* unit, const char* description, const char* frame, int components = 1) {
      return rec.add_channel({w.name + "." + name, unit, description, frame, components});
    };
    WheelChannels c;
    c.sinkage = add("sinkage", "m", "below the local soil surface, positive down", "C");
    c.slip = add("slip", "1", "(r w - v)/max(|r w|, |v|), positive driving", "C");
    c.slip_angle = add("slip_angle", "rad", "slip angle", "C");
    c.normal = add("normal_force", "N", "soil on wheel, along z_C", "C");
    c.drawbar = add("drawbar_pull", "N", "soil on wheel, along x_C, positive forward", "C");
    c.side = add("side_force", "N", "soil on wheel, along y_C", "C");
    c.torque = add("driving_torque", "N m", "asked of the motor by the soil", "C");
    c.motor_torque = add("motor_torque", "N m", "given by the motor", "C");
    c.speed = add("angular_speed", "rad/s", "of the wheel relative to its carrier", "C");
    c.entry = add("entry_angle", "rad", "angle from the vertical to first contact", "C");
    c.point = add("contact_point", "m", "centre of the contact; lowest point of the wheel when clear", "W", 3);
    c.force = add("force", "N", "soil on wheel as applied, mean over the last step", "W", 3);
    wheels_.push_back(c);
  }
  for (const Named& n : vehicle_channels)
    vehicle_.push_back(rec.add_channel({std::string("vehicle.") + n.name, n.unit, n.description, "W"}));
  for (const Named& n : energy_channels)
    energy_.push_back(rec.add_channel({std::string("energy.") + n.name, n.unit, n.description, ""}));
  drift_ = rec.add_channel({"joint.drift", "m", "largest gap of joined points", ""});
}

void RunRecord::frame(double t, double frame_dt, const VehicleWorld& w, const EnergyLedger& soil, RunTotals& totals) {
  const VehicleSpec& v = w.spec();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Pose X = w.pose(static_cast<int>(i));
    const double q[4] = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    recorder_.set(bodies_[i].position, std::span<const double>(X.p.data(), 3));
    recorder_.set(bodies_[i].orientation, std::span<const double>(q, 4));
  }
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    const int k = static_cast<int>(i);
    const WheelChannels& c = wheels_[i];
    const ContactReport& r = w.contact(k);
    recorder_.set(c.sinkage, r.sinkage);
    recorder_.set(c.slip, r.slip);
    recorder_.set(c.slip_angle, r.slip_angle);
    recorder_.set(c.normal, r.normal_force);
    recorder_.set(c.drawbar, r.drawbar_pull);
    recorder_.set(c.side, r.side_force);
    recorder_.set(c.torque, r.driving_torque);
    recorder_.set(c.motor_torque, w.motor_torque(k));
    recorder_.set(c.speed, w.joint_speed(v.wheels[i].joint));
    recorder_.set(c.entry, r.entry_angle);
    const Vec3 point =
        r.in_contact ? r.point_W : Vec3(w.pose(v.wheels[i].link).p - v.wheels[i].gear.outer_radius() * Vec3::UnitZ());
    const Vec3 force = w.soil_force(k);
    recorder_.set(c.point, std::span<const double>(point.data(), 3));
    recorder_.set(c.force, std::span<const double>(force.data(), 3));
  }
  const Attitude a = attitude(w.pose(0).q);
  const VehicleEnergy& e = w.energy();
  const double vz = w.twist(0).v.z();
  const bool first = totals.step == 0;
  const double vehicle[] = {view_of(w).speed,
                            totals.distance,
                            a.roll,
                            a.pitch,
                            a.yaw,
                            first ? 0.0 : (vz - totals.frame_vertical_speed) / frame_dt,
                            first ? 0.0 : (e.motor - totals.frame_motor) / frame_dt,
                            e.motor,
                            e.battery};
  totals.frame_vertical_speed = vz;
  totals.frame_motor = e.motor;
  for (std::size_t i = 0; i < vehicle_.size(); ++i) recorder_.set(vehicle_[i], vehicle[i]);
  const double energy[] = {e.motor,
                           e.kinetic,
                           e.potential,
                           e.spring,
                           e.damper,
                           e.soil_work,
                           soil.stored - totals.soil_0.stored,
                           soil.dissipated - totals.soil_0.dissipated,
                           e.implicit,
                           e.integration - (soil.integration - totals.soil_0.integration),
                           e.joints,
                           total_residual(e, soil, totals.soil_0)};
  for (std::size_t i = 0; i < energy_.size(); ++i) recorder_.set(energy_[i], energy[i]);
  recorder_.set(drift_, w.joint_drift());
  recorder_.end_frame(t);
}

void RunRecord::points(double t, Terrain& terrain) {
  const auto* soil = dynamic_cast<const SoilPoints*>(&terrain);
  constexpr std::uint64_t every = 4;  // frames
  constexpr std::size_t most = 3000;  // grains
  const std::uint64_t frame = recorder_.frames() - 1;
  if (!soil || frame % every != 0) return;
  std::vector<double> x;
  // To be looked at: seven digits, whose zeros cost nothing in the file.
  for (const auto& p : soil->soil_points(most))
    for (const double v : p) x.push_back(static_cast<double>(static_cast<float>(v)));
  if (x.empty()) return;
  const std::string name = "points." + std::to_string(frame);
  recorder_.write_static({name, "m", "grains near the wheels: x, y, z, radius", "W", 4}, x, {x.size() / 4, 4});
  recorder_.write_static({name + ".time", "s", "of these grains", "", 1}, {&t, 1}, {1});
  std::vector<double> cells;
  for (const Cell& c : terrain.take_changed_cells()) cells.insert(cells.end(), {c.x, c.y, c.size, -c.sinkage});
  if (cells.empty()) return;
  const std::string changed = "surface." + std::to_string(frame);
  recorder_.write_static(
      {changed, "m", "squares of the surface that changed since the last set: x, y, side, rise over undisturbed ground",
       "W", 4},
      cells, {cells.size() / 4, 4});
  recorder_.write_static({changed + ".time", "s", "of these squares", "", 1}, {&t, 1}, {1});
}

}  // namespace grouser::vehicle
