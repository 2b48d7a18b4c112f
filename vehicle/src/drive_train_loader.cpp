// Motors, battery, steering, differential and running gear: the same keys in a vehicle file and, for URDF, in a
// scenario.
#include <cmath>

#include "grouser/terrain/loaders.h"
#include "ranges.h"
#include "vehicle_reader.h"

namespace grouser::vehicle {

namespace {

MotorSpec read_motor(const ConfigNode& n, std::string name) {
  MotorSpec m;
  m.name = std::move(name);
  if (n.has("table")) {
    for (const ConfigNode& row : n.list("table")) {
      m.speed.push_back(row.quantity("speed", "rad/s", Range{0, 1e6, false, false}));
      m.torque.push_back(row.quantity("torque", "N m", ranges::non_negative));
      if (m.speed.size() > 1 && m.speed.back() <= m.speed[m.speed.size() - 2])
        row.error_at("speed", "speeds of a motor table must rise from row to row");
      row.finish();
    }
    if (!m.speed.empty() && m.speed.front() != 0)
      n.error_at("table", "the first row of a motor table must have speed 0 rad/s (stall)");
  } else {
    const double stall = n.quantity("stall_torque", "N m", ranges::positive);
    const double free = n.quantity("no_load_speed", "rad/s", Range{0, 1e6, true, false});
    m.speed = {0.0, free};
    m.torque = {stall, 0.0};
  }
  m.efficiency = n.quantity_or("efficiency", 1.0, "1", {0.0, 1.0, true, false});
  m.regeneration = n.quantity_or("regeneration", 0.0, "1", Range::between(0, 1));
  m.speed_gain = n.quantity("speed_gain", "N m s/rad", ranges::positive);
  m.angle_gain = n.quantity_or("angle_gain", 0.0, "N m/rad", ranges::non_negative);
  n.finish();
  return m;
}

}  // namespace

void read_motors(const ConfigNode& root, VehicleSpec& v) {
  const ConfigNode motors = root.optional_map("motors");
  if (!motors.present()) return;
  for (const std::string& name : motors.keys()) v.motors.push_back(read_motor(motors.map(name), name));
}

int read_wheel_motor(const ConfigNode& wheel, VehicleSpec& v) {
  const ConfigNode n = wheel.node("motor");
  if (!n.present()) return -1;
  if (n.is_map()) {
    v.motors.push_back(read_motor(n, n.path()));
    return static_cast<int>(v.motors.size()) - 1;
  }
  std::vector<std::string> names;
  for (const MotorSpec& m : v.motors) names.push_back(m.name);
  const int i = index_of(n.as_text(), names);
  if (i < 0) wheel.error_at("motor", unknown_name("motor", n.as_text(), names));
  return i;
}

RunningGear read_gear(const ConfigNode& wheel, std::map<std::string, RunningGear>& cache, InputLog& log) {
  const std::filesystem::path file = wheel.existing_file("wheel");
  if (!std::filesystem::is_regular_file(file)) return {};  // noted already
  const auto known = cache.find(file.string());
  if (known != cache.end()) return known->second;
  const ConfigDocument doc = ConfigDocument::from_file(file);
  RunningGear g;
  if (doc.diagnostics().empty()) g = load_running_gear(doc.root());
  log.take(doc);
  return cache.emplace(file.string(), g).first->second;
}

void read_drive_train(const ConfigNode& root, VehicleSpec& v) {
  const std::vector<std::string> joints = joint_names(v);
  auto joint_of = [&](const ConfigNode& n, const std::string& key) {
    const std::string name = n.text(key);
    const int i = index_of(name, joints);
    if (i < 0 && !name.empty()) n.error_at(key, unknown_name("joint", name, joints));
    return i;
  };
  if (const ConfigNode b = root.optional_map("battery"); b.present()) {
    v.battery_capacity = b.quantity("capacity", "J", ranges::positive);
    b.finish();
  }
  if (const ConfigNode s = root.optional_map("steering"); s.present()) {
    SteerSpec common;
    common.max_angle = s.quantity("max_angle", "rad", {0.0, 1.4, true, false});
    common.gain = s.quantity("gain", "N m/rad", ranges::positive);
    common.damping = s.quantity("damping", "N m s/rad", ranges::non_negative);
    common.max_torque = s.quantity("max_torque", "N m", ranges::positive);
    for (const ConfigNode& item : s.list("joints")) {
      const int i = index_of(item.as_text(), joints);
      if (i < 0) {
        item.error(unknown_name("joint", item.as_text(), joints));
      } else if (v.joints[i].type != JointSpec::Type::revolute) {
        item.error("joint '" + joints[i] + "' is not revolute: only a revolute joint can steer");
      } else {
        common.joint = i;
        v.steering.push_back(common);
      }
    }
    s.finish();
  }
  if (const ConfigNode d = root.optional_map("differential"); d.present()) {
    DifferentialSpec x;
    x.joint_a = joint_of(d, "joint_a");
    x.joint_b = joint_of(d, "joint_b");
    x.stiffness = d.quantity("stiffness", "N m/rad", ranges::positive);
    x.damping = d.quantity("damping", "N m s/rad", ranges::non_negative);
    if (x.joint_a >= 0 && x.joint_b >= 0) {
      if (v.joints[x.joint_a].parent != v.joints[x.joint_b].parent)
        d.error("the two joints of a differential must have the same parent (the chassis)");
      // q measured about opposite axes: the mean is then the difference.
      x.sign = v.joints[x.joint_a].axis_V.dot(v.joints[x.joint_b].axis_V) > 0 ? 1.0 : -1.0;
      v.differential = x;
    }
    d.finish();
  }
}

}  // namespace grouser::vehicle
