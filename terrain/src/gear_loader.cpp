// Wheel files: smooth and lugged cylinders, meshes.
#include <cmath>

#include "grouser/terrain/loaders.h"
#include "grouser/terrain/mesh_file.h"
#include "units.h"

namespace grouser {
namespace {

constexpr Range length{1e-4, 10, false, false};  // [m] a wheel larger or smaller than this is a wrong unit

std::string millimetres(double x) { return units::number(1000 * x) + " mm"; }

SmoothCylinder load_smooth(const ConfigNode& root) {
  SmoothCylinder s;
  s.radius = root.quantity("radius", "mm", length);
  s.width = root.quantity("width", "mm", length);
  return s;
}

LuggedCylinder load_lugged(const ConfigNode& root) {
  const std::size_t before = root.errors();
  LuggedCylinder l;
  l.radius = root.quantity("radius", "mm", length);
  l.width = root.quantity("width", "mm", length);
  l.lug_height = root.quantity("lug_height", "mm", length);
  l.lug_width = root.quantity("lug_width", "mm", {0, 10, false, false});
  l.lug_count = static_cast<int>(root.integer("lug_count", 1, 10000));
  const auto ratio = root.optional_quantity("lug_ratio", "1", Range::between(0, 1));
  const bool concave = root.choice_or("tread", "flat", {"flat", "concave"}) == "concave";
  if (concave)
    l.tread_radius = root.quantity("tread_radius", "mm", length);
  else if (root.has("tread_radius"))
    root.error_at("tread_radius", "belongs to 'tread: concave'");
  l.closed_sides = static_cast<int>(root.integer_or("closed_sides", 2, 0, 2));
  l.sidewall_height = root.quantity_or("sidewall_height", 0, "mm", {0, 10, false, false});
  if (root.errors() != before) return l;

  const double circumference = 2 * pi * l.radius;
  if (l.lug_count * l.lug_width > circumference)
    root.error_at("lug_count", std::to_string(l.lug_count) + " lugs of " + millimetres(l.lug_width) +
                                   " do not fit on a circumference of " + millimetres(circumference));
  if (l.lug_height >= l.radius)
    root.error_at("lug_height", "the lugs are higher than the wheel's radius of " + millimetres(l.radius));
  if (concave && l.tread_radius < 0.5 * l.width)
    root.error_at("tread_radius", "an arc across a width of " + millimetres(l.width) + " has a radius of at least " +
                                      millimetres(0.5 * l.width));
  l.lug_ratio = ratio.value_or(std::min(1.0, l.lug_count * l.lug_width / circumference));
  return l;
}

TriangleMesh load_mesh(const ConfigNode& root) {
  const std::size_t before = root.errors();
  const std::filesystem::path file = root.existing_file("file");
  const bool mm = root.choice_or("unit", "m", {"m", "mm"}) == "mm";
  const double radius = root.quantity("radius", "mm", length);
  TriangleMesh mesh;
  if (root.errors() == before) {
    std::vector<Diagnostic> faults;
    mesh = read_mesh(file, mm ? 1e-3 : 1.0, faults);
    for (Diagnostic& d : faults) root.report(std::move(d));
  }
  mesh.radius = radius;
  if (root.errors() != before) return mesh;

  double reach = 0, low = mesh.vertices[0].y(), high = low;
  for (const Vec3& v : mesh.vertices) {
    reach = std::max(reach, std::hypot(v.x(), v.z()));
    low = std::min(low, v.y());
    high = std::max(high, v.y());
  }
  mesh.width = high - low;
  // The nominal radius may lie below the lug tips, not outside the mesh; a factor of 1000 is a wrong unit.
  if (radius > 1.01 * reach || radius < 0.5 * reach)
    root.error_at("radius", "the mesh reaches " + millimetres(reach) +
                                " from its y axis (spin axis); the nominal radius lies between half of " +
                                "that and that: check 'unit: " + std::string(mm ? "mm" : "m") +
                                "' and the axes of the mesh");
  return mesh;
}

}  // namespace

RunningGear load_running_gear(const ConfigNode& root) {
  RunningGear gear;
  gear.name = root.text("wheel");
  root.text("source");
  const std::size_t before = root.errors();
  const std::string shape = root.choice("shape", {"smooth", "lugged", "mesh"});
  if (root.errors() != before) return gear;  // which keys belong here only the shape says
  if (shape == "smooth") gear.shape = load_smooth(root);
  if (shape == "lugged") gear.shape = load_lugged(root);
  if (shape == "mesh") gear.shape = load_mesh(root);
  root.finish();
  return gear;
}

RunningGear load_running_gear_file(const std::filesystem::path& file) {
  const ConfigDocument document = ConfigDocument::from_file(file);
  const RunningGear gear = load_running_gear(document.root());
  document.check();
  return gear;
}

}  // namespace grouser
