#pragma once
// Soil parameters from direct-shear and plate (pressure-sinkage) tests.
#include <string>
#include <vector>

#include "grouser/diagnosis/least_squares.h"
#include "grouser/terrain/soil.h"

namespace grouser::diagnosis {

/// One direct-shear (or annulus) test at constant normal stress. SI.
struct ShearCurve {
  std::string test;
  double normal_stress = 0;          ///< sigma [Pa] >= 0
  std::vector<double> displacement;  ///< j [m]
  std::vector<double> stress;        ///< tau [Pa]
};

enum class KMethod {
  /// c, phi and K (or Kw, Kr) together: min sum [tau - (c + sigma tan phi) f(j)]^2 (dissertation eq 3.21), f of the shear type.
  least_squares,
  /// Type A. tau_max of each test = its largest stress; c, phi: line through tau_max(sigma); K minimises
  ///   sum (1 - tau/tau_max)^2 [ln(1 - tau/tau_max) + j/K]^2  ->  K = -sum (1 - tau/tau_max)^2 j^2 / sum (1 - tau/tau_max)^2 j ln(1 - tau/tau_max)
  /// (Wong 1980, J. Terramechanics 17; Wong & Preston-Thomas 1983; Wong, Theory of Ground Vehicles, section 2.4.3). The weight keeps
  /// the logarithm's scatter near the peak small, and it is the rise that counts.
  wong
};

struct ShearTestResult {
  std::string test;
  double normal_stress = 0, tau_max = 0;  ///< [Pa] tau_max: largest measured
  double K_wong = 0;                      ///< [m] of this test alone
  double K_third = 0;  ///< [m] a third of the displacement at 0.95 tau_max (exp(-3) = 0.05); NaN when not reached
  double rms = 0;      ///< [Pa] of the pooled fit
  double lag1 = 0;     ///< autocorrelation of the residuals from one row to the next
};

struct DirectShearFit {
  ShearLaw law;
  LeastSquaresResult fit;  ///< c [Pa], phi [rad], K [m] (type A), Kw [m] (B, C), Kr [-] (C)
  std::vector<ShearTestResult> tests;
};

/// errors: `scaled` (default; the residuals of a curve are rarely independent: see lag1) or `clustered` by test.
/// @throws std::invalid_argument: no points, `wong` with another type than A.
DirectShearFit fit_direct_shear(const std::vector<ShearCurve>& curves, ShearLaw::Type type, KMethod method,
                                ErrorModel errors = ErrorModel::scaled);

/// One plate test. SI.
struct SinkageCurve {
  std::string test;
  double width = 0;  ///< b [m]: short side of a rectangle; of a disc the radius (Bekker, Wong) or what the file says
  std::vector<double> sinkage;   ///< z [m]
  std::vector<double> pressure;  ///< p [Pa]
};

/// How pressure depends on the plate (zeta = z - z0).
enum class PlateLaw {
  kc_kphi,    ///< p = (kc/b + kphi) zeta^n, kc of either sign (Bekker 1956)
  k_b,        ///< p = k (zeta/b)^n with each plate's own b (dissertation eq 3.22)
  reference,  ///< p = k (zeta/b_ref)^n for all plates: size does not matter
  power,      ///< p = k (zeta/b_ref)^n (b/b_ref)^m: what the data ask for, m free
};

struct PlateOptions {
  PlateLaw law = PlateLaw::k_b;
  double reference_width = 0.05;  ///< b_ref [m]
  bool relative_weights = false;  ///< residuals over (p + 5 % of the test's largest p) in place of Pa
  bool offset_per_test = false;   ///< z0 of each test is fitted
  ErrorModel errors = ErrorModel::clustered;
};

struct PlateTestResult {
  std::string test;
  double width = 0, n = 0, z0 = 0;     ///< [m], [-], [m]
  double modulus = 0;                  ///< [Pa/m^n] of p = modulus zeta^n, this test alone
  double pressure_at_depth = 0;        ///< [Pa] of this test's own law at the common depth
  double rms_own = 0, rms_pooled = 0;  ///< [Pa]
};

struct PlateSizeResult {
  double width = 0;  ///< b [m]
  int tests = 0;
  double pressure_at_depth = 0,
         sd = 0;      ///< [Pa] mean and sd over the tests at the common depth, measured curves interpolated
  double fitted = 0;  ///< [Pa] of the pooled law there (with the tests' mean offset)
  double n_mean = 0, n_sd = 0;
};

struct PlateFit {
  PlateLaw law = PlateLaw::k_b;
  PressureSinkage pressure;  ///< power: k at the reference width
  double size_exponent = 0;  ///< m of `power`
  LeastSquaresResult fit;    ///< kc [Pa/m^(n-1)], kphi [Pa/m^n], n | k [Pa], n | k, n, m
  std::vector<PlateTestResult> tests;
  std::vector<PlateSizeResult> sizes;
  std::vector<double> offsets;  ///< z0 [m] of each test in the pooled fit
  double common_depth = 0;      ///< [m] depth that all tests reach
  double rms = 0;               ///< [Pa] of the pooled fit over all points
  double scatter = 0;  ///< [Pa] sd between tests of one plate, pooled over plates and depths; NaN without repeats
};

/// @throws std::invalid_argument: no points, fewer than 3 points of one test below its offset, b not positive, one plate size with
/// kc_kphi or power.
PlateFit fit_plates(const std::vector<SinkageCurve>& curves, const PlateOptions& options);

/// Pressure of the fitted law at zeta = z - z0 [m] under a plate of width b.
double plate_pressure(const PlateFit& fit, double width, double zeta);

}  // namespace grouser::diagnosis
