#include "node_gear.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace grouser::bekker::node {

namespace {

/// Lower boundary of the gear in the wheel plane at forward position x: height and normal into the gear.
struct Profile {
  double height = 0, nx = 0, nz = 1;
  bool hit = false;
};

void lower(Profile& p, double height, double nx, double nz) {
  if (p.hit && height >= p.height) return;
  p = {height, nx, nz, true};
}

/// Edge from (xa, za) to (xb, zb), xa < xb, seen from below.
void edge(Profile& p, double x, double xa, double za, double xb, double zb) {
  if (!(xa < xb) || x < xa || x > xb) return;
  const double dx = xb - xa, dz = zb - za, length = std::hypot(dx, dz);
  lower(p, za + (x - xa) / dx * dz, -dz / length, dx / length);
}

}  // namespace

GearShape::GearShape(const RunningGear& gear, Lugs lugs, double least)
    : gear_(gear), lugs_option_(lugs), least_(least), radius_(gear.outer_radius()) {}

bool GearShape::takes_mean(double spacing) const {
  const auto* lugged = std::get_if<LuggedCylinder>(&gear_.shape);
  return lugged && (lugs_option_ == Lugs::mean ||
                    (lugs_option_ == Lugs::automatic && lugged->lug_width < std::max(2 * spacing, least_)));
}

void GearShape::resolve(double spacing) { mean_ = takes_mean(spacing); }

void GearShape::mean_lugs(Gear& g) const {
  g.tip_share = 1;
  if (!mean_) return;
  const auto& lugged = std::get<LuggedCylinder>(gear_.shape);
  g.tip_share = lugged.lug_ratio;
  g.tread = lugged.radius;
  g.hollow = lugged.tread_radius;
}

void GearShape::turn(const Quat& q, const Gear& g) {
  if (const auto* lugged = std::get_if<LuggedCylinder>(&gear_.shape)) {
    // Angle of gear x from the carrier's x about the spin axis; lugs sit at multiples of the pitch.
    const Vec3 x = q * Vec3::UnitX();
    const double forward = x.x() * g.X[0] + x.y() * g.X[1] + x.z() * g.X[2];
    const double up = x.x() * g.Z[0] + x.y() * g.Z[1] + x.z() * g.Z[2];
    const double spin = std::atan2(-up, forward), pitch = 2 * pi / lugged->lug_count;
    lugs_.clear();
    for (int k = 0; k < lugged->lug_count; ++k) {
      // Gear point (sin a, -cos a) at angle a from the bottom moves to a - spin.
      const double a = std::remainder(k * pitch - spin, 2 * pi);
      if (std::abs(a) < 1.4) lugs_.push_back({std::sin(a), std::cos(a), 0, 0});
    }
  } else if (const auto* mesh = std::get_if<TriangleMesh>(&gear_.shape)) {
    const Mat3 R = q.toRotationMatrix();
    turned_.resize(mesh->vertices.size());
    for (std::size_t i = 0; i < turned_.size(); ++i) turned_[i] = R * mesh->vertices[i];
    below_.clear();
    for (const auto& t : mesh->triangles) {
      const Vec3 &a = turned_[t[0]], &b = turned_[t[1]], &c = turned_[t[2]];
      const Vec3 n = (b - a).cross(c - a);
      if (n.z() < -0.05 * n.norm()) below_.push_back(t);
    }
  }
}

void GearShape::cover(const Gear& g, const Segment& s, double* out) const {
  if (std::holds_alternative<TriangleMesh>(gear_.shape))
    cover_mesh(g, s, out);
  else
    cover_profile(g, s, out);
}

void GearShape::cover_profile(const Gear& g, const Segment& s, double* out) const {
  const auto& lugged = std::get<LuggedCylinder>(gear_.shape);
  const double half = 0.5 * lugged.width, R = lugged.tread_radius;
  // A concave tread is lower in the middle by the sagitta of its curvature.
  const auto hollow = [&](double y) {
    if (R <= half) return 0.0;
    const double c = std::min(std::abs(y), half);
    return std::sqrt(R * R - c * c) - std::sqrt(R * R - half * half);
  };
  const auto profile = [&](double x, double y) {
    Profile p;
    const double r = lugged.radius - hollow(y);
    if (std::abs(x) < 0.998 * r) {
      const double root = std::sqrt(r * r - x * x);
      lower(p, -root, -x / r, root / r);
    }
    // Tips only: a flank is no surface that pushes soil down, and what it can push sideways is the strength of the
    // soil between the lugs, which is sheared off at the tips.
    const double outer = lugged.radius + lugged.lug_height, hw = 0.5 * lugged.lug_width;
    for (const auto& lug : lugs_) {
      const double sn = lug[0], cs = lug[1];  // radial direction (sn, -cs), along the circumference (cs, sn)
      const double tx = outer * sn, tz = -outer * cs;
      edge(p, x, tx - hw * cs, tz - hw * sn, tx + hw * cs, tz + hw * sn);
    }
    return p;
  };
  for (int i = s.i0; i < s.i1; ++i)
    for (int j = s.j0; j < s.j1; ++j) {
      const int at = i * kSide + j;
      const double dx = s.x0 + i * g.spacing, dy = s.y0 + j * g.spacing;
      double* o = out + at;
      o[4 * kTile] = 0;
      const double x = dx * g.X[0] + dy * g.X[1];
      double y = dx * g.Y[0] + dy * g.Y[1], zeta = 0;
      Profile p;
      for (int pass = 0; pass < 2; ++pass) {  // the place across the width depends on the height where the gear leans
        p = profile(x, y);
        if (!p.hit) break;
        zeta = (p.height - (dx * g.Z[0] + dy * g.Z[1])) / g.Z[2];
        y = dx * g.Y[0] + dy * g.Y[1] + zeta * g.Y[2];
        if (R <= half && g.Y[2] == 0) break;
      }
      o[0] = zeta;
      if (!p.hit) {
        o[kTile] = o[2 * kTile] = 0;
        o[3 * kTile] = 1;
        continue;
      }
      o[kTile] = p.nx * g.X[0] + p.nz * g.Z[0];
      o[2 * kTile] = p.nx * g.X[1] + p.nz * g.Z[1];
      o[3 * kTile] = p.nz * g.Z[2];
      o[4 * kTile] = std::clamp((half + 0.5 * g.spacing - std::abs(y)) / g.spacing, 0.0, 1.0);
    }
}

void GearShape::cover_mesh(const Gear& g, const Segment& s, double* out) const {
  for (int i = s.i0; i < s.i1; ++i)
    for (int j = s.j0; j < s.j1; ++j) {
      double* o = out + i * kSide + j;
      o[0] = o[kTile] = o[2 * kTile] = o[4 * kTile] = 0;
      o[3 * kTile] = 1;
    }
  const double h = g.spacing;
  for (const auto& t : below_) {
    const Vec3 &a = turned_[t[0]], &b = turned_[t[1]], &c = turned_[t[2]];
    const Vec3 n = (b - a).cross(c - a);
    const auto index = [&](double v, double origin) { return (v - origin) / h; };
    const int i0 = std::max(s.i0, static_cast<int>(std::ceil(index(std::min({a.x(), b.x(), c.x()}), s.x0))));
    const int i1 = std::min(s.i1 - 1, static_cast<int>(std::floor(index(std::max({a.x(), b.x(), c.x()}), s.x0))));
    const int j0 = std::max(s.j0, static_cast<int>(std::ceil(index(std::min({a.y(), b.y(), c.y()}), s.y0))));
    const int j1 = std::min(s.j1 - 1, static_cast<int>(std::floor(index(std::max({a.y(), b.y(), c.y()}), s.y0))));
    for (int i = i0; i <= i1; ++i)
      for (int j = j0; j <= j1; ++j) {
        const double x = s.x0 + i * h, y = s.y0 + j * h;
        const auto side = [&](const Vec3& p, const Vec3& q) {
          return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
        };
        if (side(a, b) > 0 || side(b, c) > 0 || side(c, a) > 0) continue;  // seen from above it turns clockwise
        const double z = a.z() - (n.x() * (x - a.x()) + n.y() * (y - a.y())) / n.z();
        double* o = out + i * kSide + j;
        if (o[4 * kTile] > 0 && o[0] <= z) continue;
        const double size = -1 / n.norm();
        o[0] = z;
        o[kTile] = size * n.x();
        o[2 * kTile] = size * n.y();
        o[3 * kTile] = size * n.z();
        o[4 * kTile] = 1;
      }
  }
}

}  // namespace grouser::bekker::node
