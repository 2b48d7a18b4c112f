#pragma once
#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// Of half the entry angle and of the slip angle.
struct ArcSines {
  double sin_half, cos_half, tan_beta;
};

/// Everything that is the same for all points of one arc of contact. Filled once per wheel force.
struct Arc {
  static constexpr bool kFeatures = true;    ///< may have lugs, reload, be locked (stress.h)
  static constexpr bool kTenDigits = false;  ///< of the functions: all instead
  // Geometry. Stresses, displacements and integrals are at r = r_s (lug tips).
  double r = 0, b = 0;
  double theta_f = 0, theta_m = 0, theta_r = 0;
  double sin_half = 0, cos_half = 0;  ///< of theta_f/2
  double sin_f = 0, cos_f = 0;        ///< of theta_f
  double stretch = 0;                 ///< (theta_f - theta_m)/(theta_m - theta_r); 0 where the rear branch is empty
  // Pressure.
  double modulus = 0, n = 1;           ///< sigma = modulus z^n; the modulus holds the rate factor
  double zu = 0, slope = 0, peak = 0;  ///< eq 2.12 for z < zu: max(0, peak - slope (zu - z)); zu = 0 virgin soil
  // Lugs: share mu of the tips; the concave surface r_ca enters at theta_ca (0: carries nothing).
  bool lugs = false, concave = false;
  double mu = 1, r_ca = 0, theta_ca = 0, sin_ca = 0, cos_ca = 1, stretch_ca = 0;
  // Shear.
  ShearLaw::Type type = ShearLaw::Type::A;
  double cohesion = 0, tan_phi = 0, inv_K = 0;  ///< inv_K: 1/K (A), 1/Kw (B, C)
  double Kr = 1, hump = 0;                      ///< type C; hump = e [1/(Kr (1 - 1/e)) - 1]
  bool anisotropic = false;
  bool locked = false;  ///< full mobilisation in the direction (-cos theta, tan beta)
  ShearState e;
  double tan_beta = 0;  ///< used where locked

  /// Angles, sizes and soil must be in range: see status_of.
  Arc(const WheelSize& wheel, const SoilLaw& soil, const ArcAngles& angles, ShearState e, double zu = 0,
      double pressure_factor = 1);
  /// Slip and slip angle as in ForceCase, locked at slip -1.
  explicit Arc(const ForceCase& c);

 private:
  Arc(const WheelSize& wheel, const SoilLaw& soil, const ArcAngles& angles, ShearState e, double zu,
      double pressure_factor, const ArcSines& sines);
};

/// ok, bad_argument or no_pressure.
ForceStatus status_of(const ForceCase& c);

/// Stresses at one angle [Pa].
struct ArcStress {
  double sigma = 0, tau_t = 0, tau_l = 0;
};
/// Their derivatives at fixed angles by the shear state [Pa].
struct ArcSlope {
  double tau_t_by_t = 0, tau_l_by_t = 0, tau_t_by_l = 0, tau_l_by_l = 0;
};

/// Stresses with derivatives at one angle.
ArcStress stress_at(const Arc& arc, double theta, ArcSlope& slope);

}  // namespace grouser::bekker
