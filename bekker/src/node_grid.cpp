#include "node_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace grouser::bekker::node {

namespace {

constexpr std::int64_t kPatience = 200;  // steps that a tile stays live after the last gear was near
constexpr int kView = 4;                 // nodes along a cell of the 3-D view

std::int64_t tile_of(std::int64_t i) { return i >> 4; }
static_assert(kSide == 16);
int in_tile(std::int64_t i, std::int64_t j) { return static_cast<int>((i & (kSide - 1)) * kSide + (j & (kSide - 1))); }

}  // namespace

Vec2 Layout::to_grid(double x, double y) const {
  const double c = std::cos(heading), s = std::sin(heading), dx = x - origin.x(), dy = y - origin.y();
  return {c * dx + s * dy, -s * dx + c * dy};
}

Vec2 Layout::to_world(double u, double v) const {
  const double c = std::cos(heading), s = std::sin(heading);
  return {origin.x() + c * u - s * v, origin.y() + s * u + c * v};
}

NodeGrid::NodeGrid(GroundPtr ground, std::function<int(double, double)> soil_at)
    : ground_(std::move(ground)), soil_at_(std::move(soil_at)) {}

NodeGrid::Key NodeGrid::key(std::int64_t a, std::int64_t b) {
  // Offset, so that keys sort by (a, b).
  return (static_cast<Key>(a + (1LL << 31)) << 32) | static_cast<std::uint32_t>(b + (1LL << 31));
}

Tile& NodeGrid::near(std::int64_t a, std::int64_t b) {
  const auto [it, made] = live_.try_emplace(key(a, b));
  Tile& t = it->second;
  if (made) {
    const double h = layout_.spacing;
    const Vec2 along = layout_.to_world(0, h) - layout_.to_world(0, 0);
    for (int i = 0; i < kSide; ++i) {
      const Vec2 p = layout_.to_world((static_cast<double>(a * kSide) + i) * h, static_cast<double>(b * kSide) * h);
      ground_->heights(p.x(), p.y(), along.x(), along.y(), kSide, t.height.data() + i * kSide);
      if (!soil_at_) continue;
      t.soil.resize(kTile);
      for (int j = 0; j < kSide; ++j)
        t.soil[i * kSide + j] = static_cast<unsigned char>(soil_at_(p.x() + j * along.x(), p.y() + j * along.y()));
    }
    t.top = *std::max_element(t.height.begin(), t.height.end());
    t.used = step_;
  }
  return t;
}

void NodeGrid::clear() {
  layout_ = {};
  live_.clear();
  rest_.clear();
  ++generation_;
}

void NodeGrid::default_nodes(double* nodes) const {
  std::fill(nodes, nodes + kFields * kTile, 0.0);
  for (int n = 0; n < kTile; ++n) nodes[place(kKu, n)] = 1;
}

void NodeGrid::expand(Key k, double* nodes) const {
  default_nodes(nodes);
  const auto it = rest_.find(k);
  if (it == rest_.end()) return;
  for (int n = 0; n < kTile; ++n) {
    nodes[place(kZu, n)] = static_cast<double>(it->second.zu[n]);
    nodes[place(kZs, n)] = static_cast<double>(it->second.zs[n]);
    nodes[place(kKu, n)] = static_cast<double>(it->second.ku[n]);
  }
}

double* NodeGrid::wake(std::int64_t a, std::int64_t b, Tile& tile) {
  if (tile.nodes.empty()) {
    tile.nodes.resize(kFields * kTile);
    expand(key(a, b), tile.nodes.data());
    rest_.erase(key(a, b));
  }
  return tile.nodes.data();
}

void NodeGrid::copy_of(std::int64_t a, std::int64_t b, const Tile& tile, Nodes& copy) const {
  if (!tile.nodes.empty()) {
    copy = tile.nodes;
    return;
  }
  copy.resize(kFields * kTile);
  expand(key(a, b), copy.data());
}

void NodeGrid::release(const Box& box) {
  for (std::int64_t i = box.i0; i < box.i1; ++i)
    for (std::int64_t j = box.j0; j < box.j1; ++j) {
      const auto it = live_.find(key(tile_of(i), tile_of(j)));
      if (it == live_.end() || it->second.nodes.empty()) continue;
      for (const Field f : {kZ, kCover, kJ, kY, kU1, kU2, kG, kRut}) it->second.nodes[place(f, in_tile(i, j))] = 0;
    }
}

void NodeGrid::tidy() {
  if (++step_ % kPatience != 0) return;
  ++generation_;
  for (auto it = live_.begin(); it != live_.end();) {
    Tile& t = it->second;
    const auto some = [&](Field f) {
      for (int n = 0; n < kTile && !t.nodes.empty(); ++n)
        if (t.nodes[place(f, n)] > 0) return true;
      return false;
    };
    const bool pressed = some(kCover);
    if (pressed || t.used > step_ - kPatience) {
      ++it;
      continue;
    }
    if (some(kZu)) {
      Rest& r = rest_[it->first];
      for (int n = 0; n < kTile; ++n) {
        r.zu[n] = static_cast<float>(t.nodes[place(kZu, n)]);
        r.zs[n] = static_cast<float>(t.nodes[place(kZs, n)]);
        r.ku[n] = static_cast<float>(t.nodes[place(kKu, n)]);
      }
      if (!t.shown) changed_at_rest_.push_back(it->first);
    }
    it = live_.erase(it);
  }
}

double NodeGrid::value(Field f, double x, double y) const {
  if (!laid_out()) return 0;
  const Vec2 p = layout_.to_grid(x, y) / layout_.spacing;
  const auto i = static_cast<std::int64_t>(std::llround(p.x())), j = static_cast<std::int64_t>(std::llround(p.y()));
  const Key k = key(tile_of(i), tile_of(j));
  const int n = in_tile(i, j);
  if (const auto it = live_.find(k); it != live_.end() && !it->second.nodes.empty())
    return it->second.nodes[place(f, n)];
  if (const auto it = rest_.find(k); it != rest_.end())
    return static_cast<double>(f == kZu   ? it->second.zu[n]
                               : f == kZs ? it->second.zs[n]
                               : f == kKu ? it->second.ku[n]
                                          : 0.0f);
  return 0;
}

double NodeGrid::node_rut(std::int64_t i, std::int64_t j) const {
  const Key k = key(tile_of(i), tile_of(j));
  const int n = in_tile(i, j);
  if (const auto it = live_.find(k); it != live_.end() && !it->second.nodes.empty()) {
    const Nodes& nodes = it->second.nodes;
    return nodes[place(nodes[place(kCover, n)] > 0 ? kZ : kZs, n)];
  }
  const auto it = rest_.find(k);
  return it == rest_.end() ? 0.0 : static_cast<double>(it->second.zs[n]);
}

double NodeGrid::rut(double x, double y) const {
  if (!laid_out()) return 0;
  const Vec2 p = layout_.to_grid(x, y) / layout_.spacing;
  const double fi = std::floor(p.x()), fj = std::floor(p.y()), u = p.x() - fi, v = p.y() - fj;
  const auto i = static_cast<std::int64_t>(fi), j = static_cast<std::int64_t>(fj);
  return (1 - u) * ((1 - v) * node_rut(i, j) + v * node_rut(i, j + 1)) +
         u * ((1 - v) * node_rut(i + 1, j) + v * node_rut(i + 1, j + 1));
}

std::vector<Cell> NodeGrid::take_changed_cells() {
  std::vector<Key> keys = std::move(changed_at_rest_);
  changed_at_rest_.clear();
  for (auto& [k, t] : live_)
    if (!t.shown) {
      keys.push_back(k);
      t.shown = true;
    }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::vector<Cell> cells;
  const double h = layout_.spacing;
  for (const Key k : keys) {
    const auto a = static_cast<std::int64_t>(k >> 32) - (1LL << 31);
    const auto b = static_cast<std::int64_t>(k & 0xffffffffu) - (1LL << 31);
    for (int i = 0; i < kSide; i += kView)
      for (int j = 0; j < kSide; j += kView) {
        double rut = 0;
        for (int n = 0; n < kView * kView; ++n)
          rut += node_rut(a * kSide + i + n / kView, b * kSide + j + n % kView) / (kView * kView);
        if (rut == 0) continue;
        const Vec2 p = layout_.to_world((static_cast<double>(a * kSide) + i + 0.5 * (kView - 1)) * h,
                                        (static_cast<double>(b * kSide) + j + 0.5 * (kView - 1)) * h);
        cells.push_back({p.x(), p.y(), kView * h, ground_->height(p.x(), p.y()) - rut, rut});
      }
  }
  return cells;
}

std::size_t NodeGrid::bytes() const {
  std::size_t n = rest_.size() * (sizeof(Rest) + sizeof(Key));
  for (const auto& [k, t] : live_) n += sizeof(Tile) + sizeof(Key) + t.nodes.size() * sizeof(double) + t.soil.size();
  return n;
}

void NodeGrid::traverse(State& s) {
  s.field("origin", layout_.origin);
  s.field("heading", layout_.heading);
  s.field("spacing", layout_.spacing);
  s.field("step", step_);
  // Tiles in the order of their keys; those without touched nodes are no state.
  std::vector<std::int64_t> live, used, rest;
  std::vector<double> nodes;
  std::vector<std::uint8_t> packed;
  if (!s.loading()) {
    for (const auto& [k, t] : live_)
      if (!t.nodes.empty()) live.push_back(static_cast<std::int64_t>(k));
    for (const auto& [k, r] : rest_) rest.push_back(static_cast<std::int64_t>(k));
    std::sort(live.begin(), live.end());
    std::sort(rest.begin(), rest.end());
    for (const std::int64_t k : live) {
      const Tile& t = live_.at(static_cast<Key>(k));
      used.push_back(t.used);
      nodes.insert(nodes.end(), t.nodes.begin(), t.nodes.end());
    }
    packed.resize(rest.size() * sizeof(Rest));
    for (std::size_t n = 0; n < rest.size(); ++n)
      std::memcpy(packed.data() + n * sizeof(Rest), &rest_.at(static_cast<Key>(rest[n])), sizeof(Rest));
  }
  s.field("live", live);
  s.field("used", used);
  s.field("nodes", nodes);
  s.field("resting", rest);
  s.field("packed", packed);
  if (!s.loading()) return;
  if (used.size() != live.size() || nodes.size() != live.size() * kFields * kTile ||
      packed.size() != rest.size() * sizeof(Rest))
    throw StateError("soil nodes: the sizes of the stored tiles do not agree");
  live_.clear();
  rest_.clear();
  ++generation_;
  changed_at_rest_.assign(rest.begin(), rest.end());  // the view has seen none of it
  for (std::size_t n = 0; n < live.size(); ++n) {
    const auto k = static_cast<Key>(live[n]);
    Tile& t = near(static_cast<std::int64_t>(k >> 32) - (1LL << 31),
                   static_cast<std::int64_t>(k & 0xffffffffu) - (1LL << 31));
    t.used = used[n];
    t.shown = false;
    const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(n * kFields * kTile);
    t.nodes.assign(first, first + kFields * kTile);
  }
  for (std::size_t n = 0; n < rest.size(); ++n)
    std::memcpy(&rest_[static_cast<Key>(rest[n])], packed.data() + n * sizeof(Rest), sizeof(Rest));
}

}  // namespace grouser::bekker::node
