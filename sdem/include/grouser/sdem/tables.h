#pragma once
// The two look-up tables of the surrogate (dissertation section 5.2, eqs 3.23 and 3.24) as data and as one file.
//
//   soil velocity   (S_vx, S_vz) = f(w, vx, vz, dx, dz)                 four regions: bottom, top, left, right       (T1)
//   wheel pressure  (S_px, S_pz) = f(w, vx, vz, theta, height)          bottom of the wheel                          (T2)
//                   (S_px, S_pz) = f(w, vx, vz, theta, profile)         top of the wheel                             (T3)
//
// w spin [rad/s] and vx, vz velocity [m/s] of the wheel, forward and up; dx, dz place relative to the hub [m]; theta angle about the axle
// [rad], positive forward, from the lowest point (bottom) or the highest (top); height of the hub above the floor [m]; profile: height of
// the soil above the hub [m]; pressures [Pa] are forces of the soil on the wheel per rim area, along x and z.
//
// T1 is the published six-dimensional table at dz = profile: points of the surface, the only ones that a wheel needs, lie at the profile by
// definition, so the sixth axis repeats the fifth (813 MB become 8 MB in float).
// Regions (Table 5.2) have grids of their own that end on the border, so nothing is interpolated across the wheel:
//   bottom |dx| <= r, -m <= dz <= 0;  top |dx| <= r, 0 <= dz <= m;  left -m <= dx <= -r, |dz| <= m;  right r <= dx <= m;  m = reach
#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/terrain/recorder.h"

namespace grouser::sdem {

/// Values at `count` even places from `first` to `last`, both included; count >= 2.
struct Axis {
  double first = 0, last = 1;
  int count = 2;
  double step() const { return (last - first) / (count - 1); }
  double at(int i) const { return i == count - 1 ? last : first + i * step(); }
  /// Even places no further apart than about `spacing`.
  static Axis even(double first, double last, double spacing);
};

/// Two values (x and z component) over two axes for every velocity node: [node][u][v], v fastest.
struct Grid {
  Axis u, v;
  std::vector<float> x, z;
  /// [1] 1 where a run gave the value, 0 where it was estimated from its neighbours; as large as x.
  std::vector<float> known;
  std::size_t plane() const { return static_cast<std::size_t>(u.count) * static_cast<std::size_t>(v.count); }
  std::size_t index(std::size_t node, int i, int j) const {
    return node * plane() + static_cast<std::size_t>(i) * static_cast<std::size_t>(v.count) +
           static_cast<std::size_t>(j);
  }
  void resize(std::size_t nodes);
};

/// Soil velocity [m/s]: u = dz, v = dx. Pressure [Pa]: u = height or profile, v = theta.
enum class Part { soil_bottom, soil_top, soil_left, soil_right, wheel_bottom, wheel_top };
inline constexpr std::array<const char*, 6> kPartNames{"soil_bottom", "soil_top",     "soil_left",
                                                       "soil_right",  "wheel_bottom", "wheel_top"};

/// Sizes that the dissertation states (4 mm, 0.39 m wide) or leaves open (theta, height).
struct GridSettings {
  double reach = 0.195;        ///< m [m], half of the window
  double cell = 0.004;         ///< of dx, dz [m]; nearest that divides each region evenly
  double angle = 0.034906585;  ///< of theta, 2 degrees [rad]; open in the dissertation
  double height = 0.004;       ///< of height and profile [m]; open in the dissertation
  double lowest = 0.095;       ///< hub above the floor [m]
  double highest = 0.24;
};

struct Tables {
  std::string title, source;
  std::string wheel;              ///< name of the wheel
  double radius = 0;              ///< r [m]
  double width = 0;               ///< of the slab that the pressures were measured in [m]
  double bed_depth = 0;           ///< undisturbed surface above the floor [m]
  std::string soil;               ///< inputs of the grains, one "name value" per line
  std::string inputs;             ///< everything they were made from
  std::vector<double> w, vx, vz;  ///< nodes, ascending [rad/s], [m/s]; every combination is there
  std::array<Grid, 6> parts;

  const Grid& part(Part p) const { return parts[static_cast<std::size_t>(p)]; }
  Grid& part(Part p) { return parts[static_cast<std::size_t>(p)]; }
  std::size_t nodes() const { return w.size() * vx.size() * vz.size(); }
  std::size_t node(std::size_t iw, std::size_t ix, std::size_t iz) const {
    return (iw * vx.size() + ix) * vz.size() + iz;
  }
  std::size_t bytes() const;  ///< of the values

  /// Empty tables (all zero) with the grids of `g`; radius and the nodes must be set.
  void shape(const GridSettings& g);
  /// 16 hexadecimal digits of everything above (64-bit FNV-1a).
  std::string hash_text() const;
  /// What is wrong with them: sizes, order of nodes, values that are not finite. Empty: nothing.
  std::vector<std::string> faults() const;

  /// Written whole or not at all: single precision, compressed. @throws ResultsError.
  void write(const std::filesystem::path& file) const;
  /// @throws ResultsError that names the file: missing, truncated, not tables, other format, content that does not match its hash, faults().
  static Tables read(const std::filesystem::path& file);
};

}  // namespace grouser::sdem
