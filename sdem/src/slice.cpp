#include "grouser/sdem/slice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "blend.h"
#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

struct Slice::Impl {
  Impl(std::shared_ptr<const Tables> t, const SliceSettings& q)
      : set(q), blend(std::move(t)), r(blend.tables().radius), reach(blend.tables().part(Part::soil_right).v.last) {}

  SliceSettings set;
  Blend blend;
  double r, reach;
  std::vector<double> s, z;                                   ///< points in the order they were laid
  std::int64_t first = 0;                                     ///< number of point 0: it was laid at first * spacing
  std::size_t begin = 0, end = 0;                             ///< points that may be in the window
  double scanned = std::numeric_limits<double>::quiet_NaN();  ///< place of the wheel when that was looked at
  std::int64_t outside_count = 0;
  struct Contact {
    double angle, px, pz;
  };
  std::vector<Contact> contacts;  ///< scratch

  /// Points that do not lie within the window do not move, so it is enough to look at all of them now and then.
  void scan(double hub) {
    constexpr double kMargin = 0.05;
    if (std::abs(hub - scanned) < kMargin) return;
    scanned = hub;
    begin = s.size();
    end = 0;
    for (std::size_t i = 0; i < s.size(); ++i)
      if (std::abs(s[i] - hub) <= reach + 2 * kMargin) {
        begin = std::min(begin, i);
        end = i + 1;
      }
  }

  /// +1 forward, -1: the mirror image.
  static double direction(const WheelState& x) {
    if (x.w != 0) return x.w > 0 ? 1 : -1;
    return x.vx < 0 ? -1 : 1;
  }

  void set_velocity(const WheelState& x, double dir) {
    Velocity V{dir * x.w, dir * x.vx, round(x.vz, x.vx)};
    if (const std::string wrong = sdem::outside(blend.tables(), V); !wrong.empty()) {
      if (!set.nearest)
        throw TerrainError("the wheel's velocity lies outside the tables: " + wrong +
                           "; drive within them, build wider ones, or say 'outside: nearest'");
      ++outside_count;
    }
    blend.set(nearest(blend.tables(), V));
  }

  double round(double vz, double vx) const { return std::abs(vz) <= set.dead_band * std::abs(vx) ? 0.0 : vz; }

  /// Region of Table 5.2 that a place belongs to, or none outside the window.
  bool soil_velocity(double dx, double dz, Pair& v) {
    if (std::abs(dx) > reach || std::abs(dz) > reach) return false;
    const Part part = dx < -r  ? Part::soil_left
                      : dx > r ? Part::soil_right
                      : dz > 0 ? Part::soil_top
                               : Part::soil_bottom;
    v = blend.at(part, dz, dx);
    return true;
  }

  double height_for_table(double hub_z) {
    const Axis& a = blend.tables().part(Part::wheel_bottom).u;
    const double h = hub_z - set.floor;
    if (h >= a.first && h <= a.last) return h;
    if (!set.nearest) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "the hub is %.4g m above the floor of the soil, and the tables hold %.4g to %.4g m; check the "
                    "ground's height against 'datum', or say 'outside: nearest'",
                    h, a.first, a.last);
      throw TerrainError(text);
    }
    ++outside_count;
    return std::clamp(h, a.first, a.last);
  }
};

Slice::Slice(std::shared_ptr<const Tables> tables, const SliceSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(tables), settings)) {}
Slice::~Slice() = default;
Slice::Slice(Slice&&) noexcept = default;
Slice& Slice::operator=(Slice&&) noexcept = default;

void Slice::lay(double hub, const Profile& profile) {
  Impl& d = *impl_;
  const double a = d.set.spacing, around = d.reach + 0.06;
  const auto low = static_cast<std::int64_t>(std::floor((hub - around) / a)),
             high = static_cast<std::int64_t>(std::ceil((hub + around) / a));
  const auto next = [&] { return d.first + static_cast<std::int64_t>(d.s.size()); };
  bool laid = false;
  if (d.s.empty()) d.first = low;
  for (; next() <= high; laid = true) {
    d.s.push_back(static_cast<double>(next()) * a);
    d.z.push_back(profile(d.s.back()));
  }
  if (low < d.first) {
    std::vector<double> s, z;
    for (std::int64_t i = low; i < d.first; ++i) {
      s.push_back(static_cast<double>(i) * a);
      z.push_back(profile(s.back()));
    }
    d.s.insert(d.s.begin(), s.begin(), s.end());
    d.z.insert(d.z.begin(), z.begin(), z.end());
    d.first = low;
    laid = true;
  }
  if (laid) d.scanned = std::numeric_limits<double>::quiet_NaN();
}

void Slice::move(const WheelState& x, double dt, double force_z, double weight) {
  Impl& d = *impl_;
  d.scan(x.s);
  const double dir = Impl::direction(x), inner = d.r - d.set.penetration;
  const bool moves = !d.set.gate || (force_z > 0 && force_z >= weight);
  if (moves) d.set_velocity(x, dir);
  for (std::size_t i = d.begin; i < d.end; ++i) {
    double dx = d.s[i] - x.s, dz = d.z[i] - x.z;
    Pair v;
    if (moves && d.soil_velocity(dir * dx, dz, v)) {
      dx += dt * dir * v.x;
      dz += dt * v.z;
      d.s[i] = x.s + dx;
      d.z[i] = x.z + dz;
    }
    const double distance = std::hypot(dx, dz);
    if (distance >= inner) continue;
    // A point in the middle of the hub has no direction: down.
    const double ux = distance > 0 ? dx / distance : 0, uz = distance > 0 ? dz / distance : -1;
    d.s[i] = x.s + inner * ux;
    d.z[i] = x.z + inner * uz;
  }
}

SliceForce Slice::force(const WheelState& x, double width) {
  Impl& d = *impl_;
  d.scan(x.s);
  SliceForce f;
  const double dir = Impl::direction(x);
  d.contacts.clear();
  double height = -1;
  for (std::size_t i = d.begin; i < d.end; ++i) {
    const double dx = dir * (d.s[i] - x.s), dz = d.z[i] - x.z;
    if (dx * dx + dz * dz >= d.r * d.r) continue;
    if (height < 0) {
      d.set_velocity(x, dir);
      height = d.height_for_table(x.z);
    }
    Pair p;
    if (dz <= 0) {
      p = d.blend.at(Part::wheel_bottom, height, std::atan2(dx, -dz));
    } else {
      p = d.blend.at(Part::wheel_top, dz, std::atan2(dx, dz));
    }
    d.contacts.push_back({std::atan2(dx, -dz), p.x, p.z});
  }
  f.contacts = static_cast<int>(d.contacts.size());
  std::sort(d.contacts.begin(), d.contacts.end(), [](const auto& a, const auto& b) { return a.angle < b.angle; });
  bool any = false;
  double low = 0, high = 0, fx = 0, fz = 0, torque = 0;
  for (std::size_t i = 1; i < d.contacts.size(); ++i) {
    const Impl::Contact &a = d.contacts[i - 1], &b = d.contacts[i];
    const double arc = d.r * (b.angle - a.angle);
    if (arc > d.set.gap) continue;
    if (!any) low = a.angle;
    any = true;
    high = b.angle;
    const auto along = [](const Impl::Contact& c) { return c.px * std::cos(c.angle) + c.pz * std::sin(c.angle); };
    const double half = 0.5 * arc * width;
    fx += half * (a.px + b.px);
    fz += half * (a.pz + b.pz);
    torque += half * d.r * (along(a) + along(b));
    // The rim moves with the hub and against the spin: v - w r (cos, sin).
    const auto power = [&](const Impl::Contact& c) {
      return c.px * (dir * x.vx - dir * x.w * d.r * std::cos(c.angle)) +
             c.pz * (x.vz - dir * x.w * d.r * std::sin(c.angle));
    };
    f.power += half * (power(a) + power(b));
  }
  f.fx = dir * fx;
  f.fz = fz;
  f.torque = dir * torque;
  f.entry = high;
  f.exit = low;
  return f;
}

void Slice::set_floor(double z) { impl_->set.floor = z; }
double Slice::rounded(double vz, double vx) const { return impl_->round(vz, vx); }
std::size_t Slice::size() const { return impl_->s.size(); }
double Slice::s_of(std::size_t i) const { return impl_->s[i]; }
double Slice::z_of(std::size_t i) const { return impl_->z[i]; }
std::int64_t Slice::outside() const { return impl_->outside_count; }
const SliceSettings& Slice::settings() const { return impl_->set; }

double Slice::height(double at) const {
  const Impl& d = *impl_;
  double below = -1e300, above = 1e300, z_below = 0, z_above = 0;
  for (std::size_t i = 0; i < d.s.size(); ++i) {
    if (d.s[i] <= at && d.s[i] > below) below = d.s[i], z_below = d.z[i];
    if (d.s[i] >= at && d.s[i] < above) above = d.s[i], z_above = d.z[i];
  }
  if (below < -1e299 || above > 1e299) return std::numeric_limits<double>::quiet_NaN();
  return above > below ? z_below + (at - below) / (above - below) * (z_above - z_below) : z_below;
}

void Slice::traverse(State& s) {
  Impl& d = *impl_;
  s.field("first", d.first);
  s.field("s", d.s);
  s.field("z", d.z);
  s.field("outside", d.outside_count);
  if (s.loading()) {
    if (d.s.size() != d.z.size()) throw StateError("the state's soil points are not whole");
    d.scanned = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace grouser::sdem
