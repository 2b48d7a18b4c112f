#include "lists.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace grouser::dem {

template <class R>
Cells Cells::of(const Space<R>& s, double reach) {
  Cells c;
  for (int k = 0; k < 3; ++k)
    c.n[k] = std::clamp(static_cast<int>((s.domain().hi[k] - s.domain().lo[k]) / reach), 1, 1 << 14);
  return c;
}

template <class R>
void Lists<R>::sort(const Space<R>& space, const Cells& cells, Array<Grain<R>>& grains,
                    std::vector<std::uint32_t>& ids) {
  const std::size_t count = ids.size();
  const auto ny = static_cast<std::uint32_t>(cells.n[1]), nz = static_cast<std::uint32_t>(cells.n[2]);
  std::vector<std::uint32_t> cell(count), order(count);
  for (std::size_t g = 0; g < count; ++g) {
    bool inside = true;
    std::uint32_t c[3];
    for (int k = 0; k < 3; ++k)
      c[k] = static_cast<std::uint32_t>(
          (std::uint64_t{space.fraction(grains[g], k, inside)} * static_cast<std::uint64_t>(cells.n[k])) >> 32);
    if (!inside) {
      const Vec3 x = space.position(grains[g]);
      char text[200];
      std::snprintf(text, sizeof text, "grain %u left the domain: it is at (%.4g, %.4g, %.4g) m", ids[g], x[0], x[1],
                    x[2]);
      throw DemError(text);
    }
    cell[g] = (c[0] * ny + c[1]) * nz + c[2];
  }
  // By cell, then by number, so that the order does not depend on the past.
  cell_start_.assign(static_cast<std::size_t>(cells.n[0]) * ny * nz + 1, 0);
  for (std::uint32_t c : cell) ++cell_start_[c + 1];
  std::partial_sum(cell_start_.begin(), cell_start_.end(), cell_start_.begin());
  std::vector<std::uint32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  for (std::size_t g = 0; g < count; ++g) order[next[cell[g]]++] = static_cast<std::uint32_t>(g);
  for (std::size_t c = 0; c + 1 < cell_start_.size(); ++c)
    std::sort(order.begin() + cell_start_[c], order.begin() + cell_start_[c + 1],
              [&](std::uint32_t a, std::uint32_t b) { return ids[a] < ids[b]; });
  Array<Grain<R>> sorted(grains.size());
  std::vector<std::uint32_t> sorted_ids(count);
  new_index_.resize(count);
  cell_of_.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    sorted[k] = grains[order[k]];
    sorted_ids[k] = ids[order[k]];
    cell_of_[k] = cell[order[k]];
    new_index_[order[k]] = static_cast<std::uint32_t>(k);
  }
  for (std::size_t k = count; k < grains.size(); ++k) sorted[k] = grains[k];
  grains.swap(sorted);
  ids.swap(sorted_ids);
}

template <class R>
void Lists<R>::cut(const Cells& cells, std::size_t count) {
  // Whole slabs of cells, an even number of chunks of about equal size.
  const std::size_t slabs = static_cast<std::size_t>(cells.n[0]);
  const std::size_t per_slab = (cell_start_.size() - 1) / slabs;
  std::size_t n = std::clamp<std::size_t>(count / 1000, 2, 256);
  n = std::min(n, slabs) & ~std::size_t{1};
  chunks_.clear();
  if (n < 2) {
    chunks_.push_back({0, count, 0, 0});
    return;
  }
  std::size_t slab = 0;
  for (std::size_t c = 0; c < n; ++c) {
    const std::size_t begin = cell_start_[slab * per_slab], left = n - 1 - c;
    ++slab;
    if (left == 0) slab = slabs;
    const std::size_t aim = count * (c + 1) / n;
    while (slab + left < slabs && cell_start_[slab * per_slab] < aim) ++slab;
    chunks_.push_back({begin, cell_start_[slab * per_slab], 0, 0});
  }
}

template <class R>
void Lists<R>::rebuild(const Space<R>& space, double skin, Array<Grain<R>>& grains, std::vector<std::uint32_t>& ids) {
  const std::size_t count = ids.size();
  double largest = 0;
  for (std::size_t g = 0; g < count; ++g) largest = std::max(largest, double(grains[g].r));
  const double reach = 2 * largest + skin;
  const Cells cells = Cells::of(space, reach);
  for (int k = 0; k < 3; ++k)
    if (space.domain().periodic[static_cast<std::size_t>(k)] &&
        space.domain().hi[k] - space.domain().lo[k] < 2 * reach) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "periodic box is %.4g m along %c; it must be at least %.4g m, two grains and twice the skin",
                    space.domain().hi[k] - space.domain().lo[k], "xyz"[k], 2 * reach);
      throw DemError(text);
    }
  // Contacts that carry a history, by place before sorting.
  std::vector<Carried> carried;
  for (std::size_t g = 0; g + 1 < start_.size(); ++g)
    for (std::uint32_t e = start_[g]; e < start_[g + 1]; ++e)
      if (slot_[e] != kNone) carried.push_back({static_cast<std::uint32_t>(g), partner_[e], slot_[e]});
  sort(space, cells, grains, ids);
  cut(cells, count);

  const int nx = cells.n[0], ny = cells.n[1], nz = cells.n[2];
  const auto around = [&](int axis, int c, int from, int* out) {
    const int n = cells.n[axis];
    const bool wraps = space.domain().periodic[static_cast<std::size_t>(axis)];
    int m = 0;
    for (int d = from; d <= 1; ++d) {
      int k = c + d;
      if (k < 0 || k >= n) {
        if (!wraps) continue;
        k = (k + n) % n;
      }
      if (std::find(out, out + m, k) == out + m) out[m++] = k;
    }
    return m;
  };
  start_.assign(count + 1, 0);
  partner_.clear();
  for (int x = 0; x < nx; ++x) {
    int xs[3], ys[3], zs[3];
    const int mx = around(0, x, nx < 3 ? -1 : 0, xs);
    for (int y = 0; y < ny; ++y) {
      const int my = around(1, y, -1, ys);
      for (int z = 0; z < nz; ++z) {
        const std::size_t here = (static_cast<std::size_t>(x) * ny + y) * nz + z;
        if (cell_start_[here] == cell_start_[here + 1]) continue;
        const int mz = around(2, z, -1, zs);
        for (std::uint32_t i = cell_start_[here]; i < cell_start_[here + 1]; ++i) {
          const Grain<R>& a = grains[i];
          const std::size_t run = partner_.size();
          for (int p = 0; p < mx; ++p)
            for (int q = 0; q < my; ++q)
              for (int r = 0; r < mz; ++r) {
                const std::size_t there = (static_cast<std::size_t>(xs[p]) * ny + ys[q]) * nz + zs[r];
                for (std::uint32_t j = cell_start_[there]; j < cell_start_[there + 1]; ++j) {
                  if ((xs[p] == x || nx < 3) && j <= i) continue;
                  const Grain<R>& b = grains[j];
                  if (a.im == 0 && b.im == 0) continue;
                  const double s = double(a.r) + double(b.r) + skin;
                  if (space.between(a, b).squaredNorm() < s * s) partner_.push_back(j);
                }
              }
          std::sort(partner_.begin() + static_cast<std::ptrdiff_t>(run), partner_.end());
          start_[i + 1] = static_cast<std::uint32_t>(partner_.size());
        }
      }
    }
  }
  slot_.assign(partner_.size(), kNone);
  for (const Carried& c : carried) {
    std::uint32_t a = new_index_[c.a], b = new_index_[c.b];
    for (int turn = 0; turn < 2; ++turn, std::swap(a, b)) {
      const auto first = partner_.begin() + start_[a], last = partner_.begin() + start_[a + 1];
      const auto it = std::lower_bound(first, last, b);
      if (it == last || *it != b) continue;
      // Seen from the other grain, displacement and torque change sign.
      slot_[static_cast<std::size_t>(it - partner_.begin())] = turn == 0 ? c.slot : c.slot ^ kFlip;
      break;
    }
  }
  reference_.resize(3 * count);
  for (std::size_t g = 0; g < count; ++g)
    for (std::size_t k = 0; k < 3; ++k) reference_[3 * g + k] = grains[g].p[k];
}

template <class R>
typename Lists<R>::Overlap Lists<R>::deepest(const Space<R>& space, const Array<Grain<R>>& grains,
                                             const std::vector<std::uint32_t>& ids) const {
  Overlap worst;
  for (std::size_t i = 0; i + 1 < start_.size(); ++i)
    for (std::uint32_t e = start_[i]; e < start_[i + 1]; ++e) {
      const Grain<R>&a = grains[i], &b = grains[partner_[e]];
      const double depth = double(a.r) + double(b.r) - space.between(a, b).norm();
      const double share = depth / std::min(double(a.r), double(b.r));
      if (share > worst.share)
        worst = {std::min(ids[i], ids[partner_[e]]), std::max(ids[i], ids[partner_[e]]), depth, share};
    }
  return worst;
}

template <class R>
double Lists<R>::moved(const Space<R>& space, const Array<Grain<R>>& grains) const {
  using U = std::make_unsigned_t<Int<R>>;
  double most = 0;
  for (std::size_t g = 0; 3 * g < reference_.size(); ++g) {
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const auto d = static_cast<Int<R>>(static_cast<U>(grains[g].p[k]) -
                                         static_cast<U>(reference_[3 * g + static_cast<std::size_t>(k)]));
      const double m = static_cast<double>(d) * space.unit(k);
      d2 += m * m;
    }
    most = std::max(most, d2);
  }
  return std::sqrt(most);
}

template <class R>
void Lists<R>::refresh(const Space<R>& space, double margin, const Array<Grain<R>>& grains,
                       const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& pair_type_of,
                       const std::vector<std::uint8_t>& material, int materials) {
  using U = std::make_unsigned_t<Int<R>>;
  const R unit[3] = {static_cast<R>(space.unit(0)), static_cast<R>(space.unit(1)), static_cast<R>(space.unit(2))};
  const R wide = static_cast<R>(margin);
  const auto nobody = static_cast<std::uint32_t>(ids.size()) * kUnit;
  old_blocks_.swap(blocks_);
  blocks_.clear();
  // Growth by doubling would leave up to half of it unused.
  const std::size_t expected = (listed_ + listed_ / 20) / kBlock + chunks_.size() + 1;
  if (blocks_.capacity() < expected) blocks_.reserve(expected);
  listed_ = 0;
  for (Chunk& c : chunks_) {
    c.first_block = blocks_.size();
    int lane = kBlock;
    for (std::size_t i = c.first; i < c.last; ++i) {
      const Grain<R>& a = grains[i];
      for (std::uint32_t e = start_[i]; e < start_[i + 1]; ++e) {
        const std::uint32_t j = partner_[e];
        const Grain<R>& b = grains[j];
        R d2 = 0;
        for (int k = 0; k < 3; ++k) {
          const R d = static_cast<R>(static_cast<Int<R>>(static_cast<U>(b.p[k]) - static_cast<U>(a.p[k]))) * unit[k];
          d2 += d * d;
        }
        const R s = a.r + b.r + wide;
        if (d2 > s * s) {
          slot_[e] = kNone;
          continue;
        }
        if (lane == kBlock) {
          blocks_.emplace_back();
          lane = 0;
        }
        Block<R>& to = blocks_.back();
        const std::uint32_t type =
            pair_type_of[static_cast<std::size_t>(material[ids[i]]) * static_cast<std::size_t>(materials) +
                         material[ids[j]]];
        to.i[lane] = static_cast<std::uint32_t>(i) * kUnit + type;
        to.j[lane] = j * kUnit;
        const std::uint32_t slot = slot_[e];
        if (slot == kNone) {
          for (int k = 0; k < 3; ++k) to.s[k][lane] = to.t[k][lane] = 0;
        } else {
          const std::uint32_t at = slot & ~kFlip;
          const Block<R>& from = old_blocks_[at / kBlock];
          const R sign = slot & kFlip ? R(-1) : R(1);
          for (int k = 0; k < 3; ++k) {
            to.s[k][lane] = sign * from.s[k][at % kBlock];
            to.t[k][lane] = sign * from.t[k][at % kBlock];
          }
        }
        slot_[e] = static_cast<std::uint32_t>((blocks_.size() - 1) * kBlock) + static_cast<std::uint32_t>(lane);
        ++lane;
        ++listed_;
      }
    }
    // The rest of the last block: two grains that never meet.
    for (; lane < kBlock; ++lane) {
      Block<R>& to = blocks_.back();
      to.i[lane] = nobody;
      to.j[lane] = nobody + kUnit;
      for (int k = 0; k < 3; ++k) to.s[k][lane] = to.t[k][lane] = 0;
    }
    c.last_block = blocks_.size();
  }
}

template <class R>
std::size_t Lists<R>::bytes() const {
  return sizeof(std::uint32_t) * (start_.capacity() + partner_.capacity() + slot_.capacity() + new_index_.capacity() +
                                  cell_of_.capacity() + cell_start_.capacity()) +
         sizeof(Int<R>) * reference_.capacity() + sizeof(Block<R>) * (blocks_.capacity() + old_blocks_.capacity());
}

template class Lists<float>;
template class Lists<double>;

}  // namespace grouser::dem
