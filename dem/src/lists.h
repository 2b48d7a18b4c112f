#pragma once
// Who may touch whom. Two levels: candidates within the skin, found by sorting grains into cells; from them the contact
// list of pairs within a far smaller margin, which is what the inner loop reads. Both last as long as no grain can have
// moved further than they allow. Contact lists are kept, and renewed, chunk by chunk.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "space.h"
#include "store.h"
#include "team.h"

namespace grouser::dem {

inline constexpr std::uint32_t kNone = 0xffffffffu;
inline constexpr std::uint32_t kFlip = 0x80000000u;
inline constexpr int kLaneBits = 23;  ///< of a slot: place of a history in its chunk; above it the chunk
inline constexpr std::size_t kMostChunks = 255;
inline constexpr double kLargestMargin = 5e-5;  ///< [m] of the contact list
inline constexpr double kSmallestMargin = 2e-6;
inline constexpr double kWallMargin = 2e-4;  ///< [m] of the list of grains near surfaces, at most
inline constexpr double kLasts = 80;         ///< steps that a contact list should last
/// [m] Candidates nearer than this get room in the store of contacts: those that may be listed before the next sort, nearly
/// always. A chunk with more keeps its contacts by itself until then.
inline constexpr double kRoomGap = 3e-4;

/// Cells of a box, x slowest.
struct Cells {
  int n[3] = {1, 1, 1};
  template <class R>
  static Cells of(const Space<R>& s, double reach, std::size_t grains);
};

/// Whole slabs of cells: an even chunk is one slab, an odd one many. Grains of a chunk own pairs with grains of the same
/// or the next chunk only. All even chunks come before all odd ones, so that chunks can run side by side and the sums of
/// every grain come in one order for any number of threads.
struct Chunk {
  std::uint64_t first = 0, last = 0;              ///< grains
  std::uint64_t first_slab = 0, last_slab = 0;    ///< cells along x
  std::uint64_t listed = 0;                       ///< contacts in the list
  double speed = 0;                               ///< bound of the speed in the last step [m/s]
  double travelled = 0;                           ///< bound of the way of any of its grains since the last sort [m]
  double own_then = 0, next_then = 0, reach = 0;  ///< when the contact list was made, and its reach
  double wall_then = 0, surfaces_then = 0, wall_reach = 0;  ///< the same of the list of surfaces
  std::uint64_t pairs_due = 1, walls_due = 1;
};

template <class R>
class Lists {
 public:
  /// Lists of a chunk.
  struct Part {
    std::vector<std::uint32_t> start, partner, slot;  ///< run of candidates per grain; place of their history
    std::size_t first_block = 0, room = 0;            ///< its part of the store of contacts, blocks
    Array<Block<R>> own;                              ///< contacts, when they are too many for that
    Array<Past<R>> past;                              ///< with the ledger only
  };
  /// Contacts of all chunks: one piece of memory, so that the system can keep it in large pages and neighbouring chunks
  /// follow each other.
  using Store = Array<Block<R>>;
  bool ledger = false;

  void prepare(const Space<R>& space, double skin, const Array<Grain<R>>& grains, std::size_t count);
  /// Sort grains (with what belongs to them), cut chunks, find the candidates. Called by all threads of the team; false
  /// when it failed. @throws DemError (from the team): a grain left the domain.
  bool rebuild(Team& team, int t, const Space<R>& space, Array<Grain<R>>& grains, std::vector<std::uint32_t>& ids);
  /// Contact list of chunk c: pairs with a gap below its reach; histories move along.
  void refresh(std::size_t c, const Space<R>& space, double dt, const Array<Grain<R>>& grains,
               const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& pair_type_of,
               const std::vector<std::uint8_t>& material, int materials);
  /// After every step: which lists have to be renewed. True when grains have to be sorted again.
  bool find_due(const Space<R>& space, const Array<Grain<R>>& grains, double surfaces_travelled);

  /// Contacts of these grains (marked by place) begin anew at the next sort.
  void forget(const std::vector<std::uint8_t>& marked);

  struct Overlap {
    std::uint32_t a = 0, b = 0;   ///< numbers as given
    double depth = 0, share = 0;  ///< [m], over the smaller radius
  };
  Overlap deepest(const Space<R>& space, const Array<Grain<R>>& grains, const std::vector<std::uint32_t>& ids) const;

  Block<R>* first(std::size_t c) { return contacts(parts_[c], store_); }
  Block<R>* last(std::size_t c) { return first(c) + (chunks_[c].listed + kBlock - 1) / kBlock; }
  Past<R>* past(std::size_t c) { return parts_[c].past.data(); }
  std::vector<Chunk>& chunks() { return chunks_; }
  const std::vector<Chunk>& chunks() const { return chunks_; }
  /// First of the two grains of chunk c that never meet anybody: they fill unused lanes.
  std::size_t spare(std::size_t c) const { return count_ + 2 * c; }
  std::size_t candidates() const;
  std::size_t listed() const;
  const std::vector<std::uint32_t>& new_index() const { return new_index_; }  ///< old place to new one, last rebuild
  std::size_t bytes() const;
  /// Raw state for saving: everything that is not found again from the grains. loading: f fills the arrays, and what the
  /// lists held before does not fit the chunks any more.
  template <class F>
  void each_array(F&& f, bool loading) {
    f("chunks", chunks_);
    f("reference", reference_);
    parts_.resize(chunks_.size());
    for (Part& p : parts_) {
      f("start", p.start);
      f("partner", p.partner);
      f("slot", p.slot);
      if (ledger) f("past", p.past);
    }
    std::vector<Store> used(parts_.size());
    for (std::size_t c = 0; c < parts_.size(); ++c) {
      if (!loading) used[c].assign(first(c), last(c));
      f("blocks", used[c]);
      parts_[c].room = std::max(parts_[c].room, used[c].size());
    }
    lay_out();
    for (std::size_t c = 0; c < parts_.size(); ++c) keep(c, used[c]);
  }

 private:
  void sort_cells();
  void cut();
  /// Room in the store for every chunk.
  void lay_out();
  void keep(std::size_t c, const Store& contacts);
  template <class P, class S>
  static auto contacts(P& part, S& store) {
    return part.own.empty() ? store.data() + part.first_block : part.own.data();
  }
  void find_candidates(std::size_t c, const Space<R>& space, const Array<Grain<R>>& grains);
  void carry(std::size_t old_chunk);
  double moved(const Chunk& c, const Space<R>& space, const Array<Grain<R>>& grains) const;

  std::size_t count_ = 0;
  double skin_ = 0;
  Cells cells_;
  std::vector<Int<R>> reference_;  // positions at rebuild
  std::vector<Chunk> chunks_;
  std::vector<Part> parts_;
  Store store_;
  std::vector<std::uint32_t> new_index_, cell_start_;
  // Only during a rebuild and the refresh that follows it.
  std::vector<Part> before_;
  Store old_store_;
  std::vector<Chunk> old_chunks_;
  std::vector<std::uint32_t> cell_, order_, sorted_ids_;
  Array<Grain<R>> sorted_;
  std::atomic<std::uint32_t> outside_{kNone};
};

extern template class Lists<float>;
extern template class Lists<double>;

}  // namespace grouser::dem
