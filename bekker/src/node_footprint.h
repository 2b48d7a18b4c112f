#pragma once
// The nodes that a gear may touch in a step, and the gear in the axes of the grid.
#include "grouser/terrain/wheel_motion.h"
#include "node_gear.h"
#include "node_grid.h"

namespace grouser::bekker::node {

class Footprint {
 public:
  explicit Footprint(const RunningGear& gear, Lugs lugs = Lugs::automatic, double least_lug = 0)
      : shape_(gear, lugs, least_lug) {}

  /// Find the nodes of this step. Serial: creates tiles. `commit` false leaves the soil as it is and works on copies.
  void prepare(const BodySpec& body, const BodyMotion& motion, NodeGrid& grid, bool commit);
  /// Lay the surface of a gear that is no smooth cylinder over the nodes; may run beside other gears.
  void cover();

  const WheelMotion& motion() const { return motion_; }
  Gear& gear() { return gear_; }
  const Mat3& to_world() const { return R_; }
  std::vector<Segment>& segments() { return segments_; }
  const GearShape& shape() const { return shape_; }
  const Box& box() const { return box_; }  ///< nodes that this step may write
  Box& last() { return last_; }            ///< nodes touched in the last step: the state

 private:
  void spread_tiles(NodeGrid& grid, std::int64_t a0, std::int64_t a1, std::int64_t b0, std::int64_t b1);
  void add_segments(NodeGrid& grid, bool commit);

  GearShape shape_;
  Box last_, box_;
  WheelMotion motion_;
  Gear gear_{};
  Mat3 R_ = Mat3::Identity();  ///< grid to world
  std::vector<Segment> segments_;
  std::vector<Nodes> copies_;  ///< of a trial
  Nodes surface_;
  // Tiles around the gear, kept while it stays over them.
  std::vector<Tile*> tiles_;
  std::int64_t a0_ = 0, a1_ = 0, b0_ = 0, b1_ = 0;
  std::uint64_t generation_ = 0;
};

}  // namespace grouser::bekker::node
