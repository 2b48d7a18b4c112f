#include "grouser/dem/rolling_bed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace grouser::dem {

namespace {

double mass(const GrainState& g) { return 4.0 / 3 * pi * g.radius * g.radius * g.radius * g.density; }

[[noreturn]] void refuse(const char* format, auto... a) {
  char text[300];
  std::snprintf(text, sizeof text, format, a...);
  throw DemError(std::string("rolling bed: ") + text);
}

}  // namespace

RollingBed::RollingBed(const Packing& brick, const RollingBedSettings& s)
    : brick_(brick), bricks_(s.bricks), ahead_(s.ahead), next_(s.bricks) {
  if (s.bricks < 4) refuse("%d bricks; at least 4", s.bricks);
  if (s.ahead < 1 || s.ahead > s.bricks - 3) refuse("%d bricks ahead; 1 to %d are allowed", s.ahead, s.bricks - 3);
  if (!(s.spare > 0 && s.room > 0)) refuse("spare and room must be positive; they are %g and %g m", s.spare, s.room);
  if (brick.walls || brick.slab) refuse("the brick was poured into a box; a periodic one is needed");
  if (brick.grains.empty()) refuse("the brick has %d grains", 0);
  for (GrainState& g : brick_.grains) {
    if (g.frozen) refuse("a brick with frozen grains cannot be laid");
    g.x[0] -= brick.lx * std::floor(g.x[0] / brick.lx);
    // No rounding of the solver may take a grain into the next slot.
    g.x[0] = std::clamp(g.x[0], 1e-8, brick.lx - 1e-8);
    g.v = g.w = Vec3::Zero();
    border_ = std::max(border_, 2 * g.radius);
    top_ = std::max(top_, g.x[2] + g.radius);
  }
  if (brick.lx < 4 * border_)
    refuse("the brick is %g m long; at least four of its largest grains, %g m", brick.lx, 4 * border_);
  store_from_ = top_ + s.room;
  spare_ = static_cast<std::size_t>(std::ceil(s.spare * static_cast<double>(brick.grains.size())));
  const std::size_t soil = static_cast<std::size_t>(bricks_) * brick.grains.size();
  for (std::size_t k = 0; k < spare_; ++k) store_.push_back(static_cast<std::int64_t>(soil + k));
}

SolverSettings RollingBed::fit(SolverSettings s) const {
  // Room for a store ten times as large as at the start.
  const double columns = std::max(1.0, std::floor(length() / border_)) * std::max(1.0, std::floor(brick_.ly / border_));
  const double layers = std::ceil(10 * static_cast<double>(spare_) / columns) + 1;
  s.domain.lo = Vec3(0, 0, -0.02);
  s.domain.hi = Vec3(length(), brick_.ly, store_from_ + layers * border_);
  s.domain.periodic = {true, true, false};
  s.exchange = true;
  return s;
}

GrainState RollingBed::in_storage(std::size_t place, GrainState g) const {
  const auto nx = static_cast<std::size_t>(std::max(1.0, std::floor(length() / border_))),
             ny = static_cast<std::size_t>(std::max(1.0, std::floor(brick_.ly / border_)));
  const auto at = [&](std::size_t k) { return (static_cast<double>(k) + 0.5) * border_; };
  g.x = Vec3(at(place % nx), at(place / nx % ny), store_from_ + at(place / nx / ny));
  g.v = g.w = Vec3::Zero();
  g.frozen = true;
  return g;
}

std::vector<GrainState> RollingBed::grains() const {
  std::vector<GrainState> out = tile(brick_.grains, brick_.lx, brick_.ly, bricks_, 1);
  // The seam is there from the start: frozen grains tell for certain on which side of it they lie.
  for (GrainState& g : out) g.frozen = g.x[0] < border_ || g.x[0] >= length() - border_;
  for (std::size_t k = 0; k < spare_; ++k) out.push_back(in_storage(k, brick_.grains[k % brick_.grains.size()]));
  return out;
}

double RollingBed::fresh_until() const { return static_cast<double>(next_) * brick_.lx; }

bool RollingBed::in_store(std::size_t number) const {
  return std::find(store_.begin(), store_.end(), static_cast<std::int64_t>(number)) != store_.end();
}

int RollingBed::follow(Solver& solver, double x) {
  const long under = static_cast<long>(std::floor(x / brick_.lx));
  // The last slot behind is frozen at its end.
  if (under < next_ - bricks_ + 1)
    refuse("the wheel at x = %g m is behind the soil that is left; it begins at %g m", x,
           static_cast<double>(next_ - bricks_ + 1) * brick_.lx);
  int laid = 0;
  for (; next_ <= under + ahead_; ++laid) lay(solver);
  return laid;
}

void RollingBed::lay(Solver& solver) {
  const double b = brick_.lx, whole = length();
  const double from = static_cast<double>(next_ % bricks_) * b;
  const std::vector<GrainState> now = solver.grains();
  std::vector<std::uint8_t> stored(now.size(), 0);
  for (std::int64_t k : store_) stored[static_cast<std::size_t>(k)] = 1;
  std::vector<std::size_t> numbers, own;
  std::vector<GrainState> states;
  const auto change = [&](std::size_t number, const GrainState& g) {
    if (!now[number].frozen) momentum_ += mass(now[number]) * now[number].v;
    numbers.push_back(number);
    states.push_back(g);
  };
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (stored[k]) continue;
    double x = now[k].x[0] - from;
    x -= whole * std::floor(x / whole);
    if (x < b) {
      own.push_back(k);
    } else if (x < b + border_) {
      // The end of what the wheel left behind.
      GrainState g = now[k];
      g.v = g.w = Vec3::Zero();
      g.frozen = true;
      change(k, g);
    } else if (now[k].frozen && x >= whole - border_) {
      // The end of the fresh soil so far, on which this brick follows.
      GrainState g = now[k];
      g.frozen = false;
      change(k, g);
    }
  }
  const std::size_t wanted = brick_.grains.size();
  if (own.size() + store_.size() < wanted)
    refuse(
        "%zu grains are missing in the slot to be laid and the store is empty: the wheel carries soil along; a longer "
        "bed or a "
        "larger 'spare' is needed",
        wanted - own.size() - store_.size());
  while (own.size() > wanted) {
    change(own.back(), in_storage(store_.size(), now[own.back()]));
    store_.push_back(static_cast<std::int64_t>(own.back()));
    own.pop_back();
  }
  while (own.size() < wanted) {
    own.push_back(static_cast<std::size_t>(store_.back()));
    store_.pop_back();
  }
  for (std::size_t k = 0; k < wanted; ++k) {
    GrainState g = brick_.grains[k];
    // As when the bricks were laid side by side at the start.
    g.frozen = g.x[0] >= b - border_;
    g.x[0] += from;
    change(own[k], g);
  }
  solver.replace(numbers, states);
  ++next_;
}

void RollingBed::traverse(State& s) {
  const auto g = s.group("rolling_bed");
  s.field("store", store_);
  s.field("next", next_);
  s.field("momentum", momentum_);
}

}  // namespace grouser::dem
