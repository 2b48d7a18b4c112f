#pragma once
// Positions as whole numbers of a unit per axis. A periodic axis has 2^32 (2^64) units, so that the difference of two
// positions is the nearest image without any test; on the others the box takes half of them.
#include <cmath>

#include "grouser/dem/solver.h"
#include "store.h"

namespace grouser::dem {

template <class R>
class Space {
 public:
  static constexpr int kBits = 8 * static_cast<int>(sizeof(R));
  Space() = default;
  explicit Space(const Domain& d) : domain_(d) {
    for (int k = 0; k < 3; ++k) unit_[k] = std::ldexp(d.hi[k] - d.lo[k], d.periodic[k] ? -kBits : 1 - kBits);
  }
  const Domain& domain() const { return domain_; }
  double unit(int axis) const { return unit_[axis]; }
  void put(const Vec3& x, Grain<R>& g) const {
    for (int k = 0; k < 3; ++k) {
      const double length = domain_.hi[k] - domain_.lo[k];
      double f = x[k] - domain_.lo[k];
      if (domain_.periodic[k]) f -= length * std::floor(f / length);
      const double u = f / unit_[k], whole = std::floor(u);
      g.p[k] = static_cast<Int<R>>(static_cast<std::uint64_t>(whole));
      g.rest[k] = static_cast<R>(u - whole);
    }
  }
  double coordinate(const Grain<R>& g, int k) const {
    using U = std::make_unsigned_t<Int<R>>;
    const double p = domain_.periodic[k] ? static_cast<double>(static_cast<U>(g.p[k])) : static_cast<double>(g.p[k]);
    return domain_.lo[k] + (p + static_cast<double>(g.rest[k])) * unit_[k];
  }
  Vec3 position(const Grain<R>& g) const { return {coordinate(g, 0), coordinate(g, 1), coordinate(g, 2)}; }
  /// Share of the box along an axis, as a 32-bit fraction; `inside` is false beyond a wall of the box.
  std::uint32_t fraction(const Grain<R>& g, int k, bool& inside) const {
    const auto top = static_cast<std::uint32_t>(static_cast<std::make_unsigned_t<Int<R>>>(g.p[k]) >> (kBits - 32));
    if (domain_.periodic[k]) return top;
    if (top >> 31) inside = false;
    return top << 1;
  }
  /// Nearest-image difference b - a [m].
  Vec3 between(const Grain<R>& a, const Grain<R>& b) const {
    using U = std::make_unsigned_t<Int<R>>;
    Vec3 d;
    for (int k = 0; k < 3; ++k)
      d[k] = static_cast<double>(static_cast<Int<R>>(static_cast<U>(b.p[k]) - static_cast<U>(a.p[k]))) * unit_[k];
    return d;
  }

 private:
  Domain domain_;
  double unit_[3] = {1, 1, 1};
};

}  // namespace grouser::dem
