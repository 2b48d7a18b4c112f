#include "lists.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace grouser::dem {

template <class R>
Cells Cells::of(const Space<R>& s, double reach, std::size_t grains) {
  // More cells than a few per grain would only cost memory.
  const double most = 1e6 + 8 * static_cast<double>(grains);
  for (Cells c;; reach *= 1.25) {
    double all = 1;
    for (int k = 0; k < 3; ++k) {
      c.n[k] = std::clamp(static_cast<int>((s.domain().hi[k] - s.domain().lo[k]) / reach), 1, 1 << 14);
      all *= c.n[k];
    }
    if (all <= most) return c;
  }
}

template <class R>
void Lists<R>::prepare(const Space<R>& space, double skin, const Array<Grain<R>>& grains, std::size_t count) {
  count_ = count;
  skin_ = skin;
  double largest = 0;
  for (std::size_t g = 0; g < count; ++g) largest = std::max(largest, double(grains[g].r));
  const double reach = 2 * largest + skin;
  cells_ = Cells::of(space, reach, count);
  for (int k = 0; k < 3; ++k)
    if (space.domain().periodic[static_cast<std::size_t>(k)] &&
        space.domain().hi[k] - space.domain().lo[k] < 2 * reach) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "periodic box is %.4g m along %c; it must be at least %.4g m, two grains and twice the skin",
                    space.domain().hi[k] - space.domain().lo[k], "xyz"[k], 2 * reach);
      throw DemError(text);
    }
}

template <class R>
void Lists<R>::sort_cells() {
  const std::size_t cells = static_cast<std::size_t>(cells_.n[0]) * cells_.n[1] * cells_.n[2];
  cell_start_.assign(cells + 1, 0);
  for (std::uint32_t c : cell_) ++cell_start_[c + 1];
  std::partial_sum(cell_start_.begin(), cell_start_.end(), cell_start_.begin());
  order_.resize(count_);
  std::vector<std::uint32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  for (std::size_t g = 0; g < count_; ++g) order_[next[cell_[g]]++] = static_cast<std::uint32_t>(g);
}

template <class R>
void Lists<R>::cut() {
  const std::size_t slabs = static_cast<std::size_t>(cells_.n[0]);
  const std::size_t per_slab = (cell_start_.size() - 1) / slabs;
  const auto at = [&](std::size_t slab) { return cell_start_[slab * per_slab]; };
  std::size_t n = std::clamp<std::size_t>(count_ / 1000, 1, kMostChunks / 2);
  n = std::min(n, slabs / 2);
  // For few threads a multiple of their number.
  for (std::size_t whole : {12u, 4u, 2u})
    if (n >= whole) {
      n -= n % whole;
      break;
    }
  chunks_.clear();
  const auto add = [&](std::size_t from, std::size_t to) {
    Chunk c;
    c.first = at(from);
    c.last = at(to);
    c.first_slab = from;
    c.last_slab = to;
    chunks_.push_back(c);
  };
  if (n == 0) {
    add(0, slabs);
    return;
  }
  std::size_t from = 0;
  for (std::size_t c = 0; c < n; ++c) {
    const std::size_t left = n - 1 - c, aim = count_ * (c + 1) / n;
    std::size_t to = from + 2;
    if (left == 0) to = slabs;
    // The border nearest to the aim.
    while (to + 2 * left < slabs && at(to) < aim && (at(to + 1) <= aim || at(to + 1) - aim <= aim - at(to))) ++to;
    add(from, from + 1);
    add(from + 1, to);
    from = to;
  }
}

template <class R>
bool Lists<R>::rebuild(Team& team, int t, const Space<R>& space, Array<Grain<R>>& grains,
                       std::vector<std::uint32_t>& ids) {
  const auto begin = [&] {
    before_.swap(parts_);
    store_.swap(old_store_);
    old_chunks_.swap(chunks_);
    cell_.resize(count_);
    outside_ = kNone;
  };
  if (!team.wait(begin)) return false;
  {
    const auto ny = static_cast<std::uint32_t>(cells_.n[1]), nz = static_cast<std::uint32_t>(cells_.n[2]);
    const auto [first, last] = team.share(count_, t);
    for (std::size_t g = first; g < last; ++g) {
      bool inside = true;
      std::uint32_t c[3];
      for (int k = 0; k < 3; ++k)
        c[k] = static_cast<std::uint32_t>(
            (std::uint64_t{space.fraction(grains[g], k, inside)} * static_cast<std::uint64_t>(cells_.n[k])) >> 32);
      cell_[g] = (c[0] * ny + c[1]) * nz + c[2];
      if (inside) continue;
      // The one with the least number, whatever the threads.
      std::uint32_t least = outside_;
      while (ids[g] < least && !outside_.compare_exchange_weak(least, ids[g])) {
      }
    }
  }
  const auto count_cells = [&] {
    if (outside_ != kNone) {
      const auto g = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), outside_.load()) - ids.begin());
      Vec3 x = space.position(grains[g]);
      // Beyond the upper end numbers go on from the lowest one.
      for (int k = 0; k < 3; ++k) {
        const double lo = space.domain().lo[k], length = space.domain().hi[k] - lo;
        if (!space.domain().periodic[static_cast<std::size_t>(k)] && x[k] < lo - 0.5 * length) x[k] += 2 * length;
      }
      char text[200];
      std::snprintf(text, sizeof text, "grain %u left the domain: it is at (%.4g, %.4g, %.4g) m", outside_.load(), x[0],
                    x[1], x[2]);
      throw GrainError(text, {outside_.load()});
    }
    sort_cells();
    cut();
    parts_.resize(chunks_.size());
    sorted_.resize(count_ + 2 * chunks_.size());
    sorted_ids_.resize(count_);
    new_index_.resize(count_);
    reference_.resize(3 * count_);
    for (std::size_t c = 0; c < chunks_.size(); ++c)
      for (std::size_t k = 0; k < 2; ++k) {
        Grain<R>& g = sorted_[spare(c) + k];
        g = Grain<R>{};
        g.r = R(1e-6);
        g.im = g.ii = 1;
        if (k) g.p[0] = Int<R>{1} << (Space<R>::kBits - 2);
      }
  };
  if (!team.wait(count_cells)) return false;
  const auto mine = team.share(chunks_.size(), t);
  const std::size_t first = mine.first, last = mine.second;
  const std::size_t per_slab = (cell_start_.size() - 1) / static_cast<std::size_t>(cells_.n[0]);
  for (std::size_t c = first; c < last; ++c) {
    // By cell, then by number, so that the order does not depend on the past.
    for (std::size_t b = chunks_[c].first_slab * per_slab; b < chunks_[c].last_slab * per_slab; ++b)
      if (cell_start_[b + 1] - cell_start_[b] > 1)
        std::sort(order_.begin() + cell_start_[b], order_.begin() + cell_start_[b + 1],
                  [&](std::uint32_t p, std::uint32_t q) { return ids[p] < ids[q]; });
    double top[3] = {0, 0, 0};
    for (std::size_t k = chunks_[c].first; k < chunks_[c].last; ++k) {
      const Grain<R>& g = grains[order_[k]];
      sorted_[k] = g;
      sorted_ids_[k] = ids[order_[k]];
      new_index_[order_[k]] = static_cast<std::uint32_t>(k);
      for (std::size_t a = 0; a < 3; ++a) {
        reference_[3 * k + a] = g.p[a];
        top[a] = std::max(top[a], std::fabs(double(g.v[a])));
      }
    }
    chunks_[c].speed = std::hypot(top[0], top[1], top[2]);
  }
  const auto swap = [&] {
    grains.swap(sorted_);
    ids.swap(sorted_ids_);
    Array<Grain<R>>().swap(sorted_);
    for (auto* v : {&cell_, &order_, &sorted_ids_}) std::vector<std::uint32_t>().swap(*v);
  };
  if (!team.wait(swap)) return false;
  team.guard([&] {
    for (std::size_t c = first; c < last; ++c) find_candidates(c, space, grains);
  });
  if (!team.wait([this] { lay_out(); })) return false;
  const auto [from, to] = team.share(before_.size(), t);
  for (std::size_t c = from; c < to; ++c) carry(c);
  return team.wait();
}

template <class R>
void Lists<R>::find_candidates(std::size_t c, const Space<R>& space, const Array<Grain<R>>& grains) {
  using U = std::make_unsigned_t<Int<R>>;
  const int nx = cells_.n[0], ny = cells_.n[1], nz = cells_.n[2];
  const R unit[3] = {static_cast<R>(space.unit(0)), static_cast<R>(space.unit(1)), static_cast<R>(space.unit(2))};
  const auto around = [&](int axis, int at, int from, int* out) {
    const int n = cells_.n[axis];
    const bool wraps = space.domain().periodic[static_cast<std::size_t>(axis)];
    int m = 0;
    for (int d = from; d <= 1; ++d) {
      int k = at + d;
      if (k < 0 || k >= n) {
        if (!wraps) continue;
        k = (k + n) % n;
      }
      if (std::find(out, out + m, k) == out + m) out[m++] = k;
    }
    return m;
  };
  Part& p = parts_[c];
  const Chunk& chunk = chunks_[c];
  const R wide = static_cast<R>(skin_), near = static_cast<R>(kRoomGap);
  std::size_t room = 0;
  p.start.assign(chunk.last - chunk.first + 1, 0);
  std::vector<std::uint32_t> found;
  found.reserve(4 * p.start.size());
  struct Run {
    std::uint32_t first, last;
    bool own;
  };
  Run runs[27];
  for (int x = static_cast<int>(chunk.first_slab); x < static_cast<int>(chunk.last_slab); ++x) {
    int xs[3], ys[3], zs[3];
    const int mx = around(0, x, nx < 3 ? -1 : 0, xs);
    for (int y = 0; y < ny; ++y) {
      const int my = around(1, y, -1, ys);
      for (int z = 0; z < nz; ++z) {
        const std::size_t here = (static_cast<std::size_t>(x) * ny + y) * nz + z;
        if (cell_start_[here] == cell_start_[here + 1]) continue;
        const int mz = around(2, z, -1, zs);
        int m = 0;
        for (int a = 0; a < mx; ++a)
          for (int b = 0; b < my; ++b)
            for (int d = 0; d < mz; ++d) {
              const std::size_t there = (static_cast<std::size_t>(xs[a]) * ny + ys[b]) * nz + zs[d];
              const Run r{cell_start_[there], cell_start_[there + 1], xs[a] == x || nx < 3};
              // Cells on top of each other are neighbours in memory.
              if (m > 0 && runs[m - 1].last == r.first && runs[m - 1].own == r.own)
                runs[m - 1].last = r.last;
              else
                runs[m++] = r;
            }
        for (std::uint32_t i = cell_start_[here]; i < cell_start_[here + 1]; ++i) {
          const Grain<R>& a = grains[i];
          const std::size_t run = found.size();
          for (int k = 0; k < m; ++k)
            for (std::uint32_t j = runs[k].own ? std::max(runs[k].first, i + 1) : runs[k].first; j < runs[k].last;
                 ++j) {
              const Grain<R>& b = grains[j];
              R d2 = 0;
              for (int q = 0; q < 3; ++q) {
                const R d =
                    static_cast<R>(static_cast<Int<R>>(static_cast<U>(b.p[q]) - static_cast<U>(a.p[q]))) * unit[q];
                d2 += d * d;
              }
              const R s = a.r + b.r + wide;
              if (!(d2 < s * s && (a.im != 0 || b.im != 0))) continue;
              found.push_back(j);
              const R close = a.r + b.r + near;
              room += d2 < close * close;
            }
          if (!std::is_sorted(found.begin() + static_cast<std::ptrdiff_t>(run), found.end()))
            std::sort(found.begin() + static_cast<std::ptrdiff_t>(run), found.end());
          p.start[i - chunk.first + 1] = static_cast<std::uint32_t>(found.size());
        }
      }
    }
  }
  p.partner = std::vector<std::uint32_t>(found.begin(), found.end());
  p.slot.assign(p.partner.size(), kNone);
  p.room = (room + kBlock - 1) / kBlock + 1;
}

template <class R>
void Lists<R>::lay_out() {
  std::size_t blocks = 0;
  for (Part& p : parts_) {
    p.first_block = blocks;
    blocks += p.room;
  }
  store_.resize(blocks);
}

template <class R>
void Lists<R>::keep(std::size_t c, const Store& contacts) {
  Part& p = parts_[c];
  if (contacts.size() > p.room) {
    p.own = contacts;
    return;
  }
  if (!p.own.empty()) Store().swap(p.own);
  std::copy(contacts.begin(), contacts.end(), first(c));
}

template <class R>
void Lists<R>::carry(std::size_t old_chunk) {
  const Part& old = before_[old_chunk];
  for (std::size_t g = 0; g + 1 < old.start.size(); ++g)
    for (std::uint32_t e = old.start[g]; e < old.start[g + 1]; ++e) {
      if (old.slot[e] == kNone) continue;
      std::uint32_t a = new_index_[old_chunks_[old_chunk].first + g], b = new_index_[old.partner[e]];
      for (int turn = 0; turn < 2; ++turn, std::swap(a, b)) {
        const auto next = std::upper_bound(chunks_.begin(), chunks_.end(), a,
                                           [](std::uint32_t at, const Chunk& c) { return at < c.first; });
        const auto c = static_cast<std::size_t>(next - chunks_.begin()) - 1;
        Part& p = parts_[c];
        const std::size_t local = a - chunks_[c].first;
        const auto first = p.partner.begin() + p.start[local], last = p.partner.begin() + p.start[local + 1];
        const auto it = std::lower_bound(first, last, b);
        if (it == last || *it != b) continue;
        // Seen from the other grain, displacement and torque change sign.
        p.slot[static_cast<std::size_t>(it - p.partner.begin())] = turn == 0 ? old.slot[e] : old.slot[e] ^ kFlip;
        break;
      }
    }
}

template <class R>
void Lists<R>::forget(const std::vector<std::uint8_t>& marked) {
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    Part& p = parts_[c];
    for (std::size_t g = 0; g + 1 < p.start.size(); ++g)
      for (std::uint32_t e = p.start[g]; e < p.start[g + 1]; ++e)
        if (marked[chunks_[c].first + g] || marked[p.partner[e]]) p.slot[e] = kNone;
  }
}

template <class R>
typename Lists<R>::Overlap Lists<R>::deepest(const Space<R>& space, const Array<Grain<R>>& grains,
                                             const std::vector<std::uint32_t>& ids) const {
  Overlap worst;
  for (std::size_t c = 0; c < chunks_.size(); ++c)
    for (std::size_t i = chunks_[c].first; i < chunks_[c].last; ++i)
      for (std::uint32_t e = parts_[c].start[i - chunks_[c].first]; e < parts_[c].start[i - chunks_[c].first + 1];
           ++e) {
        const std::uint32_t j = parts_[c].partner[e];
        const Grain<R>&a = grains[i], &b = grains[j];
        const double depth = double(a.r) + double(b.r) - space.between(a, b).norm();
        const double share = depth / std::min(double(a.r), double(b.r));
        if (share > worst.share) worst = {std::min(ids[i], ids[j]), std::max(ids[i], ids[j]), depth, share};
      }
  return worst;
}

template <class R>
double Lists<R>::moved(const Chunk& c, const Space<R>& space, const Array<Grain<R>>& grains) const {
  using U = std::make_unsigned_t<Int<R>>;
  double most = 0;
  for (std::size_t g = c.first; g < c.last; ++g) {
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
bool Lists<R>::find_due(const Space<R>& space, const Array<Grain<R>>& grains, double surfaces_travelled) {
  if (!before_.empty()) {
    std::vector<Part>().swap(before_);
    Store().swap(old_store_);
    old_chunks_.clear();
  }
  bool sort = false;
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    Chunk& here = chunks_[c];
    const Chunk& next = chunks_[(c + 1) % chunks_.size()];
    const double own = here.travelled - here.own_then;
    here.walls_due |= here.travelled - here.wall_then + surfaces_travelled - here.surfaces_then > here.wall_reach;
    if (2 * own <= here.reach && own + next.travelled - here.next_then <= here.reach) continue;
    here.pairs_due = 1;
    // Candidates hold as long as two grains, one of which was looked at up to a margin ago, can have come no closer than
    // the skin less the reach of the contact list.
    sort = sort || moved(here, space, grains) > 0.5 * skin_ - 1.5 * kLargestMargin;
  }
  return sort;
}

template <class R>
void Lists<R>::refresh(std::size_t c, const Space<R>& space, double dt, const Array<Grain<R>>& grains,
                       const std::vector<std::uint32_t>& ids, const std::vector<std::uint8_t>& pair_type_of,
                       const std::vector<std::uint8_t>& material, int materials) {
  using U = std::make_unsigned_t<Int<R>>;
  Chunk& chunk = chunks_[c];
  const Chunk& next = chunks_[(c + 1) % chunks_.size()];
  chunk.reach = 2 * std::clamp(kLasts * std::max(chunk.speed, next.speed) * dt, kSmallestMargin, kLargestMargin);
  chunk.own_then = chunk.travelled;
  chunk.next_then = next.travelled;
  chunk.pairs_due = 0;
  const R unit[3] = {static_cast<R>(space.unit(0)), static_cast<R>(space.unit(1)), static_cast<R>(space.unit(2))};
  const R wide = static_cast<R>(chunk.reach);
  Part& p = parts_[c];
  // The pairs that are near, without branches: whether one is cannot be foreseen.
  struct Near {
    std::uint32_t i, j, candidate;
  };
  thread_local std::vector<Near> near;
  thread_local Store fresh;
  thread_local Array<Past<R>> fresh_past;
  near.resize(p.partner.size() + 1);
  std::size_t n = 0;
  for (std::size_t i = chunk.first; i < chunk.last; ++i) {
    const Grain<R>& a = grains[i];
    for (std::uint32_t e = p.start[i - chunk.first]; e < p.start[i - chunk.first + 1]; ++e) {
      const std::uint32_t j = p.partner[e];
      const Grain<R>& b = grains[j];
      R d2 = 0;
      for (int k = 0; k < 3; ++k) {
        const R d = static_cast<R>(static_cast<Int<R>>(static_cast<U>(b.p[k]) - static_cast<U>(a.p[k]))) * unit[k];
        d2 += d * d;
      }
      const R s = a.r + b.r + wide;
      const bool keep = d2 <= s * s;
      near[n] = {static_cast<std::uint32_t>(i), j, e};
      n += keep;
      p.slot[e] |= keep ? 0u : kNone;
    }
  }
  const std::size_t blocks = (n + kBlock - 1) / kBlock;
  fresh.resize(blocks);
  if (ledger) fresh_past.resize(blocks);
  const Store& old_store = before_.empty() ? store_ : old_store_;
  const auto type_row = static_cast<std::size_t>(materials);
  const std::uint32_t here = static_cast<std::uint32_t>(c) << kLaneBits, lanes = (1u << kLaneBits) - 1;
  for (std::size_t k = 0; k < n; ++k) {
    const auto [i, j, e] = near[k];
    Block<R>& to = fresh[k / kBlock];
    const std::size_t lane = k % kBlock;
    to.i[lane] = i * kUnit + pair_type_of[material[ids[i]] * type_row + material[ids[j]]];
    to.j[lane] = j * kUnit;
    const std::uint32_t slot = p.slot[e];
    p.slot[e] = here | static_cast<std::uint32_t>(k);
    if (slot == kNone) {
      for (int q = 0; q < 3; ++q) to.s[q][lane] = to.t[q][lane] = 0;
      if (ledger) fresh_past[k / kBlock].clear(lane);
      continue;
    }
    const Part& old = before_.empty() ? p : before_[(slot & ~kFlip) >> kLaneBits];
    const std::size_t at = slot & lanes;
    const Block<R>& from = contacts(old, old_store)[at / kBlock];
    const R sign = slot & kFlip ? R(-1) : R(1);
    for (int q = 0; q < 3; ++q) {
      to.s[q][lane] = sign * from.s[q][at % kBlock];
      to.t[q][lane] = sign * from.t[q][at % kBlock];
    }
    if (ledger) fresh_past[k / kBlock].copy(lane, old.past[at / kBlock], at % kBlock, sign);
  }
  // The rest of the last block: two grains of this chunk's own that never meet.
  for (std::size_t k = n; k < blocks * kBlock; ++k) {
    Block<R>& to = fresh[k / kBlock];
    const std::size_t lane = k % kBlock;
    to.i[lane] = static_cast<std::uint32_t>(spare(c)) * kUnit;
    to.j[lane] = static_cast<std::uint32_t>(spare(c) + 1) * kUnit;
    for (int q = 0; q < 3; ++q) to.s[q][lane] = to.t[q][lane] = 0;
    if (ledger) fresh_past[k / kBlock].clear(lane);
  }
  keep(c, fresh);
  if (ledger) p.past.swap(fresh_past);
  chunk.listed = n;
}

template <class R>
std::size_t Lists<R>::candidates() const {
  std::size_t n = 0;
  for (const Part& p : parts_) n += p.partner.size();
  return n;
}
template <class R>
std::size_t Lists<R>::listed() const {
  std::size_t n = 0;
  for (const Chunk& c : chunks_) n += c.listed;
  return n;
}

template <class R>
std::size_t Lists<R>::bytes() const {
  std::size_t n = sizeof(std::uint32_t) * (new_index_.capacity() + cell_start_.capacity()) +
                  sizeof(Int<R>) * reference_.capacity() +
                  sizeof(Block<R>) * (store_.capacity() + old_store_.capacity());
  for (const std::vector<Part>* parts : {&parts_, &before_})
    for (const Part& p : *parts)
      n += sizeof(std::uint32_t) * (p.start.capacity() + p.partner.capacity() + p.slot.capacity()) +
           sizeof(Block<R>) * p.own.capacity() + sizeof(Past<R>) * p.past.capacity();
  return n;
}

template class Lists<float>;
template class Lists<double>;

}  // namespace grouser::dem
