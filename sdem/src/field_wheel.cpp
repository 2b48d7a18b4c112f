#include "grouser/sdem/field_wheel.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace grouser::sdem {

namespace {

constexpr double kAround =
    0.03;  ///< soil ahead of the rim that a row asks for [m]: a pile begins at the contact, which ends before the rim does
constexpr double kMore = 0.01;   ///< and holds beyond [m], so that its wheel finds nothing missing
constexpr double kSlide = 0.03;  ///< soil around the wheel that may slide [m]
constexpr double kSweep = 0.1;   ///< cells of way (of the hub or the rim) over which it does

}  // namespace

FieldWheel::FieldWheel(const FieldSettings& s, std::shared_ptr<const Direction> law, double width, std::uint64_t seed)
    : law_(std::move(law)),
      width_(width),
      strip_(width / s.rows),
      scale_(s.bearing * strip_ / law_->width),
      points_(std::max(1, static_cast<int>(std::ceil(strip_ / s.cell - 1e-9)))) {
  DirectionSettings settings = s.wheel;
  settings.around = kAround;
  settings.seed = seed;  // of all rows: the noise is that of a slab of many grains
  for (int j = 0; j < s.rows; ++j)
    rows_.push_back({DirectionWheel(law_, settings), (j + 0.5) * strip_ - 0.5 * width, 0});
}

double FieldWheel::reach() const {
  return std::hypot(law_->radius + kAround + kMore + 0.02, 0.5 * width_ + strip_) + kSlide;
}

/// Mean height over the width of a row with that middle, `along` ahead of the hub.
double FieldWheel::around(double middle, const Vec3& hub, const Motion& m, double along, const SoilField& field,
                          SoilField::Near& near) const {
  double sum = 0;
  for (int k = 0; k < points_; ++k) {
    const double y = middle + ((k + 0.5) / points_ - 0.5) * strip_;
    // Across: level and square to the heading.
    sum += field.height(hub.x() + along * m.forward.x() - y * m.forward.y(),
                        hub.y() + along * m.forward.y() + y * m.forward.x(), near);
  }
  return sum / points_;
}

FieldForce FieldWheel::step(const Motion& m, const SoilField& field) {
  const double r = law_->radius, top = law_->at(Coefficient::surface);
  FieldForce total;
  changes_.clear();
  footprint_ = {m.end.x(), m.end.y(), m.forward.x(), m.forward.y(), 0, 0, 0.5 * width_};
  way_ = std::max((m.end - m.begin).norm(), std::abs(r * m.spin * m.dt));
  const double roll = r * m.roll * m.dt, yaw = m.yaw * m.dt, aside = (m.end - m.begin).dot(m.axis_end);
  // F2, from what was before the step.
  before_.resize(rows_.size(), rows_.front().plane.rut());
  for (std::size_t j = 0; j < rows_.size(); ++j) before_[j] = rows_[j].plane.rut();
  const int n = static_cast<int>(rows_.size());
  SoilField::Near near;
  for (int j = 0; j < n; ++j) {
    Rut& rut = rows_[static_cast<std::size_t>(j)].plane.rut();
    const Row& row = rows_[static_cast<std::size_t>(j)];
    for (std::size_t i = 0; i < rut.size(); ++i) {
      const double d = rut.place(i) - row.s, way = aside + yaw * d;
      if (way == 0 || std::abs(d) >= r) continue;
      const int from = j + (way > 0 ? 1 : -1);
      double met, now;
      if (from >= 0 && from < n) {
        const Rut& beside = before_[static_cast<std::size_t>(from)];
        const double there = rows_[static_cast<std::size_t>(from)].s + d;
        met = beside.before(there);
        now = beside.height(there);
      } else {
        met = now = around(row.y + (way > 0 ? strip_ : -strip_), m.begin, m, d, field, near) + top;
      }
      if (std::isfinite(met)) rut.drift(i, met, now, std::min(1.0, std::abs(way) / strip_));
    }
  }
  for (Row& row : rows_) {
    const Vec3 from = m.begin + row.y * m.axis_begin, to = m.end + row.y * m.axis_end, way = to - from;
    const double s0 = row.s;
    row.s += way.dot(m.forward);
    Rut& rut = row.plane.rut();
    const auto lies = [&](double s) { return around(row.y, m.end, m, s - row.s, field, near); };
    const auto tops = [&](double s) { return lies(s) + top; };
    // std::ref: a std::function of the lambda itself would be allocated.
    rut.renew(row.s, to.z(), std::min(s0, row.s) - r - kAround - kMore, std::max(s0, row.s) + r + kAround + kMore,
              std::ref(tops));
    was_.resize(rut.size());
    for (std::size_t i = 0; i < was_.size(); ++i) was_[i] = rut.h(i);
    const PlaneForce f =
        row.plane.step({s0, from.z(), row.s, to.z(), r * m.spin * m.dt, aside + roll, m.dt}, std::ref(lies));
    const double area = rut.column() * strip_ / points_;
    for (std::size_t i = 0; i < was_.size(); ++i) {
      const double raised = (rut.h(i) - was_[i]) * area, compacted = rut.compacted(i) * area;
      if (raised == 0 && compacted == 0) continue;
      const double along = rut.place(i) - row.s;
      for (int k = 0; k < points_; ++k) {
        const double y = row.y + ((k + 0.5) / points_ - 0.5) * strip_;
        changes_.push_back({m.end.x() + along * m.forward.x() - y * m.forward.y(),
                            m.end.y() + along * m.forward.y() + y * m.forward.x(), raised, compacted});
      }
    }
    if (!f.contact) continue;
    total.contact = true;
    footprint_.rear = std::min(footprint_.rear, r * std::sin(f.exit));
    footprint_.front = std::max(footprint_.front, r * std::sin(f.entry));
    total.entry = std::max(total.entry, f.entry);
    total.exit = std::min(total.exit, f.exit);
    total.normal += scale_ * f.normal;
    total.work += scale_ * f.work;
    total.spent += scale_ * f.spent;
    total.stored += scale_ * f.stored;
    const Vec3 up = Vec3::UnitZ(), lever = row.y * m.axis_end, low = lever - r * up;
    const Vec3 plane = scale_ * (f.fs * m.forward + f.fz * up), side = scale_ * f.side * m.axis_end;
    total.about_hub.f += plane + side;
    total.about_hub.t += lever.cross(plane) + low.cross(side) - scale_ * f.torque * m.axis_end;
    // d(force)/d(motion of the row), and the same as wrench about the hub.
    const auto add = [](Mat6& to_matrix, const Vec3& at, const Mat3& k3) {
      Mat3 x;
      x << 0, -at.z(), at.y(), at.z(), 0, -at.x(), -at.y(), at.x(), 0;
      to_matrix.topLeftCorner<3, 3>() += k3;
      to_matrix.topRightCorner<3, 3>() -= k3 * x;
      to_matrix.bottomLeftCorner<3, 3>() += x * k3;
      to_matrix.bottomRightCorner<3, 3>() -= x * k3 * x;
    };
    const Vec3 normal = f.normal_s * m.forward + f.normal_z * up,
               along = (f.normal_z * m.forward - f.normal_s * up) / normal.norm();
    const Mat3 across = m.axis_end * m.axis_end.transpose(), forth = along * along.transpose();
    add(total.K, lever, -scale_ * f.normal_slope * normal * normal.transpose());
    // Springs at rest; on the way the forces follow velocities.
    Mat6& into = f.rests ? total.K : total.D;
    const double rate = scale_ * (f.rests ? 1 : m.dt);
    add(into, lever, rate * std::min(0.0, f.along_slope) * forth);
    add(into, low, rate * f.side_slope * across);
    into.bottomRightCorner<3, 3>() -= rate * std::max(0.0, f.spin_slope) * across;
    add(total.D, lever, scale_ * f.along_rate * forth);
    add(total.D, low, scale_ * f.side_rate * across);
    total.D.bottomRightCorner<3, 3>() -= scale_ * f.spin_rate * across;
  }
  return total;
}

void FieldWheel::change(SoilField& field) {
  for (const SoilField::Change& c : changes_) field.apply(c);
  const double share = 1 - std::exp(-way_ / (kSweep * field.cell()));
  if (!(share > 0)) return;
  const SoilField::Footprint& f = footprint_;
  const double along = law_->radius + kSlide, across = 0.5 * width_ + kSlide,
               dx = std::abs(f.cos) * along + std::abs(f.sin) * across,
               dy = std::abs(f.sin) * along + std::abs(f.cos) * across;
  field.repose(f.x - dx, f.y - dy, f.x + dx, f.y + dy, f, share);
}

std::int64_t FieldWheel::steps() const {
  std::int64_t n = 0;
  for (const Row& r : rows_) n += r.plane.steps();
  return n;
}
std::int64_t FieldWheel::outside() const {
  std::int64_t n = 0;
  for (const Row& r : rows_) n += r.plane.outside();
  return n;
}

void FieldWheel::traverse(State& s) {
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const auto group = s.group("row" + std::to_string(j));
    s.field("s", rows_[j].s);
    rows_[j].plane.traverse(s);
  }
}

}  // namespace grouser::sdem
