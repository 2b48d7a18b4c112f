#include "grouser/sdem/rut.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grouser::sdem {

namespace {

constexpr double kAhead = 20e-3, kBehind = 8e-3;  ///< lengths over which soil is spread [m]
constexpr int kPasses = 3;
constexpr double kTouch = 5e-4;  ///< [m]
constexpr double kRepose = 0.6;  ///< steepest slope, 31 degrees

/// Area between a chord over `a` and the circle of radius r above it, w the mean height of the circle there.
double bulge(double a, double w, double r) {
  w = std::max(w, 1e-3);
  return a * a * a / 12 * r * r / (w * w * w);
}

}  // namespace

std::ptrdiff_t Rut::index(double s) const {
  return static_cast<std::ptrdiff_t>(std::floor(s / column_)) - static_cast<std::ptrdiff_t>(base_);
}

void Rut::lay(double a, double b, const std::function<double(double)>& height) {
  const auto lo = static_cast<std::int64_t>(std::floor(a / column_)),
             hi = static_cast<std::int64_t>(std::floor(b / column_));
  const auto fresh = [&](std::int64_t k) { return height((static_cast<double>(k) + 0.5) * column_); };
  if (h_.empty()) base_ = lo;
  if (const auto n = static_cast<std::ptrdiff_t>(base_ - lo); n > 0) {
    // With room, so that a wheel that goes backward does not move every column at every step.
    const std::ptrdiff_t room = n + 64;
    std::vector<double> more;
    for (std::ptrdiff_t k = 0; k < room; ++k) more.push_back(fresh(base_ - room + k));
    base_ -= room;
    h_.insert(h_.begin(), more.begin(), more.end());
    before_.insert(before_.begin(), more.begin(), more.end());
    compacted_.insert(compacted_.begin(), more.size(), 0.0);
  }
  for (std::int64_t k = base_ + static_cast<std::int64_t>(h_.size()); k <= hi; ++k) {
    h_.push_back(fresh(k));
    before_.push_back(h_.back());
    compacted_.push_back(0);
  }
}

Overlap Rut::overlap(double s, double z) const {
  Overlap o;
  const double r = radius_;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(h_.size()), lo = std::max<std::ptrdiff_t>(0, index(s - r) - 1),
                       hi = std::min(n - 1, index(s + r) + 1);
  // The soil is a line through the columns' middles; pieces of it inside the disc, cut where they cross the rim.
  double d0 = 0, o0 = 0, w0 = 0;
  bool any = false, first = true;
  for (std::ptrdiff_t i = lo; i <= hi; ++i) {
    const double d = place(static_cast<std::size_t>(i)) - s;
    if (std::abs(d) >= r) continue;
    const double w = std::sqrt(r * r - d * d), over = before_[static_cast<std::size_t>(i)] - (z - w);
    if (!first && (over > 0 || o0 > 0)) {
      double a = d0, b = d, oa = o0, ob = over, wa = w0, wb = w;
      const double rise = (before_[static_cast<std::size_t>(i)] - before_[static_cast<std::size_t>(i - 1)]) / (d - d0);
      // Where the line and the rim cross, from a straight guess: two steps of Newton.
      const auto cross = [&] {
        double x = d0 + o0 / (o0 - over) * (d - d0);
        for (int k = 0; k < 2; ++k) {
          const double root = std::sqrt(std::max(1e-12, r * r - x * x)),
                       value = before_[static_cast<std::size_t>(i)] + rise * (x - d) - z + root,
                       change = rise - x / root;
          if (std::abs(change) > 1e-3) x = std::clamp(x - value / change, d0, d);
        }
        return x;
      };
      if (oa < 0) {
        a = cross();
        oa = 0;
        wa = std::sqrt(std::max(0.0, r * r - a * a));
      } else if (ob < 0) {
        b = cross();
        ob = 0;
        wb = std::sqrt(std::max(0.0, r * r - b * b));
      }
      // A piece of rim bulges by its curvature over its chord.
      o.area += 0.5 * (oa + ob) * (b - a) + bulge(b - a, 0.5 * (wa + wb), r);
      o.length += b - a;
      o.slope += wa - wb;
      if (!any) o.rear = a;
      o.front = b;
      any = true;
    }
    d0 = d;
    o0 = over;
    w0 = w;
    first = false;
  }
  return o;
}

/// Spreads volume [m^2] from column `from` on in direction `step`, falling off over `length`; a negative one is taken from there.
void Rut::put(std::ptrdiff_t from, int step, double volume, double length) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(h_.size());
  const int many = std::max(1, static_cast<int>(std::lround(2 * length / column_)));
  double sum = 0;
  int fit = 0;
  for (int k = 0; k < many; ++k) {
    const std::ptrdiff_t i = from + k * step;
    if (i < 0 || i >= n) break;
    sum += many - k;
    fit = k + 1;
  }
  for (int k = 0; k < fit; ++k) h_[static_cast<std::size_t>(from + k * step)] += volume / column_ * (many - k) / sum;
}

/// Slopes steeper than repose give half of what is too much to their neighbour: one sweep.
void Rut::repose(std::ptrdiff_t from, std::ptrdiff_t to) {
  from = std::max<std::ptrdiff_t>(0, from);
  to = std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(h_.size()) - 1, to);
  const double most = kRepose * column_;
  for (std::ptrdiff_t i = from; i < to; ++i) {
    double &a = h_[static_cast<std::size_t>(i)], &b = h_[static_cast<std::size_t>(i + 1)];
    const double step = a - b, natural = std::max(most, std::abs(before_[static_cast<std::size_t>(i)] -
                                                                 before_[static_cast<std::size_t>(i + 1)]));
    if (std::abs(step) <= natural) continue;
    const double give = 0.25 * (step - std::copysign(natural, step));
    a -= give;
    b += give;
  }
}

void Rut::displace(double s, double z, const Shares& shares) {
  const double r = radius_;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(h_.size()), lo = std::max<std::ptrdiff_t>(0, index(s - r)),
                       hi = std::min(n - 1, index(s + r));
  std::ptrdiff_t rear = -1, front = -1;
  // What is put beside the rim or slides under it is displaced again; what is still there then is compacted.
  for (int pass = 0; pass < kPasses; ++pass) {
    const bool last = pass + 1 == kPasses;
    double moved = 0;
    for (std::ptrdiff_t i = lo; i <= hi; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double d = place(k) - s;
      if (std::abs(d) >= r) continue;
      const double rim = z - std::sqrt(r * r - d * d), over = h_[k] - rim;
      if (over < 0) continue;
      if (rear < 0 || i < rear) rear = i;
      front = std::max(front, i);
      if (over == 0) continue;
      const double share = pass == 0 ? shares.compaction : last ? 1 : 0;
      h_[k] = rim;
      compacted_[k] += share * over;
      moved += (1 - share) * over * column_;
    }
    if (rear < 0 || last) break;
    const double dragged = pass == 0 ? shares.drag : 0;
    if (moved > 0 || dragged != 0) {
      const int ahead = shares.forward >= 0 ? 1 : -1;
      const std::ptrdiff_t lead = ahead > 0 ? front + 1 : rear - 1, trail = ahead > 0 ? rear - 1 : front + 1;
      const bool can_lead = lead >= 0 && lead < n, can_trail = trail >= 0 && trail < n;
      const double drag = can_lead && can_trail ? dragged : 0;
      const double to_lead = !can_trail ? moved : !can_lead ? 0 : shares.ahead * moved;
      put(lead, ahead, to_lead + drag, kAhead);
      put(trail, -ahead, moved - to_lead - drag, kBehind);
    }
    if (pass == 0) {
      repose(rear - 30, rear);
      repose(front, front + 30);
    }
  }
  // What the next pass meets: soil as it lies, once the wheel is over it no more; raised soil at once.
  const std::ptrdiff_t from = std::max<std::ptrdiff_t>(0, lo - 40), to = std::min(n - 1, hi + 40);
  for (std::ptrdiff_t i = from; i <= to; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (i < lo || i > hi) {
      before_[k] = h_[k];
      continue;
    }
    // Soil that was put against the rim bears nothing until the rim comes kTouch nearer: it would be contact of no depth.
    const double d = place(k) - s, rim = std::abs(d) < r ? z - std::sqrt(r * r - d * d) : z;
    before_[k] = std::max(before_[k], std::min(h_[k], rim - kTouch));
  }
}

double Rut::between(const std::vector<double>& h, double s) const {
  if (h.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const double u = s / column_ - 0.5 - static_cast<double>(base_);
  if (!(u >= 0) || !(u <= static_cast<double>(h.size() - 1))) return std::numeric_limits<double>::quiet_NaN();
  const auto i = std::min(static_cast<std::size_t>(u), h.size() - 2);
  const double t = u - static_cast<double>(i);
  return h[i] + t * (h[i + 1] - h[i]);
}

double Rut::height(double s) const { return between(h_, s); }
double Rut::before(double s) const { return between(before_, s); }

void Rut::renew(double s, double z, double a, double b, const std::function<double(double)>& height) {
  const auto lo = static_cast<std::int64_t>(std::floor(a / column_)),
             hi = static_cast<std::int64_t>(std::floor(b / column_));
  const auto old = base_;
  before_.swap(spare_before_);
  h_.swap(spare_h_);
  const std::vector<double>&before = spare_before_, &old_h = spare_h_;
  base_ = lo;
  const auto n = static_cast<std::size_t>(hi - lo + 1);
  h_.resize(n);
  before_.resize(n);
  compacted_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double d = place(i) - s, now = height(place(i));
    h_[i] = before_[i] = now;
    if (std::abs(d) >= radius_) continue;
    const double rim = z - std::sqrt(radius_ * radius_ - d * d) - kTouch;
    const std::int64_t k = lo + static_cast<std::int64_t>(i) - old;
    const bool known = k >= 0 && k < static_cast<std::int64_t>(before.size());
    if (!known) continue;
    const double was = before[static_cast<std::size_t>(k)];
    before_[i] = std::max(was, std::min(now, rim));  // as in displace
    // Soil under the rim keeps its shape: read back from the field it would be a little flatter at each step, and be moved again.
    if (old_h[static_cast<std::size_t>(k)] >= rim) h_[i] = old_h[static_cast<std::size_t>(k)];
  }
}

double Rut::volume() const {
  double sum = 0;
  for (std::size_t i = 0; i < h_.size(); ++i) sum += h_[i] + compacted_[i];
  return sum * column_;
}

double Rut::compacted() const {
  double sum = 0;
  for (const double c : compacted_) sum += c;
  return sum * column_;
}

void Rut::traverse(State& s) {
  s.field("base", base_);
  s.field("h", h_);
  s.field("before", before_);
  s.field("compacted", compacted_);
}

}  // namespace grouser::sdem
