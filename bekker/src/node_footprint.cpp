#include "node_footprint.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker::node {

namespace {

void copy(const Vec3& v, double* out) {
  for (int k = 0; k < 3; ++k) out[k] = v[k];
}

std::int64_t floor_to(double x) { return static_cast<std::int64_t>(std::floor(x)); }

}  // namespace

void Footprint::prepare(const BodySpec& body, const BodyMotion& motion, NodeGrid& grid, bool commit) {
  motion_ = wheel_motion(body, motion, shape_.radius(), shape_.width());
  const Layout& layout = grid.layout();
  shape_.resolve(layout.spacing);
  R_ = Mat3(Eigen::AngleAxisd(layout.heading, Eigen::Vector3d::UnitZ()));
  const Mat3 C = R_.transpose() * motion_.carrier;
  Gear& g = gear_;
  copy(C.col(0), g.X);
  copy(C.col(1), g.Y);
  copy(C.col(2), g.Z);
  copy(R_.transpose() * motion_.V.v, g.V);
  copy(R_.transpose() * motion_.V.w, g.W);
  g.radius = shape_.radius();
  g.half_width = 0.5 * shape_.width();
  shape_.mean_lugs(g);
  g.spacing = layout.spacing;
  g.area = g.spacing * g.spacing;

  // Tiles that the gear's shadow touches.
  const Vec2 hub = layout.to_grid(motion_.pose.hub_W.x(), motion_.pose.hub_W.y());
  const double side = g.half_width + 0.5 * g.spacing;
  const auto shadow = [&](double reach, Box& box) {
    double lo[2], hi[2];
    for (int k = 0; k < 2; ++k) {
      const double half = std::abs(g.X[k]) * reach + std::abs(g.Y[k]) * side, lean = -g.radius * g.Z[k];
      lo[k] = hub[k] - half + std::min(lean, 0.0);
      hi[k] = hub[k] + half + std::max(lean, 0.0);
    }
    const double h = g.spacing;
    box = {floor_to(lo[0] / h), floor_to(hi[0] / h) + 2, floor_to(lo[1] / h), floor_to(hi[1] / h) + 2};
  };
  Box whole;
  shadow(g.radius, whole);
  spread_tiles(grid, whole.i0 >> 4, ((whole.i1 - 1) >> 4) + 1, whole.j0 >> 4, ((whole.j1 - 1) >> 4) + 1);
  double top = -INFINITY;
  for (Tile* t : tiles_) {
    top = std::max(top, t->top);
    if (commit) t->used = grid.step();
  }

  // Nodes that its surface can touch: where it lies below the highest ground around.
  const double hub_z = motion_.pose.hub_W.z();
  const double below = (hub_z - top - std::abs(g.Y[2]) * side) / g.Z[2];
  Box now;
  if (below < g.radius) {
    g.reach = below > 0 ? std::sqrt(g.radius * g.radius - below * below) : g.radius;
    shadow(g.reach, now);
  }
  // The nodes of the last step are let go by the same pass; a gear that was set elsewhere meanwhile lets go of them at once.
  const Box& last = last_;
  box_ = now;
  if (!last.empty() && (now.empty() || now.meets(last))) {
    if (now.empty())
      box_ = last;
    else
      box_ = {std::min(now.i0, last.i0), std::max(now.i1, last.i1), std::min(now.j0, last.j0),
              std::max(now.j1, last.j1)};
  }
  if (!box_.empty()) {  // whole blocks
    box_.j0 = box_.j0 & ~static_cast<std::int64_t>(kBlock - 1);
    box_.j1 = (box_.j1 + kBlock - 1) & ~static_cast<std::int64_t>(kBlock - 1);
  }
  if (commit && !last.empty() && !box_.meets(last)) grid.release(last);
  add_segments(grid, commit);
  // Only what the gear touches now has to be looked at in the next step.
  if (commit) last_ = now;
  if (shape_.smooth()) return;
  shape_.turn(Quat(Mat3(R_.transpose())) * (motion.X_WB_end.q * body.X_BG.q), g);
}

void Footprint::spread_tiles(NodeGrid& grid, std::int64_t a0, std::int64_t a1, std::int64_t b0, std::int64_t b1) {
  if (generation_ == grid.generation() && a0 == a0_ && a1 == a1_ && b0 == b0_ && b1 == b1_) return;
  tiles_.clear();
  for (std::int64_t a = a0; a < a1; ++a)
    for (std::int64_t b = b0; b < b1; ++b) tiles_.push_back(&grid.near(a, b));
  a0_ = a0;
  a1_ = a1;
  b0_ = b0;
  b1_ = b1;
  generation_ = grid.generation();
}

void Footprint::add_segments(NodeGrid& grid, bool commit) {
  segments_.clear();
  if (box_.empty()) return;
  const Vec2 hub = grid.layout().to_grid(motion_.pose.hub_W.x(), motion_.pose.hub_W.y());
  const double h = gear_.spacing;
  std::size_t copies = 0;
  for (std::int64_t a = box_.i0 >> 4; a <= (box_.i1 - 1) >> 4; ++a)
    for (std::int64_t b = box_.j0 >> 4; b <= (box_.j1 - 1) >> 4; ++b) {
      const bool near = a >= a0_ && a < a1_ && b >= b0_ && b < b1_;
      Tile& t = near ? *tiles_[static_cast<std::size_t>((a - a0_) * (b1_ - b0_) + (b - b0_))] : grid.near(a, b);
      Segment s{};
      if (commit) {
        s.nodes = grid.wake(a, b, t);
        t.shown = false;
      } else {
        if (copies_.size() <= copies) copies_.emplace_back();
        Nodes& c = copies_[copies++];
        grid.copy_of(a, b, t, c);
        s.nodes = c.data();
      }
      s.height = t.height.data();
      s.soil = t.soil.empty() ? nullptr : t.soil.data();
      s.x0 = static_cast<double>(a * kSide) * h - hub.x();
      s.y0 = static_cast<double>(b * kSide) * h - hub.y();
      s.base = -motion_.pose.hub_W.z();
      s.i0 = static_cast<int>(std::max(box_.i0 - a * kSide, std::int64_t{0}));
      s.i1 = static_cast<int>(std::min(box_.i1 - a * kSide, std::int64_t{kSide}));
      s.j0 = static_cast<int>(std::max(box_.j0 - b * kSide, std::int64_t{0}));
      s.j1 = static_cast<int>(std::min(box_.j1 - b * kSide, std::int64_t{kSide}));
      segments_.push_back(s);
    }
}

void Footprint::cover() {
  if (shape_.smooth()) return;
  surface_.resize(segments_.size() * 5 * kTile);
  for (std::size_t k = 0; k < segments_.size(); ++k) {
    segments_[k].surface = surface_.data() + k * 5 * kTile;
    shape_.cover(gear_, segments_[k], surface_.data() + k * 5 * kTile);
  }
}

}  // namespace grouser::bekker::node
