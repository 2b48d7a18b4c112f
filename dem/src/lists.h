#pragma once
// Who may touch whom. Two levels: `candidates` within the skin, made by sorting grains into cells; from them the
// contact
// list of pairs within a far smaller margin, which is what the inner loop reads. Both last as long as no grain can have
// moved further than they allow.
#include <cstdint>
#include <vector>

#include "space.h"
#include "store.h"

namespace grouser::dem {

inline constexpr std::uint32_t kNone = 0xffffffffu;
inline constexpr std::uint32_t kFlip = 0x80000000u;

/// Cells of a box, x slowest.
struct Cells {
  int n[3] = {1, 1, 1};
  template <class R>
  static Cells of(const Space<R>& s, double reach);
};

/// Grains of a chunk own pairs with grains of the same or the next chunk only: even chunks can run side by side, then
/// odd
/// ones, and the sums of every grain come in one order for any number of threads.
struct Chunk {
  std::size_t first = 0, last = 0;              ///< grains
  std::size_t first_block = 0, last_block = 0;  ///< contacts
};

template <class R>
class Lists {
 public:
  /// Sort grains (with what belongs to them) and find the candidates. `skin` [m].
  void rebuild(const Space<R>& space, double skin, Array<Grain<R>>& grains, std::vector<std::uint32_t>& ids);
  /// Contact list of pairs with a gap below `margin` [m]; histories move along.
  void refresh(const Space<R>& space, double margin, const Array<Grain<R>>& grains,
               const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& pair_type_of,
               const std::vector<std::uint8_t>& material, int materials);
  struct Overlap {
    std::uint32_t a = 0, b = 0;   ///< numbers as given
    double depth = 0, share = 0;  ///< [m], over the smaller radius
  };
  Overlap deepest(const Space<R>& space, const Array<Grain<R>>& grains, const std::vector<std::uint32_t>& ids) const;
  /// Largest movement since rebuild [m].
  double moved(const Space<R>& space, const Array<Grain<R>>& grains) const;

  Array<Block<R>>& blocks() { return blocks_; }
  const Array<Block<R>>& blocks() const { return blocks_; }
  const std::vector<Chunk>& chunks() const { return chunks_; }
  std::size_t candidates() const { return partner_.size(); }
  std::size_t listed() const { return listed_; }
  const std::vector<std::uint32_t>& new_index() const { return new_index_; }  ///< old place to new one, last rebuild
  std::size_t bytes() const;
  /// Raw state for saving: everything that is not found again from the grains.
  template <class F>
  void each_array(F&& f) {
    f("start", start_);
    f("partner", partner_);
    f("slot", slot_);
    f("reference", reference_);
    f("blocks", blocks_);
    f("chunks", chunks_);
  }
  std::size_t listed_ = 0;

 private:
  void sort(const Space<R>& space, const Cells& cells, Array<Grain<R>>& grains, std::vector<std::uint32_t>& ids);
  void cut(const Cells& cells, std::size_t count);
  struct Carried {
    std::uint32_t a, b, slot;
  };
  std::vector<std::uint32_t> start_, partner_, slot_;  // run of candidates per grain; place of their history
  std::vector<Int<R>> reference_;                      // positions at rebuild
  Array<Block<R>> blocks_, old_blocks_;
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> new_index_, cell_of_, cell_start_;
};

extern template class Lists<float>;
extern template class Lists<double>;

}  // namespace grouser::dem
