#include "visual_mesh.h"

#include <cmath>

namespace grouser::vehicle {

namespace {

void add_vertex(VisualMesh& m, const Vec3& p) { m.vertices.insert(m.vertices.end(), {p.x(), p.y(), p.z()}); }
void add_triangle(VisualMesh& m, std::size_t a, std::size_t b, std::size_t c) {
  m.triangles.insert(m.triangles.end(), {static_cast<double>(a), static_cast<double>(b), static_cast<double>(c)});
}

void add_box(VisualMesh& m, const Vec3& size, const Pose& X) {
  const std::size_t o = m.vertices.size() / 3;
  for (int i = 0; i < 8; ++i)
    add_vertex(m, X * Vec3(0.5 * size.x() * (i & 1 ? 1 : -1), 0.5 * size.y() * (i & 2 ? 1 : -1),
                           0.5 * size.z() * (i & 4 ? 1 : -1)));
  static constexpr int faces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& f : faces) add_triangle(m, o + f[0], o + f[1], o + f[2]);
}

/// Solid of revolution about y whose radius changes with the angle: rim(i), i = 0..n-1.
template <class Rim>
void add_wheel(VisualMesh& m, int n, double width, const Pose& X, Rim rim) {
  const std::size_t o = m.vertices.size() / 3;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * pi * i / n, r = rim(i);
    for (const double y : {-0.5 * width, 0.5 * width}) add_vertex(m, X * Vec3(r * std::cos(a), y, -r * std::sin(a)));
  }
  const std::size_t centre = o + 2 * static_cast<std::size_t>(n);
  add_vertex(m, X * Vec3(0, -0.5 * width, 0));
  add_vertex(m, X * Vec3(0, 0.5 * width, 0));
  for (int i = 0; i < n; ++i) {
    const std::size_t a = o + 2 * static_cast<std::size_t>(i), b = o + 2 * static_cast<std::size_t>((i + 1) % n);
    add_triangle(m, a, a + 1, b);
    add_triangle(m, b, a + 1, b + 1);
    add_triangle(m, centre, a, b);
    add_triangle(m, centre + 1, b + 1, a + 1);
  }
}

void add_gear(VisualMesh& m, const RunningGear& g, const Pose& X_BG) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&g.shape)) {
    const std::size_t o = m.vertices.size() / 3;
    for (const Vec3& v : mesh->vertices) add_vertex(m, X_BG * v);
    for (const auto& t : mesh->triangles) add_triangle(m, o + t[0], o + t[1], o + t[2]);
    return;
  }
  if (const auto* lugged = std::get_if<LuggedCylinder>(&g.shape)) {
    const double lug = lugged->radius + lugged->lug_height;
    add_wheel(m, 4 * lugged->lug_count, lugged->width, X_BG, [&](int i) { return i % 4 == 0 ? lug : lugged->radius; });
    return;
  }
  // Round to the eye; the page draws spokes on the sides, so that one sees it turn.
  add_wheel(m, 96, g.width(), X_BG, [&](int) { return g.radius(); });
}

}  // namespace

VisualMesh visual_mesh(const VehicleSpec& v, int link) {
  VisualMesh m;
  for (const Visual& s : v.links[link].visuals) {
    if (s.kind == Visual::Kind::box)
      add_box(m, s.size, s.X_BS);
    else
      add_wheel(m, 64, s.size.y(), s.X_BS, [&](int) { return s.size.x(); });
  }
  for (const WheelSpec& w : v.wheels) {
    if (w.link != link) continue;
    Pose X_BG;
    X_BG.q =
        Quat::FromTwoVectors(Vec3(Vec3::UnitY()), Vec3(v.links[link].X_VB.q.conjugate() * v.joints[w.joint].axis_V));
    add_gear(m, w.gear, X_BG);
  }
  return m;
}

}  // namespace grouser::vehicle
