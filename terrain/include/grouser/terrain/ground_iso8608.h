#pragma once
// Random road of ISO 8608 with two correlated tracks.
#include <cstdint>

#include "grouser/terrain/ground.h"
#include "grouser/terrain/ground_frame.h"

namespace grouser {

/// Displacement PSD of either track (ISO 8608:2016, eq. of annex B and Table C.1), n = spatial frequency [cycles/m]:
///   (1)  Gd(n) = Gd(n0) (n/n0)^-w,  n0 = 0.1 cycles/m,  lowest <= n <= highest, zero outside
///   (2)  Gd(n0) = 16, 64, 256, ... 262144 e-6 m^3 for classes A..H (geometric mean of the class)
/// Synthesis: sum of sines at constant spacing 1/period, by inverse FFT on a grid of at least 32 nodes per shortest
/// wave:
///   (3)  z_R(s) = sum_k sqrt(2 Gd(k/period)/period) cos(2 pi k s/period + phi_k),   phi_k uniform, seeded
///   (4)  z_L: the same with phi_k +- acos(gamma(k/period)), random sign. Both tracks have exactly the PSD (1), and
///   E[z_L* z_R] per band is gamma Gd.
/// Normalised cross spectrum gamma(n) of tracks a distance b apart (gamma^2 is the magnitude-squared coherence):
///   isotropic    gamma = 2/Gamma(w/2) (X/2)^(w/2) K_{w/2}(X), X = 2 pi n b: the only one for which every direction has
///   the PSD (1)
///                (Dodds & Robson 1973, J. Sound Vib. 31; Kamash & Robson 1978)
///   exponential  gamma = exp(-decay n b)
///   full         gamma = 1: one profile across the whole width
/// Across: z = (1 - u) z_R + u z_L, u = 3q^2 - 2q^3, q = clamp(t/track_width + 1/2, 0, 1): right track at t =
/// -track_width/2, left at +track_width/2,
/// constant beyond. Between the tracks the uncorrelated part is weaker than on them: a limit of two tracks.
/// Along: cubic Hermite with the exact slopes of (3): C1, error below 1e-5 of the shortest wave's amplitude. Periodic
/// with `period`.
/// With run_in: h = 0 for s <= 0, times 3q^2 - 2q^3 over 0..run_in.
/// Memory: 32 bytes * 64 * period * highest at most (6 MB at the defaults). Cost: about 14 ns a point.
/// Same seed and settings: same bits on one platform. Classes of one seed are the same shape scaled.
struct Iso8608Settings {
  enum class Coherence { isotropic, exponential, full };
  double roughness = 256e-6;  ///< Gd(n0) [m^3] > 0
  double waviness = 2;        ///< w [-] 1..4
  double lowest = 0.011;      ///< [cycles/m] >= 2/period
  double highest = 2.83;      ///< [cycles/m] > lowest
  double track_width = 0;     ///< [m] > 0
  Coherence coherence = Coherence::isotropic;
  double decay = 0;      ///< [-] >= 0, exponential only
  double period = 1000;  ///< [m] period * highest <= 65536
  double run_in = 0;     ///< [m] 0..period
  std::uint64_t seed = 1;
  GroundFrame frame;
};
/// Gd(n0) [m^3] of class 'A'..'H'. @throws GroundError for another letter.
double iso8608_roughness(char road_class);
/// gamma(n) of two tracks b = track_width apart [-].
double iso8608_coherence(const Iso8608Settings& settings, double n);
/// @throws GroundError for settings outside these ranges.
GroundPtr iso8608_ground(const Iso8608Settings& settings);

}  // namespace grouser
