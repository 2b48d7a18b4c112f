#pragma once
// Bodies and their surfaces: motion, lists of contacts per chunk of grains, geometry, sums of force.
#include <vector>

#include "grouser/dem/solver.h"
#include "kernel.h"
#include "lists.h"
#include "shape.h"

namespace grouser::dem {

struct Body {
  BodySettings set;
  Pose X;
  Twist V;
  SurfaceReport report;
  double given = 0;  ///< work on the grains up to the last force [J], for the ledger
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
  double travelled = 0;  ///< bound of the way of any point of a surface [m]

  /// Bound of the speed of any point of a surface [m/s].
  double fastest() const;
  /// Grain in the frame of the body, nearest image.
  Vec3 local(const Space<R>& space, const Grain<R>& g, const Body& b) const;
  /// After a sort of the grains, alone: histories by the new places of grains.
  void renumber(const std::vector<std::uint32_t>& moved_to, std::size_t chunks);
  /// List of grains of chunk c with a gap below its reach; histories move along.
  void refresh(std::size_t c, const Space<R>& space, double dt, const Array<Grain<R>>& grains, Chunk& chunk,
               std::size_t spare, const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& material,
               const MaterialTable& table);
  /// Normal, overlap and surface velocity of the contacts of a chunk.
  void geometry(std::size_t c, const Space<R>& space, const Array<Grain<R>>& grains, std::size_t count,
                const KernelOf<R>& kernel);
  bool empty() const { return surfaces.empty(); }
  /// The law for the contacts of chunk c: `f(motion, first, last, sum)` for each surface.
  template <class F>
  void each_surface(std::size_t c, F&& f) {
    Part& p = parts_[c];
    p.sums.assign(p.runs.size(), WallSum{});
    for (std::size_t s = 0; s < p.runs.size(); ++s)
      if (p.runs[s].first != p.runs[s].last) {
        const Twist& V = bodies[static_cast<std::size_t>(surfaces[s].body)].V;
        Motion<R> m;
        for (int k = 0; k < 3; ++k) {
          m.v[k] = static_cast<R>(V.v[k]);
          m.w[k] = static_cast<R>(V.w[k]);
        }
        f(m, p.blocks.data() + p.runs[s].first, p.blocks.data() + p.runs[s].last, p.sums[s]);
      }
  }
  /// `f(block, lane, radius of the grain, pair type)` for every contact of a body in the last step.
  template <class F>
  void each_contact(int body, const Array<Grain<R>>& grains, std::size_t count, F&& f) const {
    for (const Part& p : parts_)
      for (std::size_t s = 0; s < p.runs.size(); ++s) {
        if (surfaces[s].body != body) continue;
        for (std::size_t b = p.runs[s].first; b < p.runs[s].last; ++b)
          for (std::size_t l = 0; l < kBlock; ++l) {
            const WallBlock<R>& block = p.blocks[b];
            const std::size_t g = block.i[l] / kUnit;
            if (g < count && block.delta[l] > 0) f(block, l, double(grains[g].r), block.i[l] % kUnit);
          }
      }
  }
  /// Sum forces in the order of the chunks, move the bodies. `begun`: forces of a step before are known.
  void finish(double dt, const Vec3& gravity, bool begun);
  /// After the step that followed a sort.
  void forget_past() {
    std::vector<Known>().swap(known_);
    std::vector<Part>().swap(before_);
  }
  /// After loading: what follows from the lists.
  void complete(std::size_t count) {
    for (Part& p : parts_) derive(p, count);
  }
  /// Contacts of these grains (marked by place) begin anew at the next sort.
  void forget(const std::vector<std::uint8_t>& marked);
  std::size_t bytes() const;
  template <class F>
  void each_array(std::size_t chunks, F&& f) {
    parts_.resize(chunks);
    for (Part& p : parts_) {
      f("wall_blocks", p.blocks);
      f("wall_runs", p.runs);
    }
  }

 private:
  struct Run {
    std::uint32_t first = 0, last = 0;  ///< blocks
  };
  /// Lanes of one grain near several triangles.
  struct Group {
    std::uint32_t first, last;
  };
  struct Part {
    Array<WallBlock<R>> blocks;
    std::vector<Run> runs;  ///< per surface
    std::vector<WallSum> sums;
    // What follows from these.
    Array<FacetBlock> facets;         ///< of the blocks of meshes and spheres, in their order
    std::vector<Group> groups;        ///< of all meshes
    std::vector<Run> facets_of;       ///< per surface
    std::vector<Run> groups_of;       ///< per surface
    std::vector<std::uint8_t> was;    ///< whether the lanes of all groups touched in the last step
    std::vector<std::uint32_t> kept;  ///< lanes of one group
  };
  /// Where the history of a contact is; ordered by surface and grain.
  struct Known {
    std::uint32_t surface, grain, part, lane;
    const WallBlock<R>* block;
    bool operator<(const Known& o) const { return surface != o.surface ? surface < o.surface : grain < o.grain; }
  };
  static void collect(const Part& p, std::size_t count, std::vector<Known>& into);
  void plane_geometry(const Surface& s, Part& p, Run r, const Space<R>& space, const Array<Grain<R>>& grains,
                      std::size_t count);
  void derive(Part& p, std::size_t count) const;
  SurfaceWork<R> work(const Surface& s, const Space<R>& space, const Array<Grain<R>>& grains) const;
  void one_contact_per_place(const Surface& s, Part& p, Group g, std::uint32_t shift) const;
  void take_over(Part& p, Group g, std::uint8_t* was) const;
  void move(Body& b, double dt, const Vec3& gravity);
  std::vector<Part> parts_;  ///< per chunk
  // Between a sort and the refresh after it.
  std::vector<Part> before_;
  std::vector<Known> known_;
};

extern template class Bodies<float>;
extern template class Bodies<double>;

}  // namespace grouser::dem
