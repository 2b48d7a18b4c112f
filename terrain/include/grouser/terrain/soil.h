#pragma once
// One soil: everything any model needs of it, each value with its source. Loaded by soil_loader.h.
#include <optional>
#include <string>

#include "grouser/terrain/config.h"

namespace grouser {

/// Pressure-sinkage law p(z) of a plate, one law in two notations (Bekker 1956; Wong 2010 eq 2.4; dissertation eqs 2.4, 3.22):
///   kc_kphi:  p = (kc/b + kphi) z^n       kc [N/m^(n+1)], kphi [N/m^(n+2)]
///   k_b:      p = k (z/b)^n               k [Pa]
/// b is the reference width: `wheel` (the wheel's own) or a stated length (the plate's short side, 0.05 m by default for k_b). It is data, never code.
struct PressureSinkage {
  enum class Law { kc_kphi, k_b } law = Law::kc_kphi;
  double kc = 0, kphi = 0;     ///< kc_kphi
  double k = 0;                ///< k_b [Pa]
  double n = 1;                ///< [-] 0.05..4
  double reference_width = 0;  ///< [m]; 0 = the wheel's own width
  /// Modulus [Pa/m^n] such that p = modulus * z^n under running gear of width b [m].
  double modulus(double wheel_width) const;
};

/// tau = (c + sigma tan phi) * f(j), f by type (Janosi & Hanamoto 1961; Wong 2010): A = 1 - exp(-j/K).
struct ShearLaw {
  enum class Type { A, B, C } type = Type::A;
  double cohesion = 0;        ///< c [Pa] >= 0
  double friction_angle = 0;  ///< phi [rad] 0..pi/2
  double K = 0;               ///< [m] > 0, type A
  double Kw = 0;              ///< [m] > 0, types B and C: displacement at the peak
  double Kr = 1;              ///< [-] 0..1, type C: residual over peak
};

/// theta_m = (a0 + a1 |s|) theta_f, theta_r = -(b0 + b1 |s|) theta_f (Wong & Reece 1967; dissertation eq 2.5, Table 4.6).
struct ContactAngles {
  double a0 = 0.18, a1 = 0.32, b0 = 0, b1 = 0;
};

/// Unloading slope ko + Au zu (Wong; dissertation eq 2.12).
struct RepetitiveLoading {
  double ko = 0;  ///< [N/m^3]
  double Au = 0;  ///< [N/m^4]
};

struct BekkerSoil {
  PressureSinkage pressure;
  ShearLaw shear;
  ContactAngles angles;
  std::optional<RepetitiveLoading> repetitive;
};

/// Hard ground as a spring-damper with Coulomb friction.
struct RigidSoil {
  double stiffness = 2e5;           ///< [N/m] per wheel
  double damping = 1e3;             ///< [N s/m] per wheel, acts in compression only
  double friction = 0.8;            ///< [-] Coulomb
  double rolling_resistance = 0;    ///< [-] torque / (normal force * radius)
  double tangential_stiffness = 0;  ///< [N/m] of the stick spring; 0 = the normal stiffness
};

struct Soil {
  std::string name;
  std::string source;
  std::optional<BekkerSoil> bekker;
  std::optional<RigidSoil> rigid;
  /// Section `dem:`, grains; absent when the file has none. A node, since only the module dem knows its keys: it reads them (and notes
  /// their errors in the soil's document) when a model is made from it.
  ConfigNode dem;
  double bulk_density = 0;  ///< [kg/m^3]; 0 = not given
};

}  // namespace grouser
