#include <cmath>

#include "ranges.h"
#include "vehicle_reader.h"

namespace grouser::vehicle {

namespace {

Range range_of(std::string_view unit) { return unit == "kg m^2" ? ranges::inertia : ranges::offset; }

Vec3 vec3(const ConfigNode& n, const std::string& key, std::string_view unit, const Vec3& fallback = Vec3::Zero()) {
  if (!n.has(key)) return fallback;
  const std::vector<double> x = n.quantities(key, unit, 3, range_of(unit));
  return x.size() == 3 ? Vec3(x[0], x[1], x[2]) : fallback;
}

Vec3 required_vec3(const ConfigNode& n, const std::string& key, std::string_view unit) {
  const std::vector<double> x = n.quantities(key, unit, 3, range_of(unit));
  return x.size() == 3 ? Vec3(x[0], x[1], x[2]) : Vec3(Vec3::Zero());
}

Quat from_rpy(const Vec3& a) {
  return Quat(Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()));
}

/// inertia: {box: [x, y, z]} | {cylinder: {radius, length}} (axis y) | {moments: [Ixx, Iyy, Izz], products: [Ixy, Ixz,
/// Iyz]} The solid shape is also what the 3-D view shows unless `visual:` says otherwise.
void read_inertia(const ConfigNode& body, LinkSpec& l) {
  const ConfigNode n = body.map("inertia");
  if (!n.present()) return;
  if (n.has("box")) {
    const Vec3 s = required_vec3(n, "box", "m");
    if ((s.array() <= 0).any()) n.error_at("box", "the three lengths of a box must be positive");
    l.inertia = box_inertia(l.mass, s);
    l.visuals.push_back({Visual::Kind::box, s, {}});
  } else if (n.has("cylinder")) {
    const ConfigNode c = n.map("cylinder");
    const double r = c.quantity("radius", "m", ranges::size), length = c.quantity("length", "m", ranges::size);
    l.inertia = cylinder_inertia(l.mass, r, length);
    l.visuals.push_back({Visual::Kind::cylinder, Vec3(r, length, 0), {}});
    c.finish();
  } else if (n.has("moments")) {
    const Vec3 m = required_vec3(n, "moments", "kg m^2"), p = vec3(n, "products", "kg m^2");
    l.inertia << m.x(), p.x(), p.y(), p.x(), m.y(), p.z(), p.y(), p.z(), m.z();
  } else {
    n.error("inertia needs one of 'box', 'cylinder', 'moments', e.g. inertia: {box: [0.6 m, 0.4 m, 0.2 m]}");
  }
  n.finish();
}

void read_visuals(const ConfigNode& body, LinkSpec& l) {
  if (!body.has("visual")) return;
  l.visuals.clear();
  const ConfigNode all = body.node("visual");
  for (const ConfigNode& n : all.is_list() ? all.items() : std::vector<ConfigNode>{all}) {
    Visual s;
    if (n.has("cylinder")) {
      const ConfigNode c = n.map("cylinder");
      s.kind = Visual::Kind::cylinder;
      s.size = Vec3(c.quantity("radius", "m", ranges::size), c.quantity("length", "m", ranges::size), 0);
      c.finish();
    } else {
      s.size = required_vec3(n, "box", "m");
    }
    s.X_BS = {vec3(n, "offset", "m"), from_rpy(vec3(n, "rotation", "rad"))};
    n.finish();
    l.visuals.push_back(s);
  }
}

void read_joint_forces(const ConfigNode& n, JointSpec& j) {
  const bool turn = j.type == JointSpec::Type::revolute;
  const char* x = turn ? "rad" : "m";
  const char* k = turn ? "N m/rad" : "N/m";
  const char* c = turn ? "N m s/rad" : "N s/m";
  if (const ConfigNode s = n.optional_map("spring"); s.present()) {
    j.stiffness = s.quantity("stiffness", k, ranges::positive);
    if (s.has("preload")) {
      // Force of the spring in the design pose, positive when it pushes q upward.
      j.rest = s.quantity("preload", turn ? "N m" : "N", ranges::any) / (j.stiffness > 0 ? j.stiffness : 1.0);
    } else {
      j.rest = s.quantity_or("rest", 0.0, x, ranges::offset);
    }
    s.finish();
  }
  j.damping = n.quantity_or("damping", 0.0, c, ranges::non_negative);
  if (const ConfigNode s = n.optional_map("stops"); s.present()) {
    StopSpec stop;
    stop.lower = s.quantity("lower", x, ranges::offset);
    stop.upper = s.quantity("upper", x, ranges::offset);
    stop.stiffness = s.quantity("stiffness", k, ranges::positive);
    stop.damping = s.quantity_or("damping", 0.0, c, ranges::non_negative);
    if (s.has("lower") && s.has("upper") && !(stop.lower < stop.upper))
      s.error("'lower' of the stops must be below 'upper'");
    s.finish();
    j.stops = stop;
  }
}

Place place_of(const ConfigNode& n) { return {n.file(), n.line(), n.column()}; }

int link_of(const ConfigNode& n, const std::string& key, const VehicleSpec& v) {
  const std::string name = n.text(key);
  const int i = index_of(name, link_names(v));
  if (i < 0 && !name.empty()) n.error_at(key, unknown_name("body", name, link_names(v)));
  return i;
}

/// A wheel is a body and an axle in one entry.
void read_wheel(const std::string& name, const ConfigNode& n, ReadVehicle& r, std::map<std::string, RunningGear>& gears,
                InputLog& log) {
  VehicleSpec& v = r.spec;
  WheelSpec w;
  w.name = name;
  w.gear = read_gear(n, gears, log);
  LinkSpec l;
  l.name = name;
  l.mass = n.quantity("mass", "kg", ranges::mass);
  l.X_VB.p = required_vec3(n, "position", "m");
  if (n.has("inertia")) {
    read_inertia(n, l);
    l.visuals.clear();
  } else {
    l.inertia = cylinder_inertia(l.mass, w.gear.radius(), w.gear.width());
  }
  JointSpec j;
  j.name = name + "_axle";
  j.parent = link_of(n, "carrier", v);
  j.damping = n.quantity_or("bearing_damping", 0.0, "N m s/rad", ranges::non_negative);
  j.anchor_V = l.X_VB.p;
  w.motor = read_wheel_motor(n, v);
  w.left = l.X_VB.p.y() > 0;
  n.finish();
  if (index_of(name, link_names(v)) >= 0) {
    n.error("wheel '" + name + "' has the name of a body");
    return;
  }
  j.child = w.link = static_cast<int>(v.links.size());
  v.links.push_back(l);
  r.link_place.push_back(place_of(n));
  if (j.parent < 0) return;
  w.joint = static_cast<int>(v.joints.size());
  v.joints.push_back(j);
  r.joint_place.push_back(place_of(n));
  r.fixed.push_back(false);
  v.wheels.push_back(std::move(w));
}

}  // namespace

void read_yaml_vehicle(const ConfigNode& root, ReadVehicle& r, InputLog& log) {
  VehicleSpec& v = r.spec;
  v.name = root.text("vehicle");
  root.text_or("source", "");
  const ConfigNode bodies = root.map("bodies");
  for (const std::string& name : bodies.keys()) {
    const ConfigNode n = bodies.map(name);
    LinkSpec l;
    l.name = name;
    l.mass = n.quantity("mass", "kg", ranges::mass);
    l.X_VB = {vec3(n, "position", "m"), from_rpy(vec3(n, "rotation", "rad"))};
    read_inertia(n, l);
    read_visuals(n, l);
    n.finish();
    v.links.push_back(std::move(l));
    r.link_place.push_back(place_of(n));
  }
  if (const ConfigNode joints = root.optional_map("joints"); joints.present())
    for (const std::string& name : joints.keys()) {
      const ConfigNode n = joints.map(name);
      JointSpec j;
      j.name = name;
      const std::string type = n.choice("type", {"revolute", "prismatic", "fixed"});
      j.type = type == "prismatic" ? JointSpec::Type::prismatic : JointSpec::Type::revolute;
      j.parent = link_of(n, "parent", v);
      j.child = link_of(n, "child", v);
      if (type != "fixed") {
        j.anchor_V = required_vec3(n, "anchor", "m");
        const std::vector<double> a = n.quantities("axis", "1", 3, ranges::any);
        if (a.size() == 3) {
          j.axis_V = Vec3(a[0], a[1], a[2]);
          if (j.axis_V.norm() < 1e-9)
            n.error_at("axis", "the axis must not be zero");
          else
            j.axis_V.normalize();
        }
        read_joint_forces(n, j);
      }
      n.finish();
      if (j.parent < 0 || j.child < 0) continue;
      v.joints.push_back(j);
      r.joint_place.push_back(place_of(n));
      r.fixed.push_back(type == "fixed");
    }
  read_motors(root, v);
  std::map<std::string, RunningGear> gears;
  const ConfigNode wheels = root.map("wheels");
  for (const std::string& name : wheels.keys()) read_wheel(name, wheels.map(name), r, gears, log);
  read_drive_train(root, v);
  root.finish();
}

}  // namespace grouser::vehicle
