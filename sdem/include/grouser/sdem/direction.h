#pragma once
// The law of `sdem.v2`: forces of a wheel on grains by direction of motion and by what it stands in, fitted to runs of grains (training.h).
//
// In the vertical plane of the wheel: s forward, z up; forces of a wheel as wide as the training's, r its radius. Every rate is one
// of a displacement, so nothing depends on speed:
//   b    = (atan2(r w, v_t) - 45 deg)/30 deg                     0 rolling without slip, 1 spinning, -1 dragged           (D1)
//   d    = (9 A^2/(32 r))^(1/3),  A = area of the disc below the soil as it lay before this pass                          (D2)
//   F_L  = exp(l0 + l1 b + l2 b^2 + l3 b^3 + l_e e) (d/d0)^(n0 + n1 b)   borne at that depth in level travel, d0 = 3 mm   (D3)
//   F_P  = max(F_L, p (d/d0)^q)                                  borne where the wheel is pressed without travel          (D4)
//   dN   = k dd + (F_L - N) dS/l,  N between 0 and F_P,  dS = |(v_t, r w, v_y)| dt,  dd by the motion of the wheel        (D5)
//   F_t  = u N,  du = (mu(b, d) - u) dS/l_t;   M = r m N,  dm = (tau(b, d) - m) dS/l_t                                    (D6)
//   mu, tau = c0 + c1 b + c2 b^2 + c3 T + (c4 + c5 b)(d/d0 - 1) + c6 tilt + (1 - T)/2 (c7 o + c8 max(0, e)) + (1 + T)/2 c9 e
//   T = tanh((b - middle)/sharp); tilt = slope of the contact, tangent of the angle of the normal force, positive where soil lies ahead
//   e = rise/d0 within +-2, rise = how far the soil half a radius ahead lies above the plane of the contact, met over 8 mm of
//   way; o = 1 - exp(min(0, rise)/d0):
//   in a trough, or behind a pile, soil is held and bears more; over a crest nothing holds it. No c8 in mu, no c6 in tau
// A wheel that rests is held by a spring k and does not creep; one that sinks while it travels bears F_L + k l |dz|/dS, one that climbs
// so much less. The part of the depth that is not N/k lasts.
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace grouser::sdem {

/// Coefficients by name; the order is that of the file.
enum class Coefficient {
  l0,
  l1,
  l2,
  l3,
  n0,
  n1,
  mu0,
  mu1,
  mu2,
  mu3,
  mu_d,
  mu_db,
  tau0,
  tau1,
  tau2,
  tau3,
  tau_d,
  tau_db,
  ln_l,
  ln_lt,
  ln_k,
  ln_p,
  q,
  surface,
  compaction,
  ahead0,
  ahead1,
  drag0,
  drag1,
  middle,
  ln_sharp,
  mu_s,
  mu_o,
  tau_o,
  l_e,
  tau_e,
  tau_h,
  count
};
inline constexpr std::size_t kCoefficients = static_cast<std::size_t>(Coefficient::count);
struct CoefficientInfo {
  const char *name, *what;
  double start;  ///< of the fit
  double prior;  ///< standard deviation about it; 0: not fitted
};
const std::array<CoefficientInfo, kCoefficients>& coefficient_infos();

/// What a wheel meets at one place, for D3 to D6.
struct Level {
  double force = 0;  ///< F_L [N]
  double mu = 0, tau = 0;
};

struct Direction {
  std::string title, source, wheel, soil, inputs;
  double radius = 0, width = 0;  ///< of the training's wheel [m]
  double column = 2e-3;          ///< [m]
  std::array<double, kCoefficients> c{};
  /// What means over some 0.1 m of the way of one packing differ from the law by, root mean squares over the free training runs:
  /// height [m], mu, tau.
  std::array<double, 3> spread{};
  /// Within a run about its mean: amplitudes of how much nearer grains lie than their mean surface [m], times
  /// exp(grain_turn tanh(2 (b - middle)/sharp) + grain_rise b), and of the noise of mu and tau, times exp(grain_slope b + grain_curve b^2).
  std::array<double, 3> grain{};
  double grain_turn = 0, grain_rise = 0, grain_slope = 0, grain_curve = 0;
  /// What the noise needs so that means stay, of depth [m], mu and tau: c0 + c1 tanh(2 (b - middle)/sharp).
  std::array<std::array<double, 2>, 3> grain_shift{};
  /// Distances of the random numbers along travel plus sliding [m]: depth, traction.
  std::array<double, 2> grain_length{16e-3, 8e-3};
  double grain_joint = 0;  ///< correlation of mu and tau
  /// Middle and inverse covariance of (b, ln d/d0, tilt) over the training's windows; beyond `outside_limit` a state is outside.
  std::array<double, 3> centre{};
  std::array<double, 9> inverse{};
  double outside_limit = 3.5;
  double deepest = 0;  ///< of those windows [m]; deeper is outside too

  double at(Coefficient k) const { return c[static_cast<std::size_t>(k)]; }
  double& at(Coefficient k) { return c[static_cast<std::size_t>(k)]; }
  /// D3 and targets of D6. Any (dx, rim): between the trained directions polynomials, beyond them their ends, mirrored for backward travel.
  Level level(double dx, double rim, double d, double tilt = 0, double rise = 0) const;
  double press(double d) const;                            ///< p (d/d0)^q [N]
  double b_of(double dx, double rim) const;                ///< D1, not limited
  double distance(double b, double d, double tilt) const;  ///< Mahalanobis
  double turned(double b, double sharper = 1) const;       ///< tanh(sharper (b - middle)/sharp), T of D6
  double grain_deep(double b) const;                       ///< amplitude of grain[0] at b [m]
  double grain_shifted(std::size_t k, double b) const;     ///< of depth [m], mu, tau
  double grain_share(double b) const;                      ///< exp(grain_slope b + grain_curve b^2)

  static constexpr double kDepth = 3e-3;              ///< d0 [m]
  static constexpr double kLeast = -0.55, kMost = 1;  ///< b of the polynomials: slips of the rim from -0.8 to 0.73

  std::string hash_text() const;
  std::vector<std::string> faults() const;
  void write(const std::filesystem::path& file) const;  ///< @throws ResultsError
  static Direction read(
      const std::filesystem::path& file);  ///< @throws ResultsError: truncated, other kind, wrong hash
};

}  // namespace grouser::sdem
