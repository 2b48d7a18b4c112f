#pragma once
// Which tiles of the world's soil are in the solver, and what became of the others (equation S1 and torus of sphere.h).
#include <compare>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/state.h"
#include "sphere_brick.h"

namespace grouser::dem {

struct Tile {
  std::int64_t i = 0, j = 0;
  auto operator<=>(const Tile&) const = default;
};

struct TilesSettings {
  double datum = 0;              ///< [m] middle of the heights that the ground may have
  double depth = 0, relief = 0;  ///< [m]
  double room = 0.1;             ///< [m] free height above the soil, below parked grains
  int nx = 8, ny = 8;            ///< tiles of the torus
  bool slab = false;             ///< one row of tiles j = 0, each its own neighbour across; ny is 1
  bool walls = false;            ///< of the slab, at y = 0 and ly, in place of that neighbour
  std::size_t grains = 0;        ///< of the solver
};

class Tiles {
 public:
  Tiles(std::shared_ptr<const SphereBrick> brick, GroundPtr ground, const TilesSettings& s);
  SolverSettings fit(SolverSettings s) const;
  /// Walls at y = 0 and y = ly; returns the number of the first one's surface, the second's is the next.
  int add_walls(Solver& solver, int material) const;
  std::vector<GrainState> parked() const;  ///< what the solver begins with: all grains above, frozen

  /// Whether a wheel is where this grain would be laid; x, y world, z of the solver.
  using Blocked = std::function<bool(const GrainState&)>;
  /// Makes these the tiles in the solver; false when they are already. Grains that are blocked are left out.
  bool activate(Solver& solver, std::vector<Tile> wanted, const Blocked& blocked);
  /// Takes away grains where a wheel is put at once.
  void clear(Solver& solver, const Blocked& blocked);
  /// Grains that flew beyond the tiles in the solver go to rest on the soil there.
  void catch_strays(Solver& solver, const std::vector<GrainState>& now);

  Tile at(double x, double y) const;
  const std::vector<Tile>& active() const { return active_; }
  /// A grain of the solver where it is in the world, z of the solver; nothing when it is parked or over no tile.
  std::optional<Vec3> in_world(std::size_t number, const GrainState& g) const;
  bool is_parked(std::size_t number) const { return parked_[number] != 0; }
  std::size_t stored_tiles() const { return store_.size(); }
  std::size_t free_grains() const { return free_.size(); }
  std::int64_t displaced() const { return displaced_; }
  double base() const { return base_; }           ///< [m] world height of z = 0 in the solver
  double lx() const { return nx_ * brick_->lx; }  ///< of the torus [m]
  double ly() const { return ny_ * brick_->ly; }

  /// Height of the surface less the undisturbed one at a place [m], from the highest grain tops of a square cell.
  double rise(double x, double y, const std::vector<GrainState>& now) const;
  struct Square {
    double x, y, rise;
  };
  /// Squares for drawing, as wide as the largest grain: rise as the mean over 3 x 3 of them (tops of single squares are as rough as
  /// grains). Those that differ by more than 0.1 mm from what was told before, and the side of a square. `rise` does not smooth.
  std::vector<Square> changed(const std::vector<GrainState>& now, double& size);
  void forget_cache() const { fresh_cache_ = false; }
  void traverse(State& s);

 private:
  int slot(std::int64_t i, int n) const { return static_cast<int>(((i % n) + n) % n); }
  std::size_t slot_of(const Tile& t) const { return static_cast<std::size_t>(slot(t.i, nx_)) * ny_ + slot(t.j, ny_); }
  std::size_t slot_of(const GrainState& g) const;
  /// Grain of the solver in the coordinates of its tile, and back.
  GrainState local(GrainState g, const Tile& t) const;
  GrainState on_torus(GrainState g, const Tile& t) const;
  GrainState in_park(std::size_t number, GrainState g) const;
  std::vector<GrainState> fresh(const Tile& t) const;
  bool held(const Tile& t, const GrainState& local, const std::vector<Tile>& active) const;
  bool within(const std::vector<Tile>& tiles, const Tile& t) const;
  std::map<Tile, std::vector<std::size_t>> members(const std::vector<GrainState>& now) const;
  std::vector<double> tops(const std::vector<GrainState>& local) const;
  const std::vector<double>& fresh_tops(const Tile& t) const;
  void refresh_tops(const std::vector<GrainState>& now) const;
  const std::vector<double>* tops_now(const Tile& t) const;
  /// Mean rise of a square and its eight neighbours (between walls: those that there are), across tiles; soil that never was in the solver has not risen.
  double drawn(const Tile& t, int a, int b) const;
  void index_slots();

  std::shared_ptr<const SphereBrick> brick_;
  GroundPtr ground_;
  TilesSettings set_;
  double base_;
  int nx_, ny_, cells_x_, cells_y_;
  double park_from_;
  std::vector<Tile> active_;         ///< sorted
  std::vector<std::int64_t> slots_;  ///< index into active_ or -1
  std::vector<std::uint8_t> parked_;
  std::vector<std::int64_t> free_;  ///< parked grains, a stack
  std::map<Tile, std::vector<GrainState>> store_;
  Vec3 momentum_ = Vec3::Zero();  ///< of grains put to rest [kg m/s]
  std::int64_t displaced_ = 0, strays_ = 0;
  // Found again from the rest.
  mutable std::map<Tile, std::vector<double>> fresh_tops_, active_tops_, stored_tops_;
  mutable bool fresh_cache_ = false;
  std::map<Tile, std::vector<double>> told_;
};

}  // namespace grouser::dem
