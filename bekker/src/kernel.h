#pragma once
// The inner loop over the points of an arc, compiled once per instruction set and chosen at run time.
#include <array>

#include "arc.h"
#include "gauss_rule.h"
#include "rows.h"

namespace grouser::bekker {

/// Nodes and weights on [0, 1] under the map x = phi(y), phi' ~ y^(p-1) (1-y)^(q-1), of the n-point Gauss-Legendre rule
/// in y, so that x^a with a > 0 becomes x^(p a) at 0 and likewise at 1. n is a multiple of 8.
struct MappedRule {
  int n = 0;
  const double* x = nullptr;  ///< phi(y_i)
  const double* w = nullptr;  ///< weight times phi'(y_i)
  const double* null =
      nullptr;  ///< null rule of degree n - 1: sum null_i w_i f_i is the size of f's highest Legendre coefficients in y
};
inline constexpr std::array<int, 8> kRuleSizes{8, 16, 24, 32, 40, 48, 64, 96};
inline constexpr int kLargestPower = 4;
/// size_index into kRuleSizes; p, q in 1..kLargestPower.
const MappedRule& mapped_rule(int size_index, int p, int q);

/// Stretch of the arc without a kink inside. Its coordinate is theta_f - theta ahead of theta_m, theta - theta_r
/// behind.
struct Piece {
  double start, length;
  bool front;
};

/// Integrals over theta of the densities of eq 2.11 (per r b, moments per r^2 b) and the null sums of the three
/// stresses.
struct PieceSums {
  double Fx, Fy, Fz, Mx, My, Mz, null_sigma, null_t, null_l;
};

/// The same with the parts of the pressure, the shear capacity and the derivatives by the shear state.
struct SlopeSums {
  double Fx = 0, Fy = 0, Fz = 0, Mx = 0, My = 0, Mz = 0, pressure_x = 0, pressure_z = 0, capacity = 0;
  std::array<double, 6> d_t{}, d_l{};  ///< of Fx..Mz by e_t and by e_l
};

/// Integrals over the arc of the stresses alone and times sin theta and cos theta.
struct StressSums {
  double sigma_sine = 0, sigma_cosine = 0, t_one = 0, t_sine = 0, t_cosine = 0, l_one = 0, l_sine = 0, l_cosine = 0;
};

struct Kernel {
  const char* name;
  ArcSines (*sines)(double theta_f, double beta);  ///< theta_f in 0..pi, beta within pi/2
  PieceSums (*integrate)(const Arc&, const Piece&, const MappedRule&);
  /// Adds to the sums. p, q in 1..2 as in MappedRule; any number of points.
  void (*integrate_slopes)(const Arc&, const Piece&, int p, int q, const GaussRule&, SlopeSums&);
  /// Of the quadratic or linear form (product_rule.h).
  StressSums (*closed_form)(const Arc&, Method);
  /// Rows of one shear law and lateral model. plan_rows also turns slip and slip angle into the shear state.
  void (*plan_rows)(Rows&, ShearLaw::Type, bool anisotropic, RowPlan&);
  void (*integrate_rows)(const Rows&, ShearLaw::Type, bool anisotropic, const RowRule& front, const RowRule& rear,
                         RowSums&);
};
extern const Kernel kernel_base;
#ifdef __x86_64__
extern const Kernel kernel_avx2, kernel_avx512;
#endif
/// The widest that this processor has.
const Kernel& kernel() noexcept;

}  // namespace grouser::bekker
