#pragma once
// Slip steps of a single wheel with something hidden, written without any code of the library: the steady wheel of tests/blind (double
// exponential rule, TOMS 748), the dynamics by exponential Euler with 40 steps to a row.
#include <cstdint>
#include <string>
#include <vector>

namespace hidden {

enum class What {
  nothing,
  soil,        ///< nothing, but the soil is three prior sd off in k and two in phi
  scattered,   ///< nothing, but ln k scatters by 0.06 from run to run
  relaxation,  ///< first order over travel
  filter,      ///< first order in time
  delay,
  ripple,
  relaxation_and_ripple,
  two_scales,  ///< outside: 0.55 fast and 0.45 ten times slower, over travel
  one_sensor,  ///< outside: the filter is on the torque sensor alone
  overshoot,   ///< outside: the answer swings past (second order over travel, damping 0.3)
};
const char* name_of(What w);
/// The name the engine should give; empty where none is right.
std::string right_name(What w);

struct Plan {
  std::vector<double> travel{0.03, 0.09};  ///< [m/s] of each run
  double spacing = 0.1, duration = 20;     ///< [s]
  double rho = 0.6;                        ///< correlation of neighbouring rows' noise
  double ramp = 0.3;                       ///< [s] of each slip step
};

struct Set {
  std::string csv;
  double size = 0;  ///< sigma [m], tau [s], delay [s], amplitude of the drawbar [N]
  double d = 0;     ///< as asked for: length of the fingerprint in whitened noise, nothing refitted
};

constexpr int lugs = 12;
constexpr double radius = 0.13, width = 0.16, load = 115;
/// Noise of a row: 2 N, 0.2 N m, 1.5 mm.
constexpr double noise[3] = {2, 0.2, 0.0015};

/// One set whose hidden effect is as large as `d` noise sd; the same for the same seed.
Set make(What what, double d, std::uint64_t seed, const Plan& plan = {});

/// CASE.yaml for it.
std::string case_text(bool scatter = false);

}  // namespace hidden
