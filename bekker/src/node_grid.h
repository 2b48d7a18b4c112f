#pragma once
// Sparse grid of soil nodes: square tiles that exist where a gear has been, live while one is near, compact at rest.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <unordered_map>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/terrain.h"
#include "node_kernel.h"

namespace grouser::bekker::node {

/// Where the grid lies: p_W = origin + R(heading) p_grid. Laid out once, fixed in the world from then on.
struct Layout {
  Vec2 origin = Vec2::Zero();
  double heading = 0;
  double spacing = 0;  ///< 0 = not laid out yet
  Vec2 to_grid(double x, double y) const;
  Vec2 to_world(double u, double v) const;
};

/// Nodes i0..i1 - 1 by j0..j1 - 1 of the whole plane.
struct Box {
  std::int64_t i0 = 0, i1 = 0, j0 = 0, j1 = 0;
  bool empty() const { return i0 >= i1 || j0 >= j1; }
  bool meets(const Box& o) const { return i0 < o.i1 && o.i0 < i1 && j0 < o.j1 && o.j0 < j1; }
};

/// Memory on the boundaries of cache lines, where whole blocks are loaded fastest.
template <class T>
struct Aligned {
  using value_type = T;
  static constexpr std::align_val_t boundary{64};
  Aligned() = default;
  template <class U>
  Aligned(const Aligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), boundary)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, boundary); }
  bool operator==(const Aligned&) const { return true; }
};
using Nodes = std::vector<double, Aligned<double>>;

struct Tile {
  alignas(64) std::array<double, kTile> height;  ///< undisturbed ground [m]
  double top = 0;                                ///< its maximum
  std::vector<unsigned char> soil;               ///< material of each node; empty when the ground has one
  Nodes nodes;                                   ///< kFields * kTile, see place(); empty while untouched or at rest
  std::int64_t used = 0;                         ///< step in which a gear was near
  bool shown = true;                             ///< no change since the 3-D view asked
};

class NodeGrid {
 public:
  /// soil_at: index of the material at world (x, y); empty when there is one.
  NodeGrid(GroundPtr ground, std::function<int(double, double)> soil_at);

  bool laid_out() const { return layout_.spacing > 0; }
  void lay_out(const Layout& layout) { layout_ = layout; }
  void clear();
  /// Changes whenever pointers to tiles may have become stale.
  std::uint64_t generation() const { return generation_; }
  const Layout& layout() const { return layout_; }

  /// The tile of node (16 a, 16 b), with its heights; creates it. Pointers live as long as generation().
  Tile& near(std::int64_t a, std::int64_t b);
  /// Nodes of a tile for writing: wakes them from rest or makes new ones.
  double* wake(std::int64_t a, std::int64_t b, Tile& tile);
  /// The same without changing the grid: into `copy`.
  void copy_of(std::int64_t a, std::int64_t b, const Tile& tile, Nodes& copy) const;

  /// Nothing presses on these nodes any more: their shear is forgotten.
  void release(const Box& box);
  /// End of a step: tiles that no gear was near for a while go to rest.
  void tidy();
  std::int64_t step() const { return step_; }

  /// State of the node nearest to world (x, y): field, or the default of untouched soil.
  double value(Field f, double x, double y) const;
  /// Depth of the soil's surface below the undisturbed ground [m], bilinear between nodes.
  double rut(double x, double y) const;
  std::vector<Cell> take_changed_cells();

  std::size_t live_tiles() const { return live_.size(); }
  std::size_t resting_tiles() const { return rest_.size(); }
  std::size_t bytes() const;

  void traverse(State& s);

 private:
  struct Rest {
    std::array<float, kTile> zu, zs, ku;
  };
  using Key = std::uint64_t;
  static Key key(std::int64_t a, std::int64_t b);
  void expand(Key k, double* nodes) const;
  void default_nodes(double* nodes) const;
  double node_rut(std::int64_t i, std::int64_t j) const;

  GroundPtr ground_;
  std::function<int(double, double)> soil_at_;
  Layout layout_;
  std::unordered_map<Key, Tile> live_;
  std::unordered_map<Key, Rest> rest_;
  std::vector<Key> changed_at_rest_;  ///< went to rest before the view asked
  std::int64_t step_ = 0;
  std::uint64_t generation_ = 1;
};

}  // namespace grouser::bekker::node
