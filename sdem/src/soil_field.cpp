#include "grouser/sdem/soil_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace grouser::sdem {

namespace {

constexpr double kRepose = 0.6;     ///< steepest slope, 31 degrees
constexpr double kNothing = 1e-12;  ///< [m] too little to be soil that slides

/// floor, without a call.
std::int64_t below(double u) {
  const auto i = static_cast<std::int64_t>(u);
  return i - (u < static_cast<double>(i));
}

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

double SoilField::height(double x, double y, Near& near) const {
  const double u = x * per_cell_ - 0.5, v = y * per_cell_ - 0.5;
  const std::int64_t i = below(u), j = below(v);
  const double a = u - static_cast<double>(i), b = v - static_cast<double>(j);
  // All four cells in one tile: one look-up.
  const std::int64_t li = i & (kSide - 1), lj = j & (kSide - 1);
  if (li + 1 < kSide && lj + 1 < kSide) {
    if (!near.tile || i >> kBits != near.i || j >> kBits != near.j) {
      near.tile = find(i, j);
      near.i = i >> kBits;
      near.j = j >> kBits;
    }
    if (near.tile) {
      const double* h = near.tile->h.data() + li * kSide + lj;
      return (1 - a) * ((1 - b) * h[0] + b * h[1]) + a * ((1 - b) * h[kSide] + b * h[kSide + 1]);
    }
  }
  return (1 - a) * ((1 - b) * cell_height(i, j) + b * cell_height(i, j + 1)) +
         a * ((1 - b) * cell_height(i + 1, j) + b * cell_height(i + 1, j + 1));
}

bool SoilField::has(double x, double y) const { return find(below(x / cell_), below(y / cell_)); }

void SoilField::apply(const Change& c) {
  const double u = c.x * per_cell_ - 0.5, v = c.y * per_cell_ - 0.5, per_area = per_cell_ * per_cell_;
  const std::int64_t i = below(u), j = below(v);
  const double a = u - static_cast<double>(i), b = v - static_cast<double>(j);
  const std::array<double, 4> share{(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b};
  const bool one = (i & (kSide - 1)) + 1 < kSide && (j & (kSide - 1)) + 1 < kSide;
  const double raised = c.raised * per_area, compacted = c.compacted * per_area;
  Tile* t = find(i, j);
  for (int k = 0; k < 4; ++k) {
    if (k > 0 && !one) t = find(i + k / 2, j + k % 2);
    if (!t) throw TerrainError("sdem.v2: soil was moved to where no cells were laid");
    const std::size_t n = at(i + k / 2, j + k % 2);
    t->h[n] += share[static_cast<std::size_t>(k)] * raised;
    t->c[n] += share[static_cast<std::size_t>(k)] * compacted;
    t->changed[n] = 1;
  }
}

bool SoilField::Footprint::holds(double px, double py) const {
  const double dx = px - x, dy = py - y, along = dx * cos + dy * sin, across = dy * cos - dx * sin;
  return along > rear && along < front && std::abs(across) < half_width;
}

void SoilField::repose(double x0, double y0, double x1, double y1, const Footprint& wheel, double share) {
  const std::int64_t i0 = below(x0 / cell_), i1 = below(x1 / cell_), j0 = below(y0 / cell_), j1 = below(y1 / cell_),
                     nj = j1 - j0 + 1;
  if (i1 < i0 || nj <= 0) return;
  const auto line = static_cast<std::size_t>(nj), n = static_cast<std::size_t>(i1 - i0 + 1) * line;
  std::vector<double>&h = box_.h, &lain = box_.lain, &down = box_.down, &right = box_.right;
  h.resize(n);
  lain.resize(n);
  // Cells of a line of the box that lie in one tile lie behind each other. False where no cells were laid.
  const auto pieces = [&](const auto& each) {
    for (std::int64_t i = i0; i <= i1; ++i)
      for (std::int64_t j = j0; j <= j1;) {
        const std::int64_t end = std::min(j1 + 1, (j | (kSide - 1)) + 1);
        Tile* t = find(i, j);
        if (!t) return false;
        each(*t, at(i, j), static_cast<std::size_t>((i - i0) * nj + j - j0), static_cast<std::size_t>(end - j));
        j = end;
      }
    return true;
  };
  bool any = false;
  if (!pieces([&](const Tile& t, std::size_t from, std::size_t to, std::size_t many) {
        for (std::size_t k = 0; k < many; ++k) {
          h[to + k] = t.h[from + k];
          lain[to + k] = t.lain[from + k];
          any |= h[to + k] != lain[to + k];
        }
      }))
    return;
  if (!any) return;
  const double most = kRepose * cell_;
  down.assign(n, 0);
  right.assign(n, 0);
  any = false;
  // What each cell of a line gives to that `beside` it, from heights as they were: left and right are the same. A cell has four neighbours:
  // an eighth each.
  const auto flows = [&](std::size_t from, std::size_t many, std::size_t beside, double dx, double dy,
                         std::vector<double>& flow) {
    int steep = 0;  // most lines have none
    for (std::size_t k = from; k < from + many; ++k)
      steep |= std::abs(h[k] - h[k + beside]) > std::max(most, std::abs(lain[k] - lain[k + beside])) + kNothing;
    if (!steep) return;
    for (std::size_t k = from; k < from + many; ++k) {
      const double step = h[k] - h[k + beside], natural = std::max(most, std::abs(lain[k] - lain[k + beside]));
      if (std::abs(step) <= natural + kNothing) continue;
      const double x = (static_cast<double>(i0 + static_cast<std::int64_t>(k / line)) + 0.5) * cell_,
                   y = (static_cast<double>(j0 + static_cast<std::int64_t>(k % line)) + 0.5) * cell_;
      if (wheel.holds(x, y) || wheel.holds(x + dx, y + dy)) continue;
      flow[k] = 0.125 * share * (step - std::copysign(natural, step));
      any = true;
    }
  };
  for (std::size_t k = 0; k < n; k += line) {
    if (k + line < n) flows(k, line, line, cell_, 0, down);
    flows(k, line - 1, 1, 0, cell_, right);
  }
  if (!any) return;
  pieces([&](Tile& t, std::size_t to, std::size_t from, std::size_t many) {
    for (std::size_t k = from; k < from + many; ++k) {
      const double f = ((k >= line ? down[k - line] : 0) - down[k]) + ((k % line ? right[k - 1] : 0) - right[k]);
      if (f == 0) continue;
      t.h[to + k - from] += f;
      t.changed[to + k - from] = 1;
    }
  });
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
