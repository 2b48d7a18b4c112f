#include "grouser/dem/wheel_builder.h"

#include <algorithm>
#include <cmath>

#include "grouser/dem/solver.h"

namespace grouser::dem {

namespace {

void quad(Mesh& m, int a, int b, int c, int d) {
  m.triangles.push_back({a, b, c});
  m.triangles.push_back({a, c, d});
}

/// Places across the width at which the tread is given: the edges, and as many as keep a curved tread within 0.1 mm.
std::vector<double> stations(const WheelShape& w) {
  const double h = 0.5 * w.width;
  int n = 1;
  if (w.tread_radius > 0) n = std::max(2, static_cast<int>(std::ceil(w.width / std::sqrt(8 * 1e-4 * w.tread_radius))));
  std::vector<double> y;
  for (int k = 0; k <= n; ++k) y.push_back(-h + w.width * k / n);
  if (w.sidewall_height > 0) {
    for (const double inner : {-h + w.wall, h - w.wall}) y.push_back(inner);
    std::sort(y.begin(), y.end());
  }
  return y;
}

double bare_tread(const WheelShape& w, double y) {
  if (w.tread_radius <= 0) return w.radius;
  const double R = w.tread_radius, h = 0.5 * w.width;
  return w.radius - (std::sqrt(R * R - y * y) - std::sqrt(std::max(0.0, R * R - h * h)));
}

/// Point of a half plane through the axis.
struct Ring {
  double y, r;
};

/// Outline of the wheel's section from -y to +y; `loop`: it closes on itself away from the axis.
std::vector<Ring> outline(const WheelShape& w, bool& loop) {
  const double h = 0.5 * w.width, t = w.shell;
  std::vector<Ring> out;
  const auto add = [&out](double y, double r) { out.push_back({y, r}); };
  loop = w.closed_sides == 0;
  if (w.closed_sides == 2) add(-h, 0);
  const std::vector<double> at = stations(w);
  for (const double y : at) {
    const double tread = bare_tread(w, y);
    const bool left = w.sidewall_height > 0 && y > h - w.wall - 1e-12,
               right = w.sidewall_height > 0 && y < -h + w.wall + 1e-12;
    const bool inner = std::abs(std::abs(y) - (h - w.wall)) < 1e-12;
    if (left && inner) add(y, tread);
    add(y, tread + (left || right ? w.sidewall_height : 0));
    if (right && inner) add(y, tread);
  }
  if (w.closed_sides == 2) {
    add(h, 0);
    return out;
  }
  // The inside of the rim, back from +y.
  if (w.closed_sides == 1) add(h, 0), add(h - t, 0);
  std::vector<double> back(at.rbegin(), at.rend());
  bool first = true;
  for (const double y : back) {
    if (w.closed_sides == 1 && y > h - t) continue;
    if (w.closed_sides == 1 && first && y < h - t - 1e-12) add(h - t, bare_tread(w, h - t) - t);
    first = false;
    add(y, bare_tread(w, y) - t);
  }
  loop = true;
  return out;
}

Mesh revolve(const std::vector<Ring>& rings, bool loop, int segments) {
  Mesh m;
  std::vector<int> first;  // vertex of a ring, the only one on the axis
  for (const Ring& r : rings) {
    first.push_back(static_cast<int>(m.vertices.size()));
    const int n = r.r > 0 ? segments : 1;
    for (int k = 0; k < n; ++k) {
      const double a = 2 * pi * k / segments;
      m.vertices.push_back(Vec3(r.r * std::cos(a), r.y, r.r * std::sin(a)));
    }
  }
  const std::size_t n = rings.size(), strips = loop ? n : n - 1;
  for (std::size_t s = 0; s < strips; ++s) {
    const std::size_t e = (s + 1) % n;
    const bool a_axis = !(rings[s].r > 0), b_axis = !(rings[e].r > 0);
    if (a_axis && b_axis) continue;
    for (int k = 0; k < segments; ++k) {
      const int next = (k + 1) % segments;
      if (a_axis)
        m.triangles.push_back({first[s], first[e] + k, first[e] + next});
      else if (b_axis)
        m.triangles.push_back({first[s] + k, first[e], first[s] + next});
      else
        quad(m, first[s] + k, first[e] + k, first[e] + next, first[s] + next);
    }
  }
  return m;
}

Mesh lug(const WheelShape& w) {
  Mesh m;
  const std::vector<double> at = stations(w);
  const double half = 0.5 * w.lug_thickness, root = std::min(w.lug_height, 0.5 * w.shell);
  for (const double y : at) {
    const double r = bare_tread(w, y);
    for (const double z : {-half, half})
      for (const double x : {r - root, r + w.lug_height}) m.vertices.push_back(Vec3(x, y, z));
  }
  const int n = static_cast<int>(at.size());
  constexpr int around[4] = {0, 1, 3, 2};
  for (int s = 0; s + 1 < n; ++s)
    for (int k = 0; k < 4; ++k) {
      const int a = around[k], b = around[(k + 1) % 4];
      quad(m, 4 * s + a, 4 * s + b, 4 * s + 4 + b, 4 * s + 4 + a);
    }
  quad(m, 0, 2, 3, 1);
  const int e = 4 * (n - 1);
  quad(m, e, e + 1, e + 3, e + 2);
  return m;
}

}  // namespace

WheelShape wheel_shape(const RunningGear& gear) {
  WheelShape w;
  if (const auto* smooth = std::get_if<SmoothCylinder>(&gear.shape)) {
    w.radius = smooth->radius;
    w.width = smooth->width;
  } else if (const auto* lugged = std::get_if<LuggedCylinder>(&gear.shape)) {
    w.radius = lugged->radius;
    w.width = lugged->width;
    w.tread_radius = lugged->tread_radius;
    w.lugs = lugged->lug_count;
    w.lug_height = lugged->lug_height;
    if (lugged->lug_width > 0) w.lug_thickness = lugged->lug_width;
    w.closed_sides = lugged->closed_sides;
    w.sidewall_height = lugged->sidewall_height;
  } else {
    throw DemError("running gear '" + gear.name + "' is a mesh: it has its own surface");
  }
  if (!(w.radius > 0 && w.width > 0)) throw DemError("a wheel wants a positive radius and width");
  if (w.closed_sides < 2 && !(w.shell < 0.5 * w.width && w.shell < tread_radius_at(w, 0)))
    throw DemError("running gear '" + gear.name + "': its open rim of 10 mm is thicker than the wheel");
  return w;
}

double tread_radius_at(const WheelShape& w, double y) {
  const bool wall = w.sidewall_height > 0 && std::abs(y) > 0.5 * w.width - w.wall;
  return bare_tread(w, y) + (wall ? w.sidewall_height : 0);
}

Mesh wheel_mesh(const WheelShape& w, int segments) {
  bool loop = false;
  const std::vector<Ring> section = outline(w, loop);
  Mesh m = revolve(section, loop, segments);
  if (w.lugs <= 0 || !(w.lug_height > 0)) return m;
  const Mesh one = lug(w);
  for (int k = 0; k < w.lugs; ++k) {
    Mesh turned = one;
    const Mat3 turn = Eigen::AngleAxisd(-2 * pi * k / w.lugs, Eigen::Vector3d(0, 1, 0)).toRotationMatrix();
    for (Vec3& v : turned.vertices) v = turn * v;
    m.append(turned);
  }
  return m;
}

Clump wheel_clump(const WheelShape& w, double diameter, double lug_diameter, double spacing) {
  Clump c;
  const double R = 0.5 * diameter, h = 0.5 * w.width;
  /// Evenly from a to b, no further apart than `step`.
  const auto even = [](double a, double b, double step) {
    std::vector<double> x;
    const int n = std::max(1, static_cast<int>(std::ceil((b - a) / step)));
    for (int k = 0; k <= n; ++k) x.push_back(b > a ? a + (b - a) * k / n : 0.5 * (a + b));
    if (!(b > a)) x.resize(1);
    return x;
  };
  const auto ring = [&](double y, double r, double radius) {
    if (!(r > 0)) {
      c.centres.push_back(Vec3(0, y, 0));
      c.radii.push_back(radius);
      return;
    }
    const int n = std::max(3, static_cast<int>(std::ceil(2 * pi * r / (spacing * radius))));
    for (int k = 0; k < n; ++k) {
      const double a = 2 * pi * k / n;
      c.centres.push_back(Vec3(r * std::cos(a), y, r * std::sin(a)));
      c.radii.push_back(radius);
    }
  };
  const double step = spacing * R;
  // The normal of a curved tread leans by the slope; the sphere's outside still meets the tread.
  for (const double y : even(-h + R, h - R, step)) {
    const double R2 = w.tread_radius * w.tread_radius;
    const double lean = w.tread_radius > 0 ? std::sqrt(R2 / (R2 - y * y)) : 1.0;
    ring(y, bare_tread(w, y) - R * lean, R);
  }
  for (int side = 0; side < w.closed_sides; ++side) {
    const double y = side == 0 ? h - R : -h + R, outer = bare_tread(w, y) - R;
    std::vector<double> radii = even(0, outer, step);
    for (std::size_t k = 0; k + 1 < radii.size(); ++k) ring(y, radii[k], R);
  }
  const double q = 0.5 * lug_diameter, fine = spacing * q;
  if (w.lugs > 0 && w.lug_height > 0)
    for (int k = 0; k < w.lugs; ++k) {
      const Mat3 turn = Eigen::AngleAxisd(-2 * pi * k / w.lugs, Eigen::Vector3d(0, 1, 0)).toRotationMatrix();
      for (const double y : even(-h + q, h - q, fine))
        for (const double x : even(std::min(0.0, w.lug_height - q), w.lug_height - q, fine))
          for (const double z : even(-0.5 * w.lug_thickness + q, 0.5 * w.lug_thickness - q, fine)) {
            c.centres.push_back(turn * Vec3(bare_tread(w, y) + x, y, z));
            c.radii.push_back(q);
          }
    }
  if (w.sidewall_height > 0)
    for (const double side : {-1.0, 1.0})
      for (const double x : even(std::min(0.0, w.sidewall_height - q), w.sidewall_height - q, fine))
        ring(side * (h - q), bare_tread(w, h) + x, q);
  return c;
}

}  // namespace grouser::dem
