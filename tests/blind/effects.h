#pragma once
// The effects of the evaluation: those of the interface table and those that exist only here.
#include <string>
#include <string_view>
#include <vector>

namespace blind {

/// Order of the list `effects()`. The last five are outside the library of the engine.
enum class Id : int {
  slip_sinkage_exponent,
  slip_sinkage_factor,
  slip_digging,
  pressure_rate,
  shear_rate,
  repetitive_loading,
  pass_strength,
  bulldozing,
  side_wall,
  lugs,
  interface_friction,
  flexible_wheel,
  hard_pan,
  residual_shear,
  contact_angle_curvature,
  exit_angle,
  shear_modulus_load,
  plate_size,
  preparation_drift,
  torque_offset,
  torque_viscous,
  torque_bearing,
  drawbar_bias,
  bed_slope,
  sinkage_datum,
  rig_compliance,
  wheel_radius_error,
  load_error,
  drawbar_gain,
  torque_gain,
  settling_exponent,
  tidal_thrust,
  load_cohesion,
  dilatancy_peak,
  dwell_creep,
  count
};

constexpr int kEffects = static_cast<int>(Id::count);
constexpr int kLibraryEffects = static_cast<int>(Id::settling_exponent);

/// What a run's answer depends on beside slip and load: runs that agree in it share one computation.
enum Uses : unsigned { uses_none = 0, uses_speed = 1, uses_pass = 2, uses_order = 4 };

/// One effect. Amplitude x: 0 is the nominal wheel. `high`: largest magnitude that physics allows, `signs`: 1 positive
/// only,
/// -1 negative only, 2 both. `typical`: sd of x in the oracle's prior, a middle of the interface's typical range.
struct Effect {
  Id id;
  std::string_view name, unit;
  double high, typical;
  int signs;
  bool sensor;  ///< hook M: a measurement, never soil
  unsigned uses;
  std::vector<std::string> variables;     ///< right answers for unknown.variable
  std::vector<std::string> acts_through;  ///< right answers for unknown.acts_through
};

const std::vector<Effect>& effects();
const Effect& effect(Id id);

/// Effect by name; throws std::invalid_argument with the name.
const Effect& effect(std::string_view name);

inline bool in_library(Id id) { return static_cast<int>(id) < kLibraryEffects; }

/// Amplitude in the unit of the interface: interface_friction f = 1 + x; every other: x (hard_pan 1/H in 1/m).
double reported(Id id, double x);

/// The amplitude x that a reported value in `unit` means (hard_pan: "m" is H, "1/m" is 1/H; bed_slope also "deg").
double from_reported(Id id, double value, std::string_view unit);

/// Amplitudes of all effects, zero but for those switched on.
struct Amplitudes {
  std::vector<double> x = std::vector<double>(kEffects, 0.0);
  double operator[](Id id) const { return x[static_cast<std::size_t>(id)]; }
  double& operator[](Id id) { return x[static_cast<std::size_t>(id)]; }
  unsigned uses() const;
};

}  // namespace blind
