#include "dem_case.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "grouser/dem/packing.h"
#include "grouser/dem/soil_config.h"
#include "grouser/terrain/csv.h"
#include "grouser/terrain/mesh_file.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;

Vec3 vector(const ConfigNode& n, const char* key, const char* unit, const Vec3& fallback = Vec3::Zero(),
            bool required = false, Range range = Range::any()) {
  if (!required && !n.has(key)) return fallback;
  const std::vector<double> v = n.quantities(key, unit, 3, range);
  return v.size() == 3 ? Vec3(v[0], v[1], v[2]) : fallback;
}

int material_number(const ConfigNode& n, const std::string& key, const std::vector<std::string>& names) {
  const std::string name = n.choice(key, names);
  return std::max(0, static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin()));
}

void read_domain(const ConfigNode& n, dem::Domain& d) {
  d.lo = vector(n, "lower", "m", d.lo, true);
  d.hi = vector(n, "upper", "m", d.hi, true);
  d.periodic = {false, false, false};
  for (const ConfigNode& p : n.optional_list("periodic")) {
    const std::string axis = p.as_text();
    if (axis == "x" || axis == "y")
      d.periodic[axis == "y"] = true;
    else
      p.error("'" + axis + "' cannot be periodic; x and y can");
  }
  if (n.has("lower") && n.has("upper") && !((d.hi - d.lo).minCoeff() > 0))
    n.error("upper must be above lower on every axis");
  n.finish();
}

void read_materials(const ConfigNode& root, DemCase& c) {
  dem::MaterialTable& t = c.solver.materials;
  t.materials.clear();
  for (const ConfigNode& n : root.list("materials")) {
    dem::Material m;
    m.name = n.text("name");
    m.young = n.quantity("young_modulus", "Pa", Range::positive());
    m.poisson = n.quantity("poisson_ratio", "1", {0, 0.5, false, true});
    n.finish();
    if (std::find(c.materials.begin(), c.materials.end(), m.name) != c.materials.end())
      n.error_at("name", "material '" + m.name + "' was described already");
    c.materials.push_back(m.name);
    t.materials.push_back(m);
  }
  const std::size_t count = t.materials.size();
  if (count > 5) root.error_at("materials", fmt::format("{} materials; at most 5", count));
  t.pairs.assign(count * (count + 1) / 2, {});
}

void read_pairs(const ConfigNode& root, DemCase& c) {
  dem::MaterialTable& t = c.solver.materials;
  const bool rate = c.solver.law.rolling != dem::RollingCoefficient::constant,
             ch3 = c.solver.law.model == dem::ContactModel::hertz_ch3;
  std::set<std::pair<int, int>> seen;
  for (const ConfigNode& n : root.list("pairs")) {
    std::vector<int> of;
    for (const ConfigNode& name : n.list("of")) {
      const std::string m = name.as_text();
      const auto at = std::find(c.materials.begin(), c.materials.end(), m);
      if (at == c.materials.end()) {
        const auto near = did_you_mean(m, c.materials);
        name.error("there is no material '" + m + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
      } else {
        of.push_back(static_cast<int>(at - c.materials.begin()));
      }
    }
    dem::PairProperties p;
    p.friction = n.quantity("friction", "1", Range::non_negative());
    p.restitution = n.quantity("restitution", "1", {0, 1, true, false});
    p.rolling = n.quantity("rolling_coefficient", rate ? "s^2/m^2" : "1", Range::non_negative());
    p.cohesion = n.quantity_or("cohesion", 0, "J/m^3", Range::non_negative());
    if (ch3) {
      p.kn = n.quantity("normal_stiffness", "Pa", Range::positive());
      p.kt = n.quantity("shear_stiffness", "Pa", Range::non_negative());
      p.gamma_n = n.quantity("gamma_n", "1/(m s)", Range::non_negative());
      p.gamma_t = n.quantity("gamma_t", "1/(m s)", Range::non_negative());
    }
    n.finish();
    if (of.size() != 2) {
      if (n.has("of")) n.error_at("of", "two materials are wanted: [soil, wheel]");
      continue;
    }
    const std::pair<int, int> key = std::minmax(of[0], of[1]);
    if (!seen.insert(key).second) n.error_at("of", "this pair was described already");
    t.pair(key.first, key.second) = p;
  }
  const int count = static_cast<int>(c.materials.size());
  for (int a = 0; a < count; ++a)
    for (int b = a; b < count; ++b)
      // Grains of every material meet each other; what only bodies are made of meets no other body.
      if (!seen.count({a, b}) &&
          (a == 0 || std::any_of(c.grains.begin(), c.grains.end(),
                                 [&](const dem::GrainState& g) { return g.material == a || g.material == b; })))
        root.error_at("pairs", fmt::format("the pair [{}, {}] is missing", c.materials[static_cast<std::size_t>(a)],
                                           c.materials[static_cast<std::size_t>(b)]));
}

void read_sphere_file(const ConfigNode& n, DemBody::Surface& s) {
  const fs::path file = n.existing_file("file");
  if (file.empty()) return;
  FileErrors errors(file);
  const NumberTable t = read_numbers(file, {"x", "y", "z", "radius"}, {}, errors);
  for (std::size_t k = 0; k < t.rows.size(); ++k) {
    const auto& r = t.rows[k];
    if (!(r[3] > 0)) errors.add(t.lines[k], 1, "the radius must be positive");
    s.centres.push_back(Vec3(r[0], r[1], r[2]));
    s.radii.push_back(r[3]);
  }
  errors.report_to(n);
}

void read_mesh_file(const ConfigNode& n, DemBody::Surface& s) {
  const fs::path file = n.existing_file("file");
  const double scale = n.quantity_or("scale", 1, "1", Range::positive());
  if (file.empty()) return;
  std::vector<Diagnostic> faults;
  const TriangleMesh m = read_mesh(file, scale, faults);
  for (Diagnostic& d : faults) n.report(std::move(d));
  s.mesh.vertices = m.vertices;
  s.mesh.triangles = m.triangles;
}

void read_surface(const ConfigNode& n, DemBody& b, int material) {
  using Kind = DemBody::Surface::Kind;
  DemBody::Surface s;
  s.material = material;
  const std::size_t before = n.errors();
  if (n.has("plane")) {
    const ConfigNode p = n.map("plane");
    s.point = vector(p, "point", "m", Vec3::Zero());
    s.normal = vector(p, "normal", "1", Vec3::UnitZ(), true);
    if (s.normal.norm() == 0) p.error_at("normal", "a normal cannot be zero");
    p.finish();
  } else if (n.has("box")) {
    const ConfigNode p = n.map("box");
    const Vec3 size = vector(p, "size", "m", Vec3::Ones(), true, Range::positive());
    const std::string open = p.choice_or("open", "no", {"no", "top", "bottom", "both"});
    s.kind = Kind::mesh;
    s.solid = open == "no";
    s.mesh = dem::box_mesh(size, open == "top" || open == "both", open == "bottom" || open == "both");
    p.finish();
  } else if (n.has("rectangle")) {
    const std::vector<double> d = n.quantities("rectangle", "m", 2, Range::positive());
    s.kind = Kind::mesh;
    if (d.size() == 2) s.mesh = dem::plate_mesh(d[0], d[1]);
  } else if (n.has("mesh")) {
    const ConfigNode p = n.map("mesh");
    s.kind = Kind::mesh;
    s.solid = true;
    read_mesh_file(p, s);
    p.finish();
  } else if (n.has("wheel")) {
    const ConfigNode p = n.map("wheel");
    s.kind = Kind::mesh;
    s.solid = true;
    const double r = p.quantity("radius", "m", Range::positive()), w = p.quantity("width", "m", Range::positive());
    const int segments = static_cast<int>(p.integer_or("segments", 60, 8, 10000)),
              lugs = static_cast<int>(p.integer_or("lugs", 0, 0, 1000));
    const double h = lugs ? p.quantity("lug_height", "m", Range::positive()) : 0,
                 t = lugs ? p.quantity("lug_thickness", "m", Range::positive()) : 0;
    if (n.errors() == before) s.mesh = dem::wheel_mesh(r, w, segments, lugs, h, t);
    p.finish();
  } else if (n.has("cylinder")) {
    const ConfigNode p = n.map("cylinder");
    s.kind = Kind::cylinder;
    s.radius = p.quantity("radius", "m", Range::positive());
    s.half_width = 0.5 * p.quantity("width", "m", Range::positive());
    p.finish();
  } else if (n.has("spheres")) {
    const ConfigNode p = n.map("spheres");
    s.kind = Kind::spheres;
    read_sphere_file(p, s);
    p.finish();
  } else {
    n.error("a surface is one of plane, box, rectangle, mesh, wheel, cylinder, spheres");
  }
  n.finish();
  b.surfaces.push_back(std::move(s));
}

void read_free(const ConfigNode& n, dem::BodySettings& b) {
  static const std::vector<std::string> directions{"x", "y", "z", "rx", "ry", "rz"};
  b.free = true;
  b.mass = n.quantity("mass", "kg", Range::positive());
  b.inertia = vector(n, "inertia", "kg m^2", Vec3::Ones(), true, Range::positive());
  for (const ConfigNode& l : n.optional_list("locked")) {
    const std::string d = l.as_text();
    const auto at = std::find(directions.begin(), directions.end(), d);
    if (at == directions.end())
      l.error(fmt::format("'{}' is no direction; known: {}", d, fmt::join(directions, ", ")));
    else
      b.locked[static_cast<std::size_t>(at - directions.begin())] = true;
  }
  n.finish();
}

void read_body(const ConfigNode& n, DemCase& c) {
  DemBody b;
  b.name = n.text("name");
  if (b.name.find_first_of(",\"\n") != std::string::npos)
    n.error_at("name", "a name heads columns: without comma and quote");
  for (const DemBody& o : c.bodies)
    if (o.name == b.name) n.error_at("name", "body '" + b.name + "' was described already");
  const int material = material_number(n, "material", c.materials);
  b.settings.X_WB.p = vector(n, "position", "m");
  if (n.has("rotation")) {
    const ConfigNode r = n.map("rotation");
    const Vec3 axis = vector(r, "axis", "1", Vec3::UnitZ(), true);
    const double angle = r.quantity("angle", "rad");
    if (axis.norm() == 0)
      r.error_at("axis", "an axis cannot be zero");
    else
      b.settings.X_WB.q = Quat(Eigen::AngleAxisd(angle, Eigen::Vector3d(axis.normalized())));
    r.finish();
  }
  if (n.has("free")) read_free(n.map("free"), b.settings);
  for (const ConfigNode& s : n.list("surfaces")) read_surface(s, b, material);
  for (const ConfigNode& m : n.optional_list("schedule")) {
    DemMotion d;
    d.from = m.quantity("from", "s", Range::non_negative());
    d.V.v = vector(m, "velocity", "m/s");
    d.V.w = vector(m, "spin", "rad/s");
    d.has_load = m.has("force") || m.has("torque");
    d.force = vector(m, "force", "N");
    d.torque = vector(m, "torque", "N m");
    if (d.has_load && !b.settings.free) m.error("a force moves a free body only; give the body 'free'");
    if (!b.schedule.empty() && d.from <= b.schedule.back().from) m.error_at("from", "times must rise");
    m.finish();
    b.schedule.push_back(d);
  }
  if (!b.schedule.empty() && b.schedule[0].from == 0) {
    b.settings.V_W = b.schedule[0].V;
    b.settings.force = b.schedule[0].force;
    b.settings.torque = b.schedule[0].torque;
  }
  n.finish();
  c.bodies.push_back(std::move(b));
}

void read_grain_file(const ConfigNode& n, DemCase& c) {
  GrainFile f;
  const std::size_t before = c.grains.size();
  f.bed = n.has("bed");
  f.file = n.existing_file(f.bed ? "bed" : "file");
  if (!f.file.empty() && f.bed) {
    std::vector<dem::GrainState> bed = dem::read_bed(f.file).grains;
    if (c.grains.empty())
      c.grains = std::move(bed);
    else
      c.grains.insert(c.grains.end(), bed.begin(), bed.end());
  } else if (!f.file.empty()) {
    FileErrors errors(f.file);
    read_grains(f.file, c.materials, errors, c.grains);
    errors.report_to(n);
  }
  n.finish();
  f.count = c.grains.size() - before;
  c.grain_files.push_back(std::move(f));
}

/// auto and adaptive: from the Rayleigh time of the grain that has the least.
void read_step(const ConfigNode& root, DemCase& c) {
  const ConfigNode n = root.node("time_step");
  const std::string word = n.present() && n.is_scalar() ? n.as_text() : "";
  const bool adaptive = word == "adaptive";
  if (word != "auto" && !adaptive) {
    c.solver.dt = root.quantity("time_step", "s", Range::positive());
    if (root.has("step_share")) root.error_at("step_share", "goes with 'time_step: auto' or 'adaptive' only");
    return;
  }
  if (c.solver.law.model != dem::ContactModel::hertz_ch4)
    root.error_at("time_step", "'" + word + "' is known for hertz-ch4 only; give the step in seconds");
  const double share =
      root.quantity_or("step_share", adaptive ? 0.5 : dem::kStepShare, "1", {0, adaptive ? 0.8 : 0.5, true, false});
  double least = 1e30;
  for (const dem::GrainState& g : c.grains)
    if (g.material >= 0 && static_cast<std::size_t>(g.material) < c.solver.materials.materials.size())
      least = std::min(least, dem::rayleigh_time(c.solver.materials.materials[static_cast<std::size_t>(g.material)],
                                                 g.radius, g.density));
  if (least == 1e30) return;  // said already: no grains
  c.solver.dt = (adaptive ? dem::kStepShare : share) * least;
  if (!adaptive) return;
  c.solver.adapt = share;
  c.solver.dt_largest = 0.4 * least;
}

}  // namespace

DemCase read_dem_case(const fs::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  DemCase c;
  c.title = root.text("dem");
  root.text_or("source", "");
  c.inputs = doc.text();
  read_domain(root.map("domain"), c.solver.domain);
  if (root.has("law")) dem::read_law(root.map("law"), c.solver.law);
  read_materials(root, c);
  if (root.node("grains").is_list())
    for (const ConfigNode& n : root.list("grains")) read_grain_file(n, c);
  else
    read_grain_file(root.map("grains"), c);
  if (root.has("materials") && root.has("grains")) read_pairs(root, c);
  c.solver.gravity = vector(root, "gravity", "m/s^2", c.solver.gravity);
  read_step(root, c);
  c.duration = root.quantity("duration", "s", Range::positive());
  c.output_every = root.quantity_or("output_every", c.duration / 100, "s", Range::positive());
  c.solver.precision = root.choice_or("precision", "single", {"single", "double"}) == "double" ? dem::Precision::full
                                                                                               : dem::Precision::single;
  c.solver.ledger = root.boolean_or("energy", false);
  c.contacts = root.boolean_or("contacts", false);
  for (const ConfigNode& b : root.optional_list("bodies")) read_body(b, c);
  root.finish();
  doc.check();
  c.inputs += grains_text(c.grains);
  return c;
}

}  // namespace grouser::app
