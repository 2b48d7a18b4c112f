#include "grouser/vehicle/scenario.h"

#include <cmath>

#include "ground_view.h"
#include "grouser/terrain/ground_frame.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/terrain_loader.h"
#include "grouser/vehicle/vehicle_loader.h"
#include "ranges.h"
#include "simplified_gears.h"
#include "switched_effects.h"
#include "vehicle_reader.h"

namespace grouser::vehicle {

namespace {

std::string milliseconds(double s) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g ms", 1e3 * s);
  return text;
}

bool is_whole_steps(double time, double dt) {
  const double steps = time / dt, whole = std::round(steps);
  return whole >= 1 && std::abs(steps - whole) <= 1e-6 * whole;
}

/// An error at `key` when `time` is not a whole number of steps.
void want_whole_steps(const ConfigNode& n, const char* key, double time, double dt, const char* hint) {
  if (!is_whole_steps(time, dt))
    n.error_at(key, std::string("'") + key + "' must be a whole number of time steps; " + hint);
}

/// A speed that no motor of the vehicle reaches, even without load, as a line to print.
void tell_unreachable_speed(const Driver& driver, const VehicleSpec& v, std::vector<std::string>& notices) {
  double reached = 0;
  for (const WheelSpec& w : v.wheels) {
    if (w.motor < 0) continue;
    const MotorSpec& m = v.motors[w.motor];
    if (m.speed.size() == 1) return;  // one torque at any speed
    reached = std::max(reached, m.speed.back() * w.gear.radius());
  }
  const double asked = driver.asked_speed();
  if (reached == 0 || asked <= reached) return;
  char text[240];
  std::snprintf(text, sizeof text,
                "the driver asks for %.4g m/s, the motors turn the wheels at %.4g m/s at most, without any load: the "
                "vehicle stays slower; lower the speed or give the motor a longer table",
                asked, reached);
  notices.emplace_back(text);
}

constexpr const char* off_remedy = "; choose another start ('start: {x: ..., y: ...}'), or 'outside: extend'";

/// An error when the vehicle does not stand on the data of a ground that ends there.
void want_ground_under(const Scenario& s, const ConfigNode& at) {
  if (!at.present()) return;
  try {
    s.ground->height(s.start.p.x(), s.start.p.y());
  } catch (const GroundError& e) {
    return at.error(std::string("the vehicle would start where there is no ground: ") + e.what() + off_remedy);
  }
  for (const WheelSpec& w : s.vehicle.wheels) {
    const std::string off = off_ground(*s.ground, w.gear, s.start * s.vehicle.links[w.link].X_VB.p,
                                       s.start.q * s.vehicle.joints[w.joint].axis_V, 1.2);
    if (!off.empty())
      return at.error("wheel '" + w.name + "' would start where there is no ground: " + off + off_remedy);
  }
}

}  // namespace

std::unique_ptr<Terrain> Scenario::make_terrain() const {
  return grouser::make_terrain(*registry, document.root().map("terrain"), ground, gravity, overrides.terrain);
}

std::unique_ptr<Driver> Scenario::make_driver() const {
  return vehicle::make_driver(document.root().map("driver"), vehicle, start);
}

long Scenario::steps() const { return std::lround(duration / time_step); }
long Scenario::steps_per_frame() const { return std::max(1L, std::lround(1.0 / (output_rate * time_step))); }
long Scenario::steps_per_checkpoint() const { return std::max(1L, std::lround(checkpoint_every / time_step)); }

Scenario load_scenario(const std::filesystem::path& file, const Registry& registry,
                       const ScenarioOverrides& overrides) {
  Scenario s;
  s.file = file;
  s.registry = &registry;
  s.overrides = overrides;
  s.document = ConfigDocument::from_file(file);
  s.document.check();  // a file that cannot be parsed has no nodes to go on with
  const ConfigNode root = s.document.root();
  InputLog log;

  s.title = root.text("scenario");
  root.text_or("description", "");
  s.gravity = root.quantity_or("gravity", 9.81, "m/s^2", ranges::gravity);
  s.seed = root.integer_or("seed", 1, 0, 1L << 53);
  s.time_step = root.quantity_or("time_step", 1e-3, "s", {1e-6, 0.02, false, false});
  s.duration = overrides.duration ? (root.quantity("duration", "s", ranges::duration), *overrides.duration)
                                  : root.quantity("duration", "s", ranges::duration);
  if (overrides.duration && !ranges::duration.contains(*overrides.duration))
    log.error("--duration", 0, 0, "must be more than 0 s and at most 1e6 s");
  else if (overrides.duration && !is_whole_steps(*overrides.duration, s.time_step))
    log.error("--duration", 0, 0,
              "must be a whole number of the scenario's time steps of " + milliseconds(s.time_step));
  if (!overrides.duration && s.document.diagnostics().empty())
    want_whole_steps(root, "duration", s.duration, s.time_step, "give a multiple of time_step");
  const ConfigNode output = root.optional_map("output");
  s.output_rate = output.quantity_or("rate", 200.0, "1/s", ranges::rate);
  s.checkpoint_every = output.quantity_or("checkpoint_every", 1.0, "s", ranges::duration);
  if (output.present()) {
    const bool readable = s.document.diagnostics().empty();  // else a wrong time step would be blamed on these too
    if (readable && output.has("rate"))
      want_whole_steps(output, "rate", 1.0 / s.output_rate, s.time_step, "1/rate must be a multiple of time_step");
    if (readable && output.has("checkpoint_every"))
      want_whole_steps(output, "checkpoint_every", s.checkpoint_every, s.time_step, "give a multiple of time_step");
    output.finish();
  }

  const std::filesystem::path vehicle_file = root.existing_file("vehicle");
  const bool vehicle_named = std::filesystem::is_regular_file(vehicle_file);  // else the error is noted already
  const std::size_t errors_before = log.errors.size();
  if (vehicle_named) s.vehicle = load_vehicle(vehicle_file, root, log);
  if (!vehicle_named)
    for (const char* key : urdf_extras) root.node(key);
  const bool vehicle_good = vehicle_named && log.errors.size() == errors_before;

  const ConfigNode ground = root.node("ground");
  s.ground = ground.present() ? load_ground(ground, static_cast<std::uint64_t>(s.seed)) : flat_ground();
  if (!s.ground) s.ground = flat_ground();

  const ConfigNode start = root.optional_map("start");
  const double x = start.quantity_or("x", 0.0, "m", ranges::place), y = start.quantity_or("y", 0.0, "m", ranges::place);
  const double yaw = start.quantity_or("yaw", 0.0, "rad", Range::between(-100, 100));
  if (start.has("settle")) s.settle = start.quantity("settle", "s", ranges::pause);
  if (start.present()) start.finish();
  s.start.q = Quat(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  s.start.p = Vec3(x, y, 0);

  const ConfigNode terrain = root.map("terrain");
  std::unique_ptr<Terrain> trial;
  if (terrain.present()) {
    s.model = overrides.terrain.value_or(terrain.text("model"));
    try {
      trial = grouser::make_terrain(registry, terrain, s.ground, s.gravity, overrides.terrain, &s.document);
    } catch (const ConfigError& e) {
      log.errors.insert(log.errors.end(), e.diagnostics().begin(), e.diagnostics().end());
    }
  }
  // The driver's waypoints and wheel names make sense only for a vehicle that could be read.
  const ConfigNode driver = root.map("driver");
  std::unique_ptr<Driver> trial_driver;
  if (vehicle_good) trial_driver = vehicle::make_driver(driver, s.vehicle, s.start);
  root.finish();
  if (vehicle_good && s.document.diagnostics().empty()) want_ground_under(s, start.present() ? start : ground);

  log.take(s.document);
  log.check();
  s.assumptions = log.assumptions;
  // Does the model carry these wheels? Asked here, so that `check` finds it.
  for (const WheelSpec& w : s.vehicle.wheels) {
    try {
      trial->add_body({w.name, w.gear, {}});
    } catch (const TerrainError& e) {
      throw ConfigError(terrain.file(), terrain.line(), terrain.column(), e.what());
    }
  }
  s.effects = switched_effects(*trial, registry);
  if (!s.effects.empty()) s.notices.push_back("effects switched on: " + s.effects);
  tell_simplified_gears(*trial, s.vehicle.file, s.assumptions, s.notices);
  tell_unreachable_speed(*trial_driver, s.vehicle, s.notices);
  s.start.p.z() = s.ground->height(x, y);
  return s;
}

}  // namespace grouser::vehicle
