#pragma once
// Bekker-Wong steady wheel: stresses on the arc of a rigid smooth wheel and the six components of its force. Pure functions: no
// allocation, no exceptions, thread-safe.
#include <array>
#include <string_view>

#include "grouser/terrain/soil.h"
#include "grouser/terrain/types.h"

namespace grouser::bekker {

/// Rigid wheel, smooth or with lugs (eqs 2.14 to 2.16).
struct WheelSize {
  double radius = 0, width = 0;  ///< r without lugs, b [m] > 0
  double lug_height = 0;         ///< h_g [m] >= 0
  double lug_ratio = 0;          ///< mu, share of the lug tips in the surface, 0..1
  double outer_radius() const { return radius + lug_height; }  ///< r_s [m]
};

/// Direction of the shear stress.
enum class Lateral {
  isotropic,    ///< against the sliding velocity at the point, magnitude by |j| (eq 2.10)
  anisotropic,  ///< each direction by its own displacement, tau_i = tau_max f(|j_i|) sign(j_i) (Ishigami et al. 2007)
};

enum class ThetaMLaw {
  linear,        ///< theta_m = (a0 + a1 |s|) theta_f (B4)
  wong_braking,  ///< as linear for s >= 0; eq 2.13 for s < 0
};

/// Soil resolved for one wheel width.
struct SoilLaw {
  double modulus = 0;  ///< [Pa/m^n] p = modulus z^n
  double n = 1;        ///< [-]
  ShearLaw shear;
  double tan_phi = 0;  ///< [-]
  ContactAngles angles;
  ThetaMLaw theta_m_law = ThetaMLaw::linear;
  double ko = 0, Au = 0;  ///< unloading slope ko + Au zu [N/m^3, N/m^4] (eq 2.12); both 0 = not given
  Lateral lateral = Lateral::isotropic;

  static SoilLaw of(const BekkerSoil& soil, double wheel_width, ThetaMLaw law = ThetaMLaw::linear);
  /// Displacement over which the shear stress builds up [m]: K (type A), Kw (types B and C).
  double shear_displacement() const { return shear.type == ShearLaw::Type::A ? shear.K : shear.Kw; }
};

/// Sliding velocity of the wheel's surface at the bottom over the rolling speed, (r w - v_x, v_y)/|r w|, for travel to +x.
/// t = 1 - kappa with kappa = v_x/(r w); l = kappa tan beta. 0 = pure rolling, 1 = spinning on the spot, -> -infinity = locked.
struct ShearState {
  double t = 0, l = 0;
};
/// From kappa in (-inf, inf]; infinity = locked wheel (eq 2.7's limit of full mobilisation). beta [rad] in (-pi/2, pi/2).
ShearState shear_state(double kappa, double beta = 0);
/// Slip s = (r w - v)/max(|r w|, |v|) in [-1, 2] of a shear state, and kappa of a slip in [-1, 2).
double slip_of(ShearState e);
double kappa_of_slip(double slip);

/// Mobilised share f of tau_max at displacement j >= 0 [m], tau = (c + sigma tan phi) f(j)   (B9, ERRATA's forms of eq 2.9)
///   A: 1 - exp(-j/K)                     Janosi & Hanamoto 1961
///   B: (j/Kw) exp(1 - j/Kw)              Wong
///   C: Kr {1 + [1/(Kr (1 - 1/e)) - 1] exp(1 - j/Kw)} (1 - exp(-j/Kw))   Wong
double mobilised(const ShearLaw& law, double j);

struct ContactRange {
  double theta_f = 0, theta_m = 0, theta_r = 0;  ///< [rad]
  bool front_branch_empty = false;               ///< theta_m law gives theta_m >= theta_f: the law carries nothing
};
ContactRange contact_range(const SoilLaw& soil, double theta_f, double slip);

/// Stresses at one angle, for plots and tests [Pa], displacement [m].
struct Stress {
  double sigma = 0, tau_t = 0, tau_l = 0, j = 0;
};
Stress stress_at(const WheelSize& wheel, const SoilLaw& soil, const ContactRange& range, ShearState e, double theta);

/// Force and moment of the soil on the wheel about the hub, frame: x forward in the ground plane, y left, z up (eq 2.11).
struct WheelForces {
  double Fx = 0, Fy = 0, Fz = 0;          ///< [N] drawbar pull, side force, normal force
  double Mx = 0, My = 0, Mz = 0;          ///< [N m]; driving torque = -My
  double pressure_x = 0, pressure_z = 0;  ///< [N] part of sigma alone
  double capacity = 0;                    ///< [N] r b integral (c + sigma tan phi)
  std::array<double, 6> d_t{}, d_l{};     ///< derivatives of (Fx..Mz) by e.t and e.l at fixed theta_m [N, N m]
  ContactRange range;
  int evaluations = 0;  ///< of the stress
};

/// Gauss-Legendre with `points` per smooth piece; where tolerance > 0 the points are doubled (to 96 at most) until Fx, Fz and My/r
/// change by less than tolerance times |(Fx, Fy, Fz)|.
/// Pieces end at theta_r, theta_m, theta_f, theta_fca of lugs and where v_jt and j_t change sign or the shear direction turns
/// sharply; theta_f - theta = L x^2 at the entry, and alike at the exit, absorbs (theta_f - theta)^n. Error: see bekker/README.md.
struct Quadrature {
  int points = 10;       ///< 4..96
  double tolerance = 0;  ///< [-] 0 = fixed points
};

/// Forces at entry angle theta_f in [0, pi) [rad]. pressure_factor >= 0 scales sigma (1 = quasi-static).
/// Cost: about 0.8 us with 10 points (2 pieces), 0.9 us under moderate braking (4 pieces).
WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, Quadrature q = {},
                          double pressure_factor = 1);
/// The same with theta_m and theta_r of another slip than the shear state's own: transients, where the two settle differently.
WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, double slip,
                          Quadrature q, double pressure_factor);
WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, double kappa, double beta,
                          Quadrature q = {});

/// Sinkage at which the soil carries a load.
struct Equilibrium {
  enum class Status {
    ok,
    bad_argument,  ///< load not positive and finite, or a size not positive
    too_soft,      ///< the load is not reached with the wheel sunk to its hub
    no_pressure,   ///< theta_m >= theta_f (see ContactRange::front_branch_empty)
  } status = Status::ok;
  double theta_f = 0;  ///< [rad]
  double sinkage = 0;  ///< [m]
  WheelForces forces;
};
std::string_view name_of(Equilibrium::Status status);

/// Fz(theta_f) = load [N] to 4e-10, by the search of solve() (forces.h), for a shear state and a fixed rule. Never throws: see status.
Equilibrium steady_equilibrium(const WheelSize& wheel, const SoilLaw& soil, double load, ShearState e,
                               Quadrature q = {});

}  // namespace grouser::bekker
