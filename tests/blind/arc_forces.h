#pragma once
// The nominal wheel of the evaluation: stresses on the arc and their sums, written without any code of the library
// under test.

namespace blind {

/// Stresses at one wheel position, everything that a run needs with effects already resolved into numbers. SI, radians.
///   sigma = k (z/w)^n plate (v_n/v0)^m/(1 - z/H),  tau = (c + sigma tan phi)(1 - exp(-j/K))(1 + rho exp(-j/Kw))(1 +
///   zeta ln(v_j/v0))
///   j = |R (theta_f - theta) - q (sin theta_f - sin theta)|, against the sliding velocity R - q cos theta
struct Stress {
  double radius = 0.13, width = 0.16, reference_width = 0.16;
  double k = 0, n = 1, c = 0, tan_phi = 0, K = 1;
  double mid_share = 0.2;                    ///< theta_m/theta_f
  double rear_share = 0.0;                   ///< -theta_r/theta_f
  double lever = 0.13;                       ///< R [m], where the shear stress acts: r, or r + lambda h with lugs
  double travel = 0.13;                      ///< q = v/w [m]
  double omega = 0.3;                        ///< w [rad/s]
  double pressure_rate = 0, shear_rate = 0;  ///< m, zeta
  double residual = 0;                       ///< rho, with Kw = 10 mm
  double inverse_pan_depth = 0;              ///< 1/H
  double plate_exponent = 0;                 ///< beta: k (r sin theta_f/l0)^-beta, l0 = 0.05 m
};

struct Sums {
  double fx = 0, fz = 0, torque = 0;
};

constexpr double kRateSpeed = 0.01, kRateFloor = 0.001, kResidualLength = 0.010, kPlateLength = 0.05;

/// Sinkage of the lowest point [m] at an entry angle.
double sinkage(const Stress& s, double entry);

/// Eq 2.11 by the double exponential rule (Takahasi & Mori 1974) on pieces cut where the integrand bends: theta_m, the
/// two zeros of
/// the sliding velocity, the zero of j, the end of the shear layer at the entry and kinks of the rate laws.
/// `cells` > 0: instead the midpoint rule with so many cells on each side of theta_m, the coarse scheme of the benign
/// mismatch.
/// Cost: 45 points a piece, 2 to 7 pieces. Relative error below 1e-8 (tested), midpoint: what the cells give.
Sums arc_sums(const Stress& s, double entry, int cells = 0);

}  // namespace blind
