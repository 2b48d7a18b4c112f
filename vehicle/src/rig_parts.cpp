#include "rig_parts.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace grouser::vehicle {

namespace {

/// Closed prism between two outlines of n points each, added to a mesh.
void add_prism(TriangleMesh& m, const std::vector<Vec3>& left, const std::vector<Vec3>& right) {
  const auto base = static_cast<std::int32_t>(m.vertices.size());
  const auto n = static_cast<std::int32_t>(left.size());
  m.vertices.insert(m.vertices.end(), left.begin(), left.end());
  m.vertices.insert(m.vertices.end(), right.begin(), right.end());
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t a = base + i, b = base + (i + 1) % n;
    m.triangles.push_back({a, a + n, b});
    m.triangles.push_back({b, a + n, b + n});
  }
  for (std::int32_t i = 1; i + 1 < n; ++i) {
    m.triangles.push_back({base, base + i, base + i + 1});
    m.triangles.push_back({base + n, base + n + i + 1, base + n + i});
  }
}

Vec3 on_circle(double r, double angle, double y) { return {r * std::sin(angle), y, r * std::cos(angle)}; }

void add_ring(TriangleMesh& m, double radius, double width) {
  std::vector<Vec3> left, right;
  constexpr int facets = 48;
  for (int i = 0; i < facets; ++i) {
    const double a = -2 * pi * i / facets;
    left.push_back(on_circle(radius, a, 0.5 * width));
    right.push_back(on_circle(radius, a, -0.5 * width));
  }
  add_prism(m, left, right);
}

void add_lugs(TriangleMesh& m, const LuggedCylinder& g) {
  const double half = 0.5 * std::max(g.lug_width, 1e-3) / g.radius;
  for (int i = 0; i < g.lug_count; ++i) {
    const double a = -2 * pi * i / g.lug_count;
    std::vector<Vec3> left, right;
    for (const auto& [r, d] : {std::pair{0.98 * g.radius, half}, {g.radius + g.lug_height, half},
                               {g.radius + g.lug_height, -half}, {0.98 * g.radius, -half}}) {
      left.push_back(on_circle(r, a + d, 0.5 * g.width));
      right.push_back(on_circle(r, a + d, -0.5 * g.width));
    }
    add_prism(m, left, right);
  }
}

}  // namespace

TriangleMesh view_mesh(const RunningGear& gear) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&gear.shape)) return *mesh;
  TriangleMesh m;
  m.radius = gear.radius();
  m.width = gear.width();
  add_ring(m, gear.radius(), gear.width());
  if (const auto* lugged = std::get_if<LuggedCylinder>(&gear.shape)) add_lugs(m, *lugged);
  return m;
}

void write_gear_mesh(Recorder& file, const std::string& body, const RunningGear& gear) {
  const TriangleMesh m = view_mesh(gear);
  std::vector<double> v, t;
  for (const Vec3& p : m.vertices) v.insert(v.end(), {p.x(), p.y(), p.z()});
  for (const auto& tri : m.triangles)
    for (const std::int32_t i : tri) t.push_back(i);
  file.write_static({"mesh." + body + ".vertices", "m", "surface for the 3-D view", "B", 1}, v, {m.vertices.size(), 3});
  file.write_static({"mesh." + body + ".triangles", "1", "vertex indices from 0", "", 1}, t, {m.triangles.size(), 3});
}

std::string assumptions_json(const std::vector<Assumption>& list) {
  nlohmann::json out = nlohmann::json::array();
  for (const Assumption& a : list) out.push_back({{"file", a.file}, {"key", a.key}, {"value", a.value}, {"why", a.why}});
  return out.dump();
}

}  // namespace grouser::vehicle
