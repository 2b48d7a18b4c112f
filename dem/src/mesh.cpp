#include <cmath>
#include <map>

#include "grouser/dem/surface.h"

namespace grouser::dem {

void Mesh::append(const Mesh& other) {
  const int first = static_cast<int>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

std::size_t Mesh::open_edges() const {
  // By place, so that vertices given twice still join.
  std::map<std::array<double, 6>, int> uses;
  for (const auto& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = vertices[static_cast<std::size_t>(t[k])], &b = vertices[static_cast<std::size_t>(t[(k + 1) % 3])];
      std::array<double, 6> key{a[0], a[1], a[2], b[0], b[1], b[2]}, back{b[0], b[1], b[2], a[0], a[1], a[2]};
      ++uses[key < back ? key : back];
    }
  std::size_t open = 0;
  for (const auto& u : uses) open += u.second == 1;
  return open;
}

bool Mesh::contains(const Vec3& x) const {
  double angle = 0;
  for (const auto& t : triangles) {
    const Vec3 a = vertices[static_cast<std::size_t>(t[0])] - x, b = vertices[static_cast<std::size_t>(t[1])] - x,
               c = vertices[static_cast<std::size_t>(t[2])] - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::fabs(angle) > 2 * pi;  // 4 pi inside, 0 outside
}

double Mesh::area() const {
  double a = 0;
  for (const auto& t : triangles) {
    const Vec3& p = vertices[static_cast<std::size_t>(t[0])];
    a +=
        0.5 * (vertices[static_cast<std::size_t>(t[1])] - p).cross(vertices[static_cast<std::size_t>(t[2])] - p).norm();
  }
  return a;
}

double Mesh::volume() const {
  double v = 0;
  for (const auto& t : triangles)
    v += vertices[static_cast<std::size_t>(t[0])].dot(
             vertices[static_cast<std::size_t>(t[1])].cross(vertices[static_cast<std::size_t>(t[2])])) /
         6;
  return v;
}

namespace {
void quad(Mesh& m, int a, int b, int c, int d) {
  m.triangles.push_back({a, b, c});
  m.triangles.push_back({a, c, d});
}
}  // namespace

Mesh box_mesh(const Vec3& size, bool open_top, bool open_bottom) {
  Mesh m;
  for (int k = 0; k < 8; ++k)
    m.vertices.push_back(0.5 *
                         Vec3(k & 1 ? size[0] : -size[0], k & 2 ? size[1] : -size[1], k & 4 ? size[2] : -size[2]));
  quad(m, 0, 4, 6, 2);
  quad(m, 1, 3, 7, 5);
  quad(m, 0, 1, 5, 4);
  quad(m, 2, 6, 7, 3);
  if (!open_bottom) quad(m, 0, 2, 3, 1);
  if (!open_top) quad(m, 4, 5, 7, 6);
  return m;
}

Mesh plate_mesh(double lx, double ly) {
  Mesh m;
  for (int k = 0; k < 4; ++k) m.vertices.push_back(Vec3(k & 1 ? lx / 2 : -lx / 2, k & 2 ? ly / 2 : -ly / 2, 0));
  quad(m, 0, 1, 3, 2);
  return m;
}

Mesh wheel_mesh(double radius, double width, int segments, int lugs, double lug_height, double lug_thickness) {
  Mesh m;
  const double h = width / 2;
  m.vertices = {Vec3(0, -h, 0), Vec3(0, h, 0)};
  for (int k = 0; k < segments; ++k) {
    const double a = 2 * pi * k / segments;
    m.vertices.push_back(Vec3(radius * std::cos(a), -h, radius * std::sin(a)));
    m.vertices.push_back(Vec3(radius * std::cos(a), h, radius * std::sin(a)));
  }
  for (int k = 0; k < segments; ++k) {
    const int a = 2 + 2 * k, b = 2 + 2 * ((k + 1) % segments);
    quad(m, a, a + 1, b + 1, b);
    m.triangles.push_back({0, a, b});
    m.triangles.push_back({1, b + 1, a + 1});
  }
  for (int k = 0; k < lugs; ++k) {
    // A lug is a box from a little inside the rim outwards.
    Mesh lug = box_mesh(Vec3(lug_height * 2, width, lug_thickness));
    const Mat3 turn = Eigen::AngleAxisd(-2 * pi * k / lugs, Eigen::Vector3d(0, 1, 0)).toRotationMatrix();
    for (Vec3& v : lug.vertices) v = turn * Vec3(v[0] + radius, v[1], v[2]);
    m.append(lug);
  }
  return m;
}

}  // namespace grouser::dem
