#pragma once
// What the inner loop reads and writes: one cache line per grain, 32 bytes of force per grain, 32 bytes per contact
// (single precision; twice that in double). Plain data, the same for every instruction set.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace grouser::dem {

template <class R>
struct IntOf;
template <>
struct IntOf<float> {
  using type = std::int32_t;
};
template <>
struct IntOf<double> {
  using type = std::int64_t;
};
template <class R>
using Int = typename IntOf<R>::type;

/// Grain in the contact loop. Positions are whole numbers of a unit per axis (periodic axis: the period is 2^32 or 2^64
/// units, so that differences wrap by themselves); `rest` is what is left over from rounding, in units.
template <class R>
struct alignas(16 * sizeof(R)) Grain {
  Int<R> p[3];
  R r;         ///< radius [m]
  R v[3];      ///< velocity [m/s], half a step behind the position
  R im;        ///< 1/mass [1/kg], 0: frozen
  R w[3];      ///< spin [rad/s]
  R touching;  ///< contacts in the last step
  R rest[3];
  R ii;  ///< 1/moment of inertia [1/(kg m2)]
};
static_assert(sizeof(Grain<float>) == 64 && sizeof(Grain<double>) == 128);

/// Sums over the contacts of a grain.
template <class R>
struct alignas(8 * sizeof(R)) Load {
  R f[3];  ///< force [N]
  R k;     ///< normal stiffness [N/m]
  R t[3];  ///< torque [N m]
  R n;     ///< touching contacts
};
static_assert(sizeof(Load<float>) == 32);

inline constexpr int kBlock = 16;           ///< contacts per block, whatever the instruction set
inline constexpr std::uint32_t kUnit = 32;  ///< indices are stored times 32; the low five bits of i carry the pair type

template <class R>
struct alignas(64) Block {
  std::uint32_t i[kBlock], j[kBlock];
  R s[3][kBlock];  ///< tangential displacement of i against j [m]
  R t[3][kBlock];  ///< torque of the rolling spring on i [N m]
};

/// What the energy ledger remembers of the last step, per contact.
template <class R>
struct alignas(64) Past {
  R normal[kBlock];          ///< force of the normal damper [N]
  R tangential[3][kBlock];   ///< of the tangential damper, on j [N]
  R rolling[3][kBlock];      ///< torque of the rolling damper on i [N m]
  R rolling_spring[kBlock];  ///< energy [J]
  R cohesion[kBlock];        ///< force [N]
  void clear(std::size_t lane) {
    normal[lane] = rolling_spring[lane] = cohesion[lane] = 0;
    for (int k = 0; k < 3; ++k) tangential[k][lane] = rolling[k][lane] = 0;
  }
  /// `sign` -1: seen from the other grain.
  void copy(std::size_t lane, const Past& from, std::size_t at, R sign) {
    normal[lane] = from.normal[at];
    rolling_spring[lane] = from.rolling_spring[at];
    cohesion[lane] = from.cohesion[at];
    for (int k = 0; k < 3; ++k) {
      tangential[k][lane] = sign * from.tangential[k][at];
      rolling[k][lane] = sign * from.rolling[k][at];
    }
  }
};

/// Contact of a grain with a surface: the same history, normal from the grain into the surface.
template <class R>
struct alignas(64) WallBlock {
  std::uint32_t i[kBlock], part[kBlock];  ///< part: triangle or sphere of the surface
  R s[3][kBlock], t[3][kBlock];
  // Written by the geometry of the surface before the law runs.
  R n[3][kBlock], delta[kBlock];
  R at[3][kBlock];      ///< contact from the origin of the body
  R curvature[kBlock];  ///< 1/radius of the part, 0: flat; does not change
  Past<R> past;         ///< used with the ledger only
};
/// Of the body of a surface.
template <class R>
struct Motion {
  R v[3], w[3];  ///< velocity of its origin, spin
};

inline constexpr int kTypes = 16;  ///< pairs of materials at most

/// Coefficients of the law per pair of materials.
template <class R>
struct alignas(64) LawTable {
  R kn[kTypes];  ///< k_n = kn a [N/m], a = sqrt(R* delta) [m]
  R kt[kTypes];  ///< k_t = kt a
  R cn[kTypes];  ///< gamma_n = cn sqrt(a m*) (ch4) or cn a m* (ch3)
  R ct[kTypes];
  R mu[kTypes];
  R mur[kTypes];  ///< rolling coefficient [-] or [s2/m2]
  R kc[kTypes];   ///< cohesion energy density [J/m3]
};

/// Aligned to 128 bytes; large arrays to 2 MB and in huge pages where the system has them: neighbours lie far apart in
/// memory, and looking up small pages takes longer than the contact law. @throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);

template <class T>
struct Aligned {
  using value_type = T;
  Aligned() = default;
  template <class U>
  Aligned(const Aligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_pages(n * sizeof(T))); }
  void deallocate(T* p, std::size_t) { std::free(p); }
  template <class U>
  bool operator==(const Aligned<U>&) const {
    return true;
  }
};
template <class T>
using Array = std::vector<T, Aligned<T>>;

}  // namespace grouser::dem
