#pragma once
// Soil under a whole vehicle: square cells fixed in the world, made where wheels come. Every wheel reads and changes the same field, so a
// second wheel meets the rut of the first. Volume is kept: what a cell loses goes to another, or is counted as compacted.
//
//   sum over cells of (h + c) cell^2 = constant          c: compacted height                                      (R2)
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "grouser/terrain/state.h"
#include "grouser/terrain/terrain.h"

namespace grouser::sdem {

class SoilField {
  struct Tile;

 public:
  /// cell: side of a cell [m] > 0.
  SoilField(GroundPtr ground, double cell) : ground_(std::move(ground)), cell_(cell), per_cell_(1 / cell) {}
  SoilField(const SoilField&) = delete;
  SoilField& operator=(const SoilField&) = delete;

  /// Cells wherever there are none yet within the box. Not while others read.
  void lay(double x0, double y0, double x1, double y1);
  /// The tile of the last look-up: the next one is most often in it.
  class Near {
    friend class SoilField;
    const Tile* tile = nullptr;
    std::int64_t i = 0, j = 0;
  };
  /// Height now [m], bilinear between the cells' middles; of the ground where there are no cells.
  double height(double x, double y) const {
    Near near;
    return height(x, y, near);
  }
  double height(double x, double y, Near& near) const;
  bool has(double x, double y) const;

  /// Volume [m^3] to the cells around (x, y), by the shares with which `height` reads them. Cells must have been laid.
  struct Change {
    double x = 0, y = 0;
    double raised = 0, compacted = 0;  ///< [m^3]
  };
  void apply(const Change& c);

  /// A wheel's patch of soil: nothing slides into it.
  struct Footprint {
    double x = 0, y = 0, cos = 1, sin = 0;     ///< middle, heading
    double rear = 0, front = 0, half_width = 0;  ///< [m]
    bool holds(double px, double py) const;
  };
  /// Slopes over repose (31 degrees, or that of the ground as it was) give an eighth of what is too much, times share, to their neighbour: one
  /// sweep over the box; the same whatever the order of the cells.
  void repose(double x0, double y0, double x1, double y1, const Footprint& wheel,
              double share = 1);

  double cell() const { return cell_; }
  /// Sum of (h + c - ground) cell^2 [m^3] and of c cell^2.
  double added_volume() const;
  double compacted_volume() const;
  std::vector<Cell> take_changed();
  void traverse(State& s);

 private:
  static constexpr int kBits = 6;
  static constexpr std::int64_t kSide = 1 << kBits;  ///< cells along a tile
  struct Tile {
    std::vector<double> h, c, lain;
    std::vector<std::uint8_t> changed;
  };
  using Key = std::pair<std::int64_t, std::int64_t>;
  Tile make(Key k) const;
  const Tile* find(std::int64_t i, std::int64_t j) const;
  Tile* find(std::int64_t i, std::int64_t j);
  static std::size_t at(std::int64_t i, std::int64_t j);
  double cell_height(std::int64_t i, std::int64_t j) const;
  void number();

  GroundPtr ground_;
  double cell_, per_cell_;
  struct {
    std::vector<double> h, lain, down, right;
  } box_;  ///< of repose

  std::map<Key, Tile> tiles_;
  // Where a tile is, without a search: over the box of all of them.
  std::vector<Tile*> grid_;
  Key first_{0, 0}, many_{0, 0};
};

}  // namespace grouser::sdem
