#include "grouser/sdem/soil_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace grouser::sdem {

namespace {

constexpr double kRepose = 0.6;     ///< steepest slope, 31 degrees
constexpr double kNothing = 1e-12;  ///< [m] too little to be soil that slides

}  // namespace

std::size_t SoilField::at(std::int64_t i, std::int64_t j) {
  return static_cast<std::size_t>((i & (kSide - 1)) * kSide + (j & (kSide - 1)));
}

const SoilField::Tile* SoilField::find(std::int64_t i, std::int64_t j) const {
  const std::int64_t a = (i >> kBits) - first_.first, b = (j >> kBits) - first_.second;
  if (a < 0 || b < 0 || a >= many_.first || b >= many_.second) return nullptr;
  return grid_[static_cast<std::size_t>(a * many_.second + b)];
}
SoilField::Tile* SoilField::find(std::int64_t i, std::int64_t j) {
  return const_cast<Tile*>(static_cast<const SoilField&>(*this).find(i, j));
}

void SoilField::number() {
  grid_.clear();
  many_ = {0, 0};
  if (tiles_.empty()) return;
  Key lo = tiles_.begin()->first, hi = lo;
  for (const auto& [key, tile] : tiles_) {
    lo = {std::min(lo.first, key.first), std::min(lo.second, key.second)};
    hi = {std::max(hi.first, key.first), std::max(hi.second, key.second)};
  }
  first_ = lo;
  many_ = {hi.first - lo.first + 1, hi.second - lo.second + 1};
  grid_.assign(static_cast<std::size_t>(many_.first * many_.second), nullptr);
  for (auto& [key, tile] : tiles_)
    grid_[static_cast<std::size_t>((key.first - lo.first) * many_.second + key.second - lo.second)] = &tile;
}

SoilField::Tile SoilField::make(Key k) const {
  Tile t;
  for (std::int64_t i = 0; i < kSide; ++i)
    for (std::int64_t j = 0; j < kSide; ++j)
      t.lain.push_back(ground_->height((static_cast<double>(k.first * kSide + i) + 0.5) * cell_,
                                       (static_cast<double>(k.second * kSide + j) + 0.5) * cell_));
  t.h = t.lain;
  t.c.assign(t.h.size(), 0);
  t.changed.assign(t.h.size(), 0);
  return t;
}

void SoilField::lay(double x0, double y0, double x1, double y1) {
  const auto tile = [&](double x, std::int64_t more) {
    return (static_cast<std::int64_t>(std::floor(x / cell_)) + more) >> kBits;
  };
  bool any = false;
  for (std::int64_t i = tile(x0, -1); i <= tile(x1, 1); ++i)
    for (std::int64_t j = tile(y0, -1); j <= tile(y1, 1); ++j)
      if (!find(i << kBits, j << kBits)) any |= tiles_.emplace(Key{i, j}, make({i, j})).second;
  if (any) number();
}

double SoilField::cell_height(std::int64_t i, std::int64_t j) const {
  if (const Tile* t = find(i, j)) return t->h[at(i, j)];
  return ground_->height((static_cast<double>(i) + 0.5) * cell_, (static_cast<double>(j) + 0.5) * cell_);
}

double SoilField::height(double x, double y) const {
  const double u = x / cell_ - 0.5, v = y / cell_ - 0.5, fu = std::floor(u), fv = std::floor(v), a = u - fu, b = v - fv;
  const auto i = static_cast<std::int64_t>(fu), j = static_cast<std::int64_t>(fv);
  // All four cells in one tile: one look-up.
  const std::int64_t li = i & (kSide - 1), lj = j & (kSide - 1);
  if (li + 1 < kSide && lj + 1 < kSide) {
    if (const Tile* t = find(i, j)) {
      const double* h = t->h.data() + li * kSide + lj;
      return (1 - a) * ((1 - b) * h[0] + b * h[1]) + a * ((1 - b) * h[kSide] + b * h[kSide + 1]);
    }
  }
  return (1 - a) * ((1 - b) * cell_height(i, j) + b * cell_height(i, j + 1)) +
         a * ((1 - b) * cell_height(i + 1, j) + b * cell_height(i + 1, j + 1));
}

bool SoilField::has(double x, double y) const {
  return find(static_cast<std::int64_t>(std::floor(x / cell_)), static_cast<std::int64_t>(std::floor(y / cell_)));
}

void SoilField::apply(const Change& c) {
  const double u = c.x / cell_ - 0.5, v = c.y / cell_ - 0.5, fu = std::floor(u), fv = std::floor(v), a = u - fu,
               b = v - fv, area = cell_ * cell_;
  const auto i = static_cast<std::int64_t>(fu), j = static_cast<std::int64_t>(fv);
  const std::array<double, 4> share{(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b};
  const bool one = (i & (kSide - 1)) + 1 < kSide && (j & (kSide - 1)) + 1 < kSide;
  Tile* t = find(i, j);
  for (int k = 0; k < 4; ++k) {
    if (k > 0 && !one) t = find(i + k / 2, j + k % 2);
    if (!t) throw TerrainError("sdem.v2: soil was moved to where no cells were laid");
    const std::size_t n = at(i + k / 2, j + k % 2);
    t->h[n] += share[static_cast<std::size_t>(k)] * c.raised / area;
    t->c[n] += share[static_cast<std::size_t>(k)] * c.compacted / area;
    t->changed[n] = 1;
  }
}

bool SoilField::Footprint::holds(double px, double py) const {
  const double dx = px - x, dy = py - y, along = dx * cos + dy * sin, across = dy * cos - dx * sin;
  return along > rear && along < front && std::abs(across) < half_width;
}

void SoilField::repose(double x0, double y0, double x1, double y1, const Footprint& wheel,
                       double share) {
  const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)); };
  const std::int64_t i0 = index(x0), i1 = index(x1), j0 = index(y0), j1 = index(y1), nj = j1 - j0 + 1,
                     n = (i1 - i0 + 1) * nj;
  if (n <= 0) return;
  std::vector<double> h(static_cast<std::size_t>(n)), lain(h.size()), flow(h.size(), 0.0);
  bool any = false;
  for (std::int64_t i = i0; i <= i1; ++i)
    for (std::int64_t j = j0; j <= j1; ++j) {
      const Tile* t = find(i, j);
      if (!t) return;
      const auto k = static_cast<std::size_t>((i - i0) * nj + j - j0);
      h[k] = t->h[at(i, j)];
      lain[k] = t->lain[at(i, j)];
      any |= h[k] != lain[k];
    }
  if (!any) return;
  const double most = kRepose * cell_;
  // Flows from heights as they were, so that left and right are the same; a cell has four neighbours: an eighth each.
  const auto pair = [&](std::size_t a, std::size_t b, double ax, double ay, double bx, double by) {
    const double step = h[a] - h[b], natural = std::max(most, std::abs(lain[a] - lain[b]));
    if (std::abs(step) <= natural + kNothing || wheel.holds(ax, ay) || wheel.holds(bx, by)) return;
    const double give = 0.125 * share * (step - std::copysign(natural, step));
    flow[a] -= give;
    flow[b] += give;
  };
  for (std::int64_t i = i0; i <= i1; ++i)
    for (std::int64_t j = j0; j <= j1; ++j) {
      const auto k = static_cast<std::size_t>((i - i0) * nj + j - j0);
      const double x = (static_cast<double>(i) + 0.5) * cell_, y = (static_cast<double>(j) + 0.5) * cell_;
      if (i < i1) pair(k, k + static_cast<std::size_t>(nj), x, y, x + cell_, y);
      if (j < j1) pair(k, k + 1, x, y, x, y + cell_);
    }
  for (std::int64_t i = i0; i <= i1; ++i)
    for (std::int64_t j = j0; j <= j1; ++j)
      if (const double f = flow[static_cast<std::size_t>((i - i0) * nj + j - j0)]; f != 0) {
        Tile* t = find(i, j);
        t->h[at(i, j)] += f;
        t->changed[at(i, j)] = 1;
      }
}

double SoilField::added_volume() const {
  double sum = 0;
  for (const auto& [key, t] : tiles_)
    for (std::size_t k = 0; k < t.h.size(); ++k) sum += (t.h[k] - t.lain[k]) + t.c[k];
  return sum * cell_ * cell_;
}

double SoilField::compacted_volume() const {
  double sum = 0;
  for (const auto& [key, t] : tiles_)
    for (const double c : t.c) sum += c;
  return sum * cell_ * cell_;
}

std::vector<Cell> SoilField::take_changed() {
  std::vector<Cell> out;
  for (auto& [key, t] : tiles_)
    for (std::size_t k = 0; k < t.h.size(); ++k) {
      if (!t.changed[k]) continue;
      t.changed[k] = 0;
      const auto i = key.first * kSide + static_cast<std::int64_t>(k) / kSide,
                 j = key.second * kSide + static_cast<std::int64_t>(k) % kSide;
      out.push_back({(static_cast<double>(i) + 0.5) * cell_, (static_cast<double>(j) + 0.5) * cell_, cell_, t.h[k],
                     t.lain[k] - t.h[k]});
    }
  return out;
}

void SoilField::traverse(State& s) {
  std::vector<std::int64_t> keys;
  std::vector<double> h, c;
  std::vector<std::uint8_t> changed;
  for (const auto& [key, t] : tiles_) {
    keys.insert(keys.end(), {key.first, key.second});
    h.insert(h.end(), t.h.begin(), t.h.end());
    c.insert(c.end(), t.c.begin(), t.c.end());
    changed.insert(changed.end(), t.changed.begin(), t.changed.end());
  }
  s.field("tiles", keys);
  s.field("h", h);
  s.field("compacted", c);
  s.field("changed", changed);
  if (!s.loading()) return;
  constexpr std::size_t kMany = kSide * kSide;
  const std::size_t n = keys.size() / 2;
  if (keys.size() % 2 || h.size() != n * kMany || c.size() != h.size() || changed.size() != h.size())
    throw StateError("sdem.v2: tiles of soil and their cells do not fit each other");
  std::map<Key, Tile> tiles;
  for (std::size_t k = 0; k < n; ++k) {
    const Key key{keys[2 * k], keys[2 * k + 1]};
    const auto old = tiles_.find(key);
    Tile t = old != tiles_.end() ? old->second : make(key);
    const auto from = static_cast<std::ptrdiff_t>(k * kMany), to = from + static_cast<std::ptrdiff_t>(kMany);
    t.h.assign(h.begin() + from, h.begin() + to);
    t.c.assign(c.begin() + from, c.begin() + to);
    t.changed.assign(changed.begin() + from, changed.begin() + to);
    tiles.emplace(key, std::move(t));
  }
  tiles_ = std::move(tiles);
  number();
}

}  // namespace grouser::sdem
