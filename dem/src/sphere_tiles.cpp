#include "sphere_tiles.h"

#include <algorithm>
#include <cmath>

namespace grouser::dem {

namespace {

constexpr double kBeyond = 0.01;  ///< of the domain, beyond walls [m]

double mass(const GrainState& g) { return 4.0 / 3 * pi * g.radius * g.radius * g.radius * g.density; }

[[noreturn]] void refuse(const char* format, auto... a) {
  char text[400];
  std::snprintf(text, sizeof text, format, a...);
  throw DemError(text);
}

/// Changes of grains, the last one of each counts.
struct Changes {
  std::map<std::size_t, GrainState> of;
  void apply(Solver& solver) const {
    if (of.empty()) return;
    std::vector<std::size_t> numbers;
    std::vector<GrainState> states;
    for (const auto& [k, g] : of) {
      numbers.push_back(k);
      states.push_back(g);
    }
    solver.replace(numbers, states);
  }
};

}  // namespace

Tiles::Tiles(std::shared_ptr<const SphereBrick> brick, GroundPtr ground, const TilesSettings& s)
    : brick_(std::move(brick)),
      ground_(std::move(ground)),
      set_(s),
      base_(s.datum - s.depth - s.relief - brick_->largest),
      nx_(s.nx),
      ny_(s.ny),
      cells_x_(static_cast<int>(brick_->lx / brick_->largest)),
      cells_y_(static_cast<int>(brick_->ly / brick_->largest)),
      park_from_(s.depth + 2 * s.relief + 3 * brick_->largest + s.room) {
  parked_.assign(s.grains, 1);
  // The stack gives small numbers first.
  for (std::size_t k = s.grains; k-- > 0;) free_.push_back(static_cast<std::int64_t>(k));
  index_slots();
}

SolverSettings Tiles::fit(SolverSettings s) const {
  const double columns = std::floor(lx() / brick_->largest) * std::floor(ly() / brick_->largest);
  const double layers = std::ceil(static_cast<double>(set_.grains) / columns) + 1;
  const double beyond = set_.walls ? kBeyond : 0;
  s.domain.lo = Vec3(0, -beyond, -2 * brick_->largest);
  s.domain.hi = Vec3(lx(), ly() + beyond, park_from_ + layers * brick_->largest);
  s.domain.periodic = {true, !set_.walls, false};
  s.exchange = true;
  return s;
}

int Tiles::add_walls(Solver& solver, int material) const {
  const int walls = solver.add_body({}), first = solver.add_plane(walls, Vec3::Zero(), Vec3::UnitY(), material);
  solver.add_plane(walls, Vec3(0, ly(), 0), -Vec3::UnitY(), material);
  return first;
}

GrainState Tiles::in_park(std::size_t number, GrainState g) const {
  const auto nx = static_cast<std::size_t>(lx() / brick_->largest),
             ny = static_cast<std::size_t>(ly() / brick_->largest);
  const auto at = [&](std::size_t k) { return (static_cast<double>(k) + 0.5) * brick_->largest; };
  g.x = Vec3(at(number % nx), at(number / nx % ny), park_from_ + at(number / nx / ny));
  g.v = g.w = Vec3::Zero();
  g.frozen = true;
  return g;
}

std::vector<GrainState> Tiles::parked() const {
  std::vector<GrainState> out;
  const std::vector<GrainState>& any = brick_->parts.front();
  for (std::size_t k = 0; k < set_.grains; ++k) out.push_back(in_park(k, any[k % any.size()]));
  // No grain that takes a place later may be larger than all at the start.
  if (!out.empty()) out.front().radius = 0.5 * brick_->largest;
  return out;
}

Tile Tiles::at(double x, double y) const {
  const auto index = [](double u, double l) { return static_cast<std::int64_t>(std::floor(u / l)); };
  return {index(x, brick_->lx), set_.slab ? 0 : index(y, brick_->ly)};
}

std::size_t Tiles::slot_of(const GrainState& g) const {
  const int a = std::clamp(static_cast<int>(g.x[0] / brick_->lx), 0, nx_ - 1),
            b = std::clamp(static_cast<int>(g.x[1] / brick_->ly), 0, ny_ - 1);
  return static_cast<std::size_t>(a) * ny_ + b;
}

GrainState Tiles::local(GrainState g, const Tile& t) const {
  g.x[0] -= slot(t.i, nx_) * brick_->lx;
  g.x[1] -= slot(t.j, ny_) * brick_->ly;
  return g;
}
GrainState Tiles::on_torus(GrainState g, const Tile& t) const {
  g.x[0] += slot(t.i, nx_) * brick_->lx;
  g.x[1] += slot(t.j, ny_) * brick_->ly;
  return g;
}

std::optional<Vec3> Tiles::in_world(std::size_t number, const GrainState& g) const {
  if (parked_[number]) return std::nullopt;
  const std::int64_t a = slots_[slot_of(g)];
  if (a < 0) return std::nullopt;
  const Tile& t = active_[static_cast<std::size_t>(a)];
  Vec3 x = local(g, t).x;
  x[0] += static_cast<double>(t.i) * brick_->lx;
  x[1] += static_cast<double>(t.j) * brick_->ly;
  return x;
}

void Tiles::index_slots() {
  slots_.assign(static_cast<std::size_t>(nx_) * ny_, -1);
  for (std::size_t k = 0; k < active_.size(); ++k) slots_[slot_of(active_[k])] = static_cast<std::int64_t>(k);
}

bool Tiles::within(const std::vector<Tile>& tiles, const Tile& t) const {
  return std::binary_search(tiles.begin(), tiles.end(), t);
}

std::vector<GrainState> Tiles::fresh(const Tile& t) const {
  const double x0 = static_cast<double>(t.i) * brick_->lx, y0 = static_cast<double>(t.j) * brick_->ly;
  constexpr int n = 4;
  for (int a = 0; a <= n; ++a)
    for (int b = 0; b <= n; ++b) {
      const double x = x0 + brick_->lx * a / n, y = y0 + brick_->ly * b / n;
      const double off = ground_->height(x, y) - set_.datum;
      if (std::abs(off) > set_.relief + 1e-9)
        refuse(
            "the ground at (%.3f, %.3f) m lies %.4g m %s the datum %.4g m; soil was poured for a relief of %.4g m: set "
            "'relief' or "
            "'datum'",
            x, y, std::abs(off), off > 0 ? "above" : "below", set_.datum, set_.relief);
      if (const double turn = ground_->height(x, y) - ground_->height(x, y0); set_.slab && std::abs(turn) > 1e-6)
        refuse("the ground at x = %.3f m changes by %.3g m across the slab; a slab wants one profile along x", x, turn);
    }
  std::vector<GrainState> out;
  for (const GrainState& g : brick_->of(t.i, t.j)) {
    const double level = ground_->height(x0 + g.x[0], y0 + g.x[1]) - base_;
    if (g.x[2] <= level + brick_->lift && g.x[2] >= level - set_.depth - brick_->largest) out.push_back(g);
  }
  return out;
}

bool Tiles::held(const Tile& t, const GrainState& g, const std::vector<Tile>& active) const {
  const double w = brick_->largest;
  const int a = g.x[0] < w                 ? -1
                : g.x[0] >= brick_->lx - w ? 1
                                           : 0,
            b = set_.slab                  ? 0
                : g.x[1] < w               ? -1
                : g.x[1] >= brick_->ly - w ? 1
                                           : 0;
  if (a != 0 && !within(active, {t.i + a, t.j})) return true;
  if (b != 0 && !within(active, {t.i, t.j + b})) return true;
  if (a != 0 && b != 0 && !within(active, {t.i + a, t.j + b})) return true;
  const double level =
      ground_->height(static_cast<double>(t.i) * brick_->lx + g.x[0], static_cast<double>(t.j) * brick_->ly + g.x[1]) -
      base_;
  return g.x[2] < level - set_.depth;
}

std::map<Tile, std::vector<std::size_t>> Tiles::members(const std::vector<GrainState>& now) const {
  std::map<Tile, std::vector<std::size_t>> out;
  for (const Tile& t : active_) out[t];
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (parked_[k]) continue;
    const std::int64_t a = slots_[slot_of(now[k])];
    if (a >= 0) out[active_[static_cast<std::size_t>(a)]].push_back(k);
  }
  return out;
}

bool Tiles::activate(Solver& solver, std::vector<Tile> wanted, const Blocked& blocked) {
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (wanted == active_) return false;
  std::map<std::size_t, Tile> taken;
  for (const Tile& t : wanted)
    if (const auto [it, free] = taken.emplace(slot_of(t), t); !free)
      refuse(
          "the wheels are too far apart for the torus of %d x %d bricks: (%lld, %lld) and (%lld, %lld) want the same "
          "place; set 'torus' larger",
          nx_, ny_, static_cast<long long>(t.i), static_cast<long long>(t.j), static_cast<long long>(it->second.i),
          static_cast<long long>(it->second.j));
  const std::vector<GrainState> now = solver.grains();
  const auto of = members(now);
  Changes changes;
  const auto rest = [&](std::size_t k, GrainState g) {
    if (!g.frozen) momentum_ += mass(g) * g.v;
    g.v = g.w = Vec3::Zero();
    changes.of[k] = g;
    return g;
  };
  for (const auto& [t, numbers] : of) {
    if (within(wanted, t)) continue;
    std::vector<GrainState>& kept = store_[t];
    for (std::size_t k : numbers) {
      GrainState g = rest(k, now[k]);
      g.frozen = false;
      kept.push_back(local(g, t));
      changes.of[k] = in_park(k, g);
      parked_[k] = 1;
      free_.push_back(static_cast<std::int64_t>(k));
    }
  }
  for (const Tile& t : wanted) {
    if (within(active_, t)) {
      // Only the border of a tile whose neighbours change.
      bool due = false;
      for (int a = -1; a <= 1; ++a)
        for (int b = -1; b <= 1; ++b) {
          const Tile n{t.i + a, t.j + b};
          due = due || within(active_, n) != within(wanted, n);
        }
      if (!due) continue;
      for (std::size_t k : of.at(t)) {
        GrainState g = now[k];
        const bool hold = held(t, local(g, t), wanted);
        if (hold == g.frozen) continue;
        if (hold) g = rest(k, g);
        g.frozen = hold;
        changes.of[k] = g;
      }
      continue;
    }
    std::vector<GrainState> laid;
    if (const auto it = store_.find(t); it != store_.end()) {
      laid = std::move(it->second);
      store_.erase(it);
    } else {
      laid = fresh(t);
    }
    for (GrainState g : laid) {
      GrainState world = g;
      world.x[0] += static_cast<double>(t.i) * brick_->lx;
      world.x[1] += static_cast<double>(t.j) * brick_->ly;
      if (blocked(world)) {
        ++displaced_;
        continue;
      }
      if (free_.empty())
        refuse(
            "no grain is left for the brick at (%.3f, %.3f) m: %zu bricks are in the solver of %zu grains; set "
            "'capacity' "
            "larger or 'reach' smaller",
            static_cast<double>(t.i) * brick_->lx, static_cast<double>(t.j) * brick_->ly, wanted.size(), set_.grains);
      const auto k = static_cast<std::size_t>(free_.back());
      free_.pop_back();
      parked_[k] = 0;
      g.frozen = held(t, g, wanted);
      changes.of[k] = on_torus(g, t);
    }
  }
  active_ = std::move(wanted);
  index_slots();
  fresh_cache_ = false;
  stored_tops_.clear();
  changes.apply(solver);
  return true;
}

void Tiles::clear(Solver& solver, const Blocked& blocked) {
  const std::vector<GrainState> now = solver.grains();
  Changes changes;
  for (const auto& [t, numbers] : members(now))
    for (std::size_t k : numbers) {
      GrainState world = local(now[k], t);
      world.x[0] += static_cast<double>(t.i) * brick_->lx;
      world.x[1] += static_cast<double>(t.j) * brick_->ly;
      if (!blocked(world)) continue;
      momentum_ += mass(now[k]) * now[k].v;
      ++displaced_;
      changes.of[k] = in_park(k, now[k]);
      parked_[k] = 1;
      free_.push_back(static_cast<std::int64_t>(k));
    }
  changes.apply(solver);
  fresh_cache_ = false;
}

void Tiles::catch_strays(Solver& solver, const std::vector<GrainState>& now) {
  Changes changes;
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (parked_[k] || slots_[slot_of(now[k])] >= 0) continue;
    // The tile it flew from is next to this slot.
    const int si = static_cast<int>(slot_of(now[k])) / ny_, sj = static_cast<int>(slot_of(now[k])) % ny_;
    std::optional<Tile> to;
    constexpr int sides[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {-1, 1}, {1, -1}, {1, 1}};
    for (const auto& s : sides) {
      const std::int64_t a = slots_[static_cast<std::size_t>(slot(si + s[0], nx_)) * ny_ + slot(sj + s[1], ny_)];
      if (a < 0) continue;
      const Tile& from = active_[static_cast<std::size_t>(a)];
      to = Tile{from.i - s[0], from.j - s[1]};
      break;
    }
    if (!to) refuse("a grain was thrown over more than a brick within one step, at %.3g m/s", now[k].v.norm());
    const auto [it, first] = store_.try_emplace(*to);
    if (first) it->second = fresh(*to);
    GrainState g = local(now[k], *to);
    momentum_ += mass(g) * g.v;
    g.v = g.w = Vec3::Zero();
    g.frozen = false;
    // On top of what lies there.
    for (bool again = true; again;) {
      again = false;
      for (const GrainState& o : it->second) {
        const double reach = g.radius + o.radius, d2 = (g.x - o.x).head<2>().squaredNorm();
        if (d2 >= reach * reach || g.x[2] < o.x[2] - reach) continue;
        const double z = o.x[2] + std::sqrt(reach * reach - d2);
        if (g.x[2] < z - 1e-9) {
          g.x[2] = z;
          again = true;
        }
      }
    }
    it->second.push_back(g);
    stored_tops_.erase(*to);
    changes.of[k] = in_park(k, g);
    parked_[k] = 1;
    free_.push_back(static_cast<std::int64_t>(k));
    ++strays_;
  }
  changes.apply(solver);
}

std::vector<double> Tiles::tops(const std::vector<GrainState>& grains) const {
  std::vector<double> top(static_cast<std::size_t>(cells_x_) * cells_y_, 0.0);
  for (const GrainState& g : grains) {
    const int a = std::clamp(static_cast<int>(g.x[0] / brick_->lx * cells_x_), 0, cells_x_ - 1),
              b = std::clamp(static_cast<int>(g.x[1] / brick_->ly * cells_y_), 0, cells_y_ - 1);
    double& t = top[static_cast<std::size_t>(a) * cells_y_ + b];
    t = std::max(t, g.x[2] + g.radius);
  }
  return top;
}

const std::vector<double>& Tiles::fresh_tops(const Tile& t) const {
  const auto [it, first] = fresh_tops_.try_emplace(t);
  if (first) it->second = tops(fresh(t));
  return it->second;
}

void Tiles::refresh_tops(const std::vector<GrainState>& now) const {
  if (fresh_cache_) return;
  active_tops_.clear();
  for (const auto& [t, numbers] : members(now)) {
    std::vector<GrainState> own;
    for (std::size_t k : numbers) own.push_back(local(now[k], t));
    active_tops_[t] = tops(own);
  }
  fresh_cache_ = true;
}

const std::vector<double>* Tiles::tops_now(const Tile& t) const {
  if (const auto it = active_tops_.find(t); it != active_tops_.end()) return &it->second;
  const auto kept = store_.find(t);
  if (kept == store_.end()) return nullptr;
  const auto [it, first] = stored_tops_.try_emplace(t);
  if (first) it->second = tops(kept->second);
  return &it->second;
}

double Tiles::rise(double x, double y, const std::vector<GrainState>& now) const {
  refresh_tops(now);
  const Tile t = at(x, y);
  if (set_.slab) y -= ly() * std::floor(y / ly());
  const std::vector<double>* top = tops_now(t);
  if (!top) return 0;
  const int a = std::clamp(static_cast<int>((x / brick_->lx - static_cast<double>(t.i)) * cells_x_), 0, cells_x_ - 1),
            b = std::clamp(static_cast<int>((y / brick_->ly - static_cast<double>(t.j)) * cells_y_), 0, cells_y_ - 1);
  const std::size_t k = static_cast<std::size_t>(a) * cells_y_ + b;
  return (*top)[k] - fresh_tops(t)[k];
}

std::vector<Tiles::Square> Tiles::changed(const std::vector<GrainState>& now, double& size) {
  refresh_tops(now);
  size = brick_->lx / cells_x_;
  std::vector<Tile> all;
  for (const auto& e : active_tops_) all.push_back(e.first);
  for (const auto& e : store_) all.push_back(e.first);
  std::vector<Square> out;
  for (const Tile& t : all) {
    std::vector<double>& told = told_.try_emplace(t, static_cast<std::size_t>(cells_x_) * cells_y_, 0.0).first->second;
    for (std::size_t k = 0; k < told.size(); ++k) {
      const int a = static_cast<int>(k) / cells_y_, b = static_cast<int>(k) % cells_y_;
      const double rise = drawn(t, a, b);
      if (std::abs(rise - told[k]) < 1e-4) continue;
      told[k] = rise;
      out.push_back({(static_cast<double>(t.i) + (a + 0.5) / cells_x_) * brick_->lx,
                     (static_cast<double>(t.j) + (b + 0.5) / cells_y_) * brick_->ly, rise});
    }
  }
  return out;
}

double Tiles::drawn(const Tile& t, int a, int b) const {
  double sum = 0;
  int squares = 0;
  for (int i = a - 1; i <= a + 1; ++i)
    for (int j = b - 1; j <= b + 1; ++j) {
      const int di = i < 0 ? -1 : i / cells_x_, dj = j < 0 ? -1 : j / cells_y_;
      if (set_.walls && dj != 0) continue;
      ++squares;
      const Tile n{t.i + di, set_.slab ? t.j : t.j + dj};
      const std::vector<double>* top = tops_now(n);
      if (!top) continue;
      const auto k =
          static_cast<std::size_t>(i - di * cells_x_) * cells_y_ + static_cast<std::size_t>(j - dj * cells_y_);
      sum += (*top)[k] - fresh_tops(n)[k];
    }
  return sum / squares;
}

void Tiles::traverse(State& s) {
  const auto group = s.group("tiles");
  std::vector<std::int64_t> active, keys;
  std::vector<double> grains;
  for (const Tile& t : active_) active.insert(active.end(), {t.i, t.j});
  for (const auto& [t, kept] : store_) {
    keys.insert(keys.end(), {t.i, t.j, static_cast<std::int64_t>(kept.size())});
    for (const GrainState& g : kept) grains.insert(grains.end(), {g.x[0], g.x[1], g.x[2], g.radius, g.density});
  }
  s.field("active", active);
  s.field("free", free_);
  s.field("stored_tiles", keys);
  s.field("stored_grains", grains);
  s.field("momentum", momentum_);
  s.field("displaced", displaced_);
  s.field("strays", strays_);
  if (!s.loading()) return;
  active_.clear();
  for (std::size_t k = 0; k + 1 < active.size(); k += 2) active_.push_back({active[k], active[k + 1]});
  parked_.assign(set_.grains, 0);
  for (std::int64_t k : free_) parked_.at(static_cast<std::size_t>(k)) = 1;
  store_.clear();
  std::size_t at = 0;
  for (std::size_t k = 0; k + 2 < keys.size(); k += 3) {
    std::vector<GrainState>& kept = store_[{keys[k], keys[k + 1]}];
    for (std::int64_t n = 0; n < keys[k + 2]; ++n, at += 5) {
      GrainState g;
      g.x = Vec3(grains.at(at), grains.at(at + 1), grains.at(at + 2));
      g.radius = grains.at(at + 3);
      g.density = grains.at(at + 4);
      kept.push_back(g);
    }
  }
  index_slots();
  fresh_cache_ = false;
  stored_tops_.clear();
}

}  // namespace grouser::dem
