#include "effects.h"

#include <fmt/core.h>

#include <boost/math/constants/constants.hpp>
#include <stdexcept>

namespace blind {

const std::vector<Effect>& effects() {
  static const std::vector<Effect> all{
      {Id::slip_sinkage_exponent, "slip_sinkage_exponent", "1", 1.2, 0.6, 1, false, uses_none, {"slip"}, {"n"}},
      {Id::slip_sinkage_factor, "slip_sinkage_factor", "1", 1.5, 0.75, 1, false, uses_none, {"slip"}, {"k"}},
      {Id::slip_digging, "slip_digging", "m", 0.008, 0.003, 1, false, uses_none, {"slip"}, {"sinkage"}},
      {Id::pressure_rate, "pressure_rate", "1", 0.25, 0.1, 1, false, uses_speed, {"omega_rad_s"}, {"k"}},
      {Id::shear_rate, "shear_rate", "1", 0.08, 0.05, 2, false, uses_speed, {"omega_rad_s"}, {"phi"}},
      {Id::repetitive_loading, "repetitive_loading", "1", 3.0, 1.0, 1, false, uses_pass, {"pass"}, {"k"}},
      {Id::pass_strength, "pass_strength", "1", 0.25, 0.1, 1, false, uses_pass, {"pass"}, {"phi"}},
      {Id::bulldozing, "bulldozing", "1", 4.0, 1.2, 1, false, uses_none, {"load_N"}, {"drawbar"}},
      {Id::side_wall, "side_wall", "1", 6.0, 1.5, 1, false, uses_none, {"load_N"}, {"drawbar"}},
      {Id::lugs, "lugs", "m", 0.020, 0.010, 1, false, uses_none, {"slip"}, {"K", "torque"}},
      {Id::interface_friction, "interface_friction", "1", 0.5, 0.25, -1, false, uses_none, {"slip"}, {"phi"}},
      {Id::flexible_wheel, "flexible_wheel", "1", 0.4, 0.15, 1, false, uses_none, {"load_N"}, {"torque"}},
      {Id::hard_pan, "hard_pan", "1/m", 12.0, 6.0, 1, false, uses_none, {"load_N"}, {"k", "n"}},
      {Id::residual_shear, "residual_shear", "1", 0.6, 0.25, 1, false, uses_none, {"slip"}, {"phi"}},
      {Id::contact_angle_curvature,
       "contact_angle_curvature",
       "1",
       0.4,
       0.2,
       2,
       false,
       uses_none,
       {"slip"},
       {"theta_m"}},
      {Id::exit_angle, "exit_angle", "1", 0.6, 0.25, 1, false, uses_none, {"slip"}, {"theta_r"}},
      {Id::shear_modulus_load, "shear_modulus_load", "1", 1.2, 0.5, 1, false, uses_none, {"load_N"}, {"K"}},
      {Id::plate_size, "plate_size", "1", 0.8, 0.35, 2, false, uses_none, {"load_N"}, {"k"}},
      {Id::preparation_drift, "preparation_drift", "1", 0.5, 0.2, 2, false, uses_order, {"order"}, {"k"}},
      {Id::torque_offset, "torque_offset", "N m", 1.0, 0.3, 2, true, uses_none, {"slip"}, {"torque"}},
      {Id::torque_viscous, "torque_viscous", "N m s", 2.0, 0.5, 1, true, uses_speed, {"omega_rad_s"}, {"torque"}},
      {Id::torque_bearing, "torque_bearing", "m", 1e-2, 2.5e-3, 1, true, uses_none, {"load_N"}, {"torque"}},
      {Id::drawbar_bias, "drawbar_bias", "N", 8.0, 2.0, 2, true, uses_none, {"slip"}, {"drawbar"}},
      {Id::bed_slope, "bed_slope", "rad", 0.08, 0.025, 2, false, uses_none, {"load_N"}, {"drawbar"}},
      {Id::sinkage_datum, "sinkage_datum", "m", 0.008, 0.002, 2, true, uses_none, {"slip"}, {"sinkage"}},
      {Id::rig_compliance, "rig_compliance", "m/N", 6e-5, 1.5e-5, 1, true, uses_none, {"load_N"}, {"sinkage"}},
      {Id::wheel_radius_error,
       "wheel_radius_error",
       "1",
       0.08,
       0.03,
       2,
       true,
       uses_none,
       {"slip"},
       {"torque", "drawbar"}},
      {Id::load_error, "load_error", "1", 0.1, 0.035, 2, true, uses_none, {"load_N"}, {"drawbar"}},
      {Id::drawbar_gain, "drawbar_gain", "1", 0.15, 0.035, 2, true, uses_none, {"slip"}, {"drawbar"}},
      {Id::torque_gain, "torque_gain", "1", 0.15, 0.035, 2, true, uses_none, {"slip"}, {"torque"}},
      // n + x (1 - exp(-v_rim/0.04))(1 - exp(-W/100)): pore air that cannot leave a quick, heavy wheel.
      {Id::settling_exponent,
       "settling_exponent",
       "1",
       1.0,
       0.3,
       2,
       false,
       uses_speed,
       {"omega_rad_s", "load_N"},
       {"n", "k"}},
      // F += x sin(2 pi 3.5 order + 0.6): the temperature of a long campaign in the load cell's frame, several days.
      {Id::tidal_thrust, "tidal_thrust", "N", 8.0, 2.0, 1, true, uses_order, {"order", "time"}, {"drawbar"}},
      // c + x (W/100)^2: compaction bonds the soil under heavy wheels.
      {Id::load_cohesion, "load_cohesion", "Pa", 4000.0, 800.0, 1, false, uses_none, {"load_N"}, {"c", "phi"}},
      // tan phi (1 + x exp(-((s - 0.3)/0.1)^2)): dilatancy at one slip.
      {Id::dilatancy_peak, "dilatancy_peak", "1", 0.3, 0.1, 2, false, uses_none, {"slip"}, {"phi", "c"}},
      // z + x exp(-w/0.2): slow wheels dwell and creep in.
      {Id::dwell_creep, "dwell_creep", "m", 0.010, 0.003, 1, false, uses_speed, {"omega_rad_s"}, {"sinkage"}},
  };
  return all;
}

const Effect& effect(Id id) { return effects()[static_cast<std::size_t>(id)]; }

const Effect& effect(std::string_view name) {
  for (const Effect& e : effects())
    if (e.name == name) return e;
  throw std::invalid_argument(fmt::format("no effect is named '{}'", name));
}

double reported(Id id, double x) { return id == Id::interface_friction ? 1.0 + x : x; }

double from_reported(Id id, double value, std::string_view unit) {
  if (id == Id::interface_friction) return value - 1.0;
  if (id == Id::hard_pan && unit == "m") return 1.0 / value;
  if (id == Id::bed_slope && unit == "deg") return value * boost::math::constants::degree<double>();
  return value;
}

unsigned Amplitudes::uses() const {
  unsigned out = uses_none;
  for (const Effect& e : effects())
    if ((*this)[e.id] != 0) out |= e.uses;
  return out;
}

}  // namespace blind
