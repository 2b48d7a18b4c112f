#pragma once
// Bodies and their surfaces: motion, lists of contacts per chunk of grains, geometry, sums of force.
#include <vector>

#include "grouser/dem/solver.h"
#include "lists.h"
#include "shape.h"

namespace grouser::dem {

struct Body {
  BodySettings set;
  Pose X;
  Twist V;
  SurfaceReport report;
};
struct Surface {
  int body = 0, material = 0;
  Shape shape;
  SurfaceReport report;
};

template <class R>
class Bodies {
 public:
  std::vector<Body> bodies;
  std::vector<Surface> surfaces;

  /// Bound of the speed of any point of a surface [m/s].
  double fastest() const;
  /// List of grains with a gap below `margin`; histories move along.
  void refresh(const Space<R>& space, double margin, const Array<Grain<R>>& grains, const std::vector<Chunk>& chunks,
               const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& material,
               const MaterialTable& table);
  /// Places of the grains after a sort.
  void renumber(const std::vector<std::uint32_t>& moved_to);
  /// Normal, overlap and surface velocity of the contacts of a chunk.
  void geometry(std::size_t chunk, const Space<R>& space, const Array<Grain<R>>& grains);
  /// Forget the contacts (a surface was added).
  void clear() {
    blocks_.clear();
    runs_.clear();
  }
  bool empty() const { return surfaces.empty(); }
  WallBlock<R>* first(std::size_t chunk) { return blocks_.data() + run(chunk, 0).first; }
  WallBlock<R>* last(std::size_t chunk) { return blocks_.data() + run(chunk, surfaces.size() - 1).last; }
  /// Sum forces in the order of the chunks, move the bodies.
  void finish(double dt, const Vec3& gravity, std::size_t chunks);
  std::size_t bytes() const { return sizeof(WallBlock<R>) * blocks_.capacity(); }
  template <class F>
  void each_array(F&& f) {
    f("wall_blocks", blocks_);
    f("wall_runs", runs_);
  }

 private:
  struct Run {
    std::uint32_t first = 0, last = 0;
  };
  const Run& run(std::size_t chunk, std::size_t s) const { return runs_[chunk * surfaces.size() + s]; }
  /// Grain in the frame of the body, nearest image.
  Vec3 local(const Space<R>& space, const Grain<R>& g, const Body& b) const;
  void plane_geometry(const Surface& s, const Run& r, const Space<R>& space, const Array<Grain<R>>& grains);
  void part_geometry(const Surface& s, const Run& r, const Space<R>& space, const Array<Grain<R>>& grains);
  void one_contact_per_place(const Surface& s, std::size_t first, std::size_t last, const std::vector<Touch>& touch);
  void move(Body& b, double dt, const Vec3& gravity);
  Array<WallBlock<R>> blocks_;
  std::vector<Run> runs_;
};

extern template class Bodies<float>;
extern template class Bodies<double>;

}  // namespace grouser::dem
