#pragma once
// Named effects of the steady Bekker-Wong wheel: what the nominal law leaves out, each as one physical amplitude.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace grouser::bekker {

/// Where an effect enters.
enum class Hook {
  pressure,   ///< P: the pressure under the wheel
  shear,      ///< S: the shear stress
  geometry,   ///< G: arc of contact or radius
  force,      ///< F: a force beside those of the arc
  covariate,  ///< C: a soil parameter that depends on the run's condition
};

/// Formulas: nominal sigma = k (z/b)^n, tau = (c + sigma tan phi)(1 - exp(-j/K)), theta_m = (a0 + a1 |s|) theta_f, theta_r = 0.
/// W load, s slip, v travel speed, v_j sliding speed at the point, w angular speed. Constants: EffectConstants.
enum class Effect : std::uint8_t {
  slip_sinkage_exponent,  ///< n = n0 + n1 |s|                                               Ding et al. 2010
  slip_sinkage_factor,    ///< sigma at z / Kss^k, Kss = (1 + |s|)/(1 - 0.5 |s|)              Vasil'ev; Lyasko 2010
  slip_digging,           ///< z += h s/(1 - s), s in 0..0.95 (above it as at 0.95); bears no load     Reece 1965
  pressure_rate,          ///< sigma (v_n/v0)^m, v_n = max(v sin theta, v_min)               Pope 1969; Grahn 1991
  shear_rate,             ///< tau (1 + zeta ln(max(v_j, v_min)/v0))                         granular rheology
  repetitive_loading,     ///< pass >= 2: k (1 + kappa)                                      Wong
  pass_strength,          ///< pass >= 2: tan phi (1 + kappa)                                change of density
  bulldozing,  ///< F -= l b (rho g z^2 Kp/2 + 2 c z sqrt Kp), Kp = tan^2(pi/4 + phi/2)    Bekker 1969; Hegedus 1960
  side_wall,  ///< F -= l A (c + K0 rho g z tan phi), A segment of the disc in the soil, K0 = 1 - sin phi   Wong; Ishigami
  lugs,       ///< shear stress, its path and its lever at r + lambda h          Ding et al. 2011
  interface_friction,  ///< tau with f tan phi; f = 1 is the nominal law                  Wong
  flexible_wheel,  ///< r (1 + kappa W/W0) in all of the arc; v/w as measured, by the stated r      Bekker; Schmid 1995
  hard_pan,        ///< sigma/(1 - z/H); the amplitude is 1/H                         Bekker, layered soil
  residual_shear,  ///< tau (1 + rho exp(-j/Kw))                                      Wong; Oida
  contact_angle_curvature,  ///< theta_m += a2 s |s| theta_f                                   Wong & Reece 1967
  exit_angle,               ///< theta_r = -b0 theta_f                                         Wong & Reece 1967
  shear_modulus_load,       ///< K (W/W0)^k                                                    Wong
  plate_size,               ///< k (l/l0)^-beta, l = r sin theta_f                             Bekker
  preparation_drift,        ///< k (1 + kappa x), x = order of the run, 0..1 over the series   -
};
constexpr std::size_t effect_count = 19;

struct EffectInfo {
  Effect id;
  std::string_view name, unit;  ///< unit of what a person reads (see `inverse`)
  Hook hook;
  double off;             ///< value without the effect
  double lower, upper;    ///< physical bounds of the amplitude
  double typical;         ///< default amplitude, an ordinary size
  bool inverse;           ///< shown as 1/amplitude
  std::string_view says;  ///< what it is, for a report
  std::string_view source;
};
/// In the order of `Effect`.
const std::array<EffectInfo, effect_count>& effect_table();
std::optional<Effect> effect_of(std::string_view name);

/// Constants of the formulas. Each only sets the scale of an amplitude or is absorbed by a soil parameter.
struct EffectConstants {
  double plate_speed = 0.01;      ///< v0 [m/s]: the dissertation's plates sink at 10 mm/s
  double least_speed = 1e-3;      ///< v_min [m/s]
  double load = 100;              ///< W0 [N]
  double plate_length = 0.05;     ///< l0 [m]
  double lug_share = 0.5;         ///< lambda
  double residual_length = 0.01;  ///< Kw [m]
  double density = 1600;          ///< rho [kg/m^3]
  double gravity = 9.81;          ///< [m/s^2]
};

/// A value for each effect.
using EffectValues = std::array<double, effect_count>;
EffectValues no_effects();

}  // namespace grouser::bekker
