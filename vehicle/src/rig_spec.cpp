#include "grouser/vehicle/rig_spec.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "ground_view.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/terrain_loader.h"
#include "ranges.h"
#include "simplified_gears.h"
#include "switched_effects.h"

namespace grouser::vehicle {

namespace {

std::string short_number(double x, const char* unit) {
  char buf[48];
  std::snprintf(buf, sizeof buf, "%.6g %s", x, unit);
  return buf;
}

std::string load_text(double load) {
  char buf[32];
  std::snprintf(buf, sizeof buf, "%.4g N", load);
  return buf;
}

/// Keep the text of a file that the rig file names.
void keep_text(RigSpec& rig, const std::filesystem::path& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  rig.text += "\n---\n# " + path.filename().string() + "\n" + text.str();
}

RunningGear read_wheel(RigSpec& rig, const ConfigNode& root) {
  const std::filesystem::path path = root.existing_file("wheel");
  if (!std::filesystem::is_regular_file(path)) return {};
  const ConfigDocument doc = ConfigDocument::from_file(path);
  RunningGear gear = load_running_gear(doc.root());
  rig.document.absorb(doc);
  keep_text(rig, path);
  return gear;
}

std::vector<SlipDefinition> read_definitions(const ConfigNode& root) {
  std::vector<SlipDefinition> out;
  auto one = [&](const ConfigNode& n) {
    const std::string t = n.as_text();
    if (t == "rim")
      out.push_back(SlipDefinition::rim);
    else if (t == "symmetric")
      out.push_back(SlipDefinition::symmetric);
    else
      n.error("'" + t + "' is no slip definition; known here: rim, symmetric");
  };
  const ConfigNode n = root.node("slip_definition");
  if (n.is_list())
    for (const ConfigNode& i : n.items()) one(i);
  else if (n.present())
    one(n);
  else
    root.error(
        "missing key 'slip_definition': rim is (r w - v)/(r w) for both signs, symmetric divides by the larger of |r "
        "w| and |v|; for example 'slip_definition: symmetric'");
  return out;
}

/// What the cases share before they are multiplied out.
struct Sweep {
  std::vector<double> loads;
  std::optional<double> angular_speed, travel_speed, distance, duration;
  double slip_angle = 0;
};

void set_run_time(RigCase& c, const Sweep& s) {
  c.run_time = s.duration.value_or(std::numeric_limits<double>::infinity());
  if (s.distance && c.travel_speed != 0) c.run_time = std::min(c.run_time, *s.distance / std::abs(c.travel_speed));
}

void add_case(RigSpec& rig, RigCase c, const Sweep& s) {
  c.index = static_cast<int>(rig.cases.size());
  c.slip_angle = s.slip_angle;
  set_run_time(c, s);
  rig.cases.push_back(std::move(c));
}

void read_slip_cases(RigSpec& rig, const ConfigNode& root, const Sweep& s, const std::vector<double>& other) {
  const std::size_t before = root.errors();
  std::vector<double> slips = root.quantities("slips", "1", 0, {-1e3, 1.0, false, false});
  const bool slips_read = root.errors() == before;
  if (!other.empty()) slips = other;
  const auto definitions = read_definitions(root);
  const double radius = root.quantity_or("slip_radius", rig.wheel.radius(), "m", ranges::size);
  const auto wrong_slip = [&](const std::string& message) {
    if (other.empty())
      root.error_at("slips", message);
    else
      root.report({"--slips", 0, 0, message});
  };
  if (s.angular_speed.has_value() == s.travel_speed.has_value())
    root.error(
        "exactly one of 'angular_speed' (for example 17 deg/s) and 'travel_speed' (for example 10 mm/s) is wanted");
  if (!s.distance && !s.duration)
    root.error("one of 'distance' (for example 0.7 m) and 'duration' (for example 20 s) is wanted");
  // Without slips, a radius and a speed there is nothing to check; what is missing is noted already.
  if (!slips_read || !(radius > 0) || s.angular_speed.has_value() == s.travel_speed.has_value()) return;
  for (const double load : s.loads)
    for (const SlipDefinition d : definitions)
      for (const double slip : slips) {
        RigCase c;
        c.load = load;
        c.group = load_text(load) + ", " + std::string(slip_definition_name(d));
        c.slip = slip;
        c.definition = d;
        try {
          c.angular_speed =
              s.angular_speed ? *s.angular_speed : angular_speed_for(d, radius, slip, s.travel_speed.value_or(0));
          c.travel_speed =
              s.angular_speed ? travel_speed_for(d, radius, slip, *s.angular_speed) : s.travel_speed.value_or(0);
        } catch (const std::invalid_argument& e) {
          if (load == s.loads.front())  // once, whatever the number of loads
            wrong_slip(short_number(slip, "") + "by the definition '" + std::string(slip_definition_name(d)) +
                       "': " + e.what());
        }
        if (!s.duration && s.distance && c.travel_speed == 0 && load == s.loads.front())
          wrong_slip(short_number(slip, "") +
                     "means no travel, so the rig file's 'distance' never ends the case: give it a 'duration' too");
        if (!s.duration && s.distance && *s.distance > ranges::duration.upper * std::abs(c.travel_speed) &&
            c.travel_speed != 0 && load == s.loads.front())
          wrong_slip(short_number(slip, "") + "means a travel of " +
                     short_number(*s.distance / std::abs(c.travel_speed), "s") +
                     " over the rig file's 'distance', allowed is 1e6 s: give it a 'duration' too");
        add_case(rig, c, s);
      }
}

void read_torque_cases(RigSpec& rig, const ConfigNode& root, const Sweep& s) {
  const std::vector<double> torques = root.quantities("torque", "N m", 0, ranges::any);
  if (s.angular_speed || !s.travel_speed)
    root.error(
        "with 'torque' the wheel turns freely: give 'travel_speed' (for example 10 mm/s) and no 'angular_speed'");
  if (!s.distance && !s.duration)
    root.error("one of 'distance' (for example 0.7 m) and 'duration' (for example 20 s) is wanted");
  for (const double load : s.loads)
    for (const double torque : torques) {
      RigCase c;
      c.mode = RigCase::Mode::torque;
      c.load = load;
      c.group = load_text(load);
      c.slip = std::numeric_limits<double>::quiet_NaN();
      c.travel_speed = s.travel_speed.value_or(0);
      c.torque = torque;
      add_case(rig, c, s);
    }
}

void read_dig_cases(RigSpec& rig, const ConfigNode& root, const Sweep& s) {
  if (!s.angular_speed || s.travel_speed || s.distance)
    root.error(
        "mode 'dig' stands still: give 'angular_speed' (for example 0.3 rad/s) and no 'travel_speed' or 'distance'");
  if (!s.duration) root.error("missing key 'duration'; for example 'duration: 10 s'");
  for (const double load : s.loads) {
    RigCase c;
    c.mode = RigCase::Mode::dig;
    c.load = load;
    c.group = load_text(load);
    c.slip = 1;
    c.angular_speed = s.angular_speed.value_or(0);
    add_case(rig, c, s);
  }
}

Sweep read_sweep(RigSpec& rig, const ConfigNode& root) {
  Sweep s;
  if (root.has("load") == root.has("mass"))
    root.error(
        "exactly one of 'load' (for example 115 N, the wheel's weight included) and 'mass' (for example 8.155 kg) is "
        "wanted");
  if (root.has("load")) {
    s.loads = root.quantities("load", "N", 0, ranges::load);
    rig.moving_mass = root.optional_quantity("moving_mass", "kg", ranges::mass);
  } else if (root.has("mass")) {
    rig.moving_mass = root.quantity("mass", "kg", ranges::mass);
    s.loads = {*rig.moving_mass * rig.gravity};
  } else {
    root.node("moving_mass");  // known, and no second error
  }
  s.angular_speed = root.optional_quantity("angular_speed", "rad/s", ranges::spin);
  s.travel_speed = root.optional_quantity("travel_speed", "m/s", ranges::speed);
  s.distance = root.optional_quantity("distance", "m", Range{0, 1e6, true, false});
  s.duration = root.optional_quantity("duration", "s", ranges::duration);
  s.slip_angle = root.quantity_or("slip_angle", 0, "rad", Range::between(-1.4, 1.4));
  return s;
}

}  // namespace

std::unique_ptr<Terrain> RigSpec::make_bare_terrain(const Registry& registry) const {
  auto terrain = grouser::make_terrain(registry, terrain_map, ground, gravity, model_override, &document);
  document.check();
  return terrain;
}

std::unique_ptr<Terrain> RigSpec::make_terrain(const Registry& registry) const {
  auto terrain = make_bare_terrain(registry);
  terrain->add_body({"wheel", wheel, Pose()});
  return terrain;
}

RigSpec load_rig(const std::filesystem::path& yaml, const Registry& registry, const std::optional<std::string>& terrain,
                 const std::vector<double>& slips) {
  RigSpec rig;
  rig.document = ConfigDocument::from_file(yaml);
  rig.text = rig.document.text();
  const ConfigNode root = rig.document.root();
  if (!root.present()) rig.document.check();

  rig.title = root.text("rig");
  rig.source = root.text_or("source", "");
  rig.gravity = root.quantity_or("gravity", 9.81, "m/s^2", ranges::gravity);
  rig.seed = root.integer_or("seed", 1, 0, 1L << 53);
  rig.wheel = read_wheel(rig, root);
  rig.ground = load_ground(root.node("ground"), static_cast<std::uint64_t>(rig.seed));
  rig.terrain_map = root.map("terrain");
  rig.model_override = terrain;
  auto built = grouser::make_terrain(registry, rig.terrain_map, rig.ground, rig.gravity, terrain, &rig.document);
  if (built) keep_text(rig, rig.terrain_map.existing_file("soil"));

  rig.time_step = root.quantity_or("time_step", 1e-3, "s", {1e-6, 0.1, false, false});
  rig.settle = root.quantity_or("settle", 0.5, "s", ranges::pause);
  rig.ramp = root.quantity_or("ramp", 1.0, "s", ranges::pause);
  rig.average_over = root.quantity_or("average_over", 0.5, "1", {0, 1, true, false});
  rig.spin_inertia = root.optional_quantity("spin_inertia", "kg m^2", ranges::positive);
  const ConfigNode start = root.optional_map("start");
  rig.x = start.quantity_or("x", 0, "m", ranges::place);
  rig.y = start.quantity_or("y", 0, "m", ranges::place);
  start.finish();
  const ConfigNode touch = root.optional_map("touch_down");
  rig.lower = touch.choice_or("by", "trim", {"trim", "lowering"}) == "lowering";
  rig.lowering_speed = touch.quantity_or("speed", 0.01, "m/s", Range{0, 100, true, false});
  touch.finish();
  const ConfigNode output = root.optional_map("output");
  rig.output_rate = output.quantity_or("rate", 50, "Hz", ranges::rate);
  output.finish();

  const Sweep sweep = read_sweep(rig, root);
  const bool dig = root.choice_or("mode", "sweep", {"sweep", "dig"}) == "dig";
  if (dig)
    read_dig_cases(rig, root, sweep);
  else if (root.has("torque"))
    read_torque_cases(rig, root, sweep);
  else
    read_slip_cases(rig, root, sweep, slips);
  if (!slips.empty() && (dig || root.has("torque")))
    root.report({"--slips", 0, 0,
                 std::string("this rig imposes no slip but ") + (dig ? "digs on the spot" : "a torque") +
                     "; leave the option out, or use a rig file with 'slips'"});
  if (rig.ground && root.errors() == 0)
    if (const std::string off = off_ground(*rig.ground, rig.wheel, {rig.x, rig.y, 0}, Vec3::UnitY(), 1.2); !off.empty())
      (start.present() ? start : root.node("ground"))
          .error("the wheel would start where there is no ground: " + off +
                 "; choose another start ('start: {x: ..., y: ...}'), or 'outside: extend'");
  if (const ConfigNode m = root.optional_map("measured"); m.present()) rig.measured = load_rig_measured(m);
  root.finish();
  rig.document.check();

  // The model sees the wheel: whatever it refuses belongs to the file's errors.
  const ConfigNode& t = rig.terrain_map;
  try {
    built->add_body({"wheel", rig.wheel, Pose()});
  } catch (const TerrainError& e) {
    throw ConfigError(t.file(), t.line(), t.column(), e.what());
  }
  rig.model = built->id();
  rig.effects = switched_effects(*built, registry);
  if (!rig.effects.empty()) rig.notices.push_back("effects switched on: " + rig.effects);
  if (!rig.lower && !built->capabilities().continuous)
    throw ConfigError(
        t.file(), t.line(), t.column(),
        "terrain '" + rig.model + "' has no static equilibrium to start from: write 'touch_down: {by: lowering}'");
  rig.assumptions = rig.document.assumptions();
  tell_simplified_gears(*built, yaml.string(), rig.assumptions, rig.notices);
  return rig;
}

}  // namespace grouser::vehicle
