#include "wheel.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <stdexcept>

namespace blind {
namespace {

constexpr double kGravity = 9.81, kReferenceLoad = 100.0, kLugShare = 0.5, kMostEntry = 1.45;

Stress stress_of(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run) {
  Stress s;
  double kappa = speed_ratio(run.slip);
  // The controller kept r w and v by the wrong radius: the true ratio is v/(r_true w) with r_true = r/(1 + e).
  kappa *= 1.0 + x[Id::wheel_radius_error];
  const double slip = slip_of_ratio(kappa), grip = std::abs(slip);
  s.omega = run.omega;
  s.travel = kappa * wheel.radius;
  s.radius = wheel.radius * (1.0 + x[Id::flexible_wheel] * run.load / kReferenceLoad);
  s.lever = s.radius + kLugShare * x[Id::lugs];
  s.width = wheel.width;
  s.n = soil.n + x[Id::slip_sinkage_exponent] * grip;
  s.n += x[Id::settling_exponent] * (1.0 - std::exp(-wheel.radius * run.omega / 0.04)) *
         (1.0 - std::exp(-run.load / 100.0));
  s.k = soil.k * std::exp(run.ln_k_shift);
  if (x[Id::slip_sinkage_factor] != 0)
    s.k *= std::pow((1.0 + grip) / (1.0 - 0.5 * grip), -x[Id::slip_sinkage_factor] * s.n);
  if (run.pass >= 2) s.k *= 1.0 + x[Id::repetitive_loading];
  s.k *= 1.0 + x[Id::preparation_drift] * run.order_share;
  s.c = soil.c + x[Id::load_cohesion] * (run.load / kReferenceLoad) * (run.load / kReferenceLoad);
  s.tan_phi = std::tan(soil.phi + run.phi_shift) * (1.0 + x[Id::interface_friction]);
  if (run.pass >= 2) s.tan_phi *= 1.0 + x[Id::pass_strength];
  const double from_peak = (slip - 0.3) / 0.1;
  s.tan_phi *= 1.0 + x[Id::dilatancy_peak] * std::exp(-from_peak * from_peak);
  s.K = soil.K * std::pow(run.load / kReferenceLoad, x[Id::shear_modulus_load]);
  s.mid_share = soil.a0 + soil.a1 * grip + x[Id::contact_angle_curvature] * slip * grip;
  s.rear_share = x[Id::exit_angle];
  s.pressure_rate = x[Id::pressure_rate];
  s.shear_rate = x[Id::shear_rate];
  s.residual = x[Id::residual_shear];
  s.inverse_pan_depth = x[Id::hard_pan];
  s.plate_exponent = x[Id::plate_size];
  return s;
}

double true_load(const Amplitudes& x, const Condition& run) { return run.load * (1.0 + x[Id::load_error]); }

void refuse_unphysical(const Stress& s) {
  if (s.mid_share > -s.rear_share + 0.005 && s.mid_share < 0.985 && s.k > 0 && s.n > 0.05 && s.c >= 0 && s.K > 0 &&
      s.tan_phi > 0)
    return;
  throw std::runtime_error(
      fmt::format("no wheel: theta_m/theta_f {}, k {}, n {}, c {}, K {}", s.mid_share, s.k, s.n, s.c, s.K));
}

}  // namespace

double speed_ratio(double slip) { return slip >= 0 ? 1.0 - slip : 1.0 / (1.0 + slip); }
double slip_of_ratio(double kappa) { return kappa <= 1 ? 1.0 - kappa : 1.0 / kappa - 1.0; }

AtEntry at_entry(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run, double entry,
                 Numerics numerics) {
  const Stress s = stress_of(wheel, soil, x, run);
  refuse_unphysical(s);
  const Sums sums = arc_sums(s, entry, numerics.cells);
  AtEntry out{{sums.fx, sums.torque, sinkage(s, entry)}, sums.fz - true_load(x, run)};
  const double z = out.y.sinkage, phi = soil.phi + run.phi_shift, W = run.load;
  if (x[Id::bulldozing] != 0) {
    const double passive = std::tan(boost::math::constants::quarter_pi<double>() + 0.5 * phi);  // sqrt Kp
    out.y.drawbar -= x[Id::bulldozing] * s.width *
                     (0.5 * wheel.density * kGravity * z * z * passive * passive + 2.0 * soil.c * z * passive);
  }
  if (x[Id::side_wall] != 0) {
    const double area = s.radius * s.radius * (entry - std::sin(entry) * std::cos(entry)),
                 at_rest = 1.0 - std::sin(phi);
    out.y.drawbar -= x[Id::side_wall] * area * (soil.c + at_rest * wheel.density * kGravity * z * std::tan(phi));
  }
  out.y.drawbar -= W * std::tan(x[Id::bed_slope]);
  out.y.drawbar +=
      x[Id::tidal_thrust] * std::sin(boost::math::constants::two_pi<double>() * 3.5 * run.order_share + 0.6);
  if (run.slip > 0) {
    const double dug = std::min(run.slip, 0.95);
    out.y.sinkage += x[Id::slip_digging] * dug / (1.0 - dug);
  }
  out.y.sinkage += x[Id::dwell_creep] * std::exp(-run.omega / 0.2);
  // The sensors, after everything that happens in the soil.
  out.y.drawbar = out.y.drawbar * (1.0 + x[Id::drawbar_gain]) + x[Id::drawbar_bias];
  out.y.torque = out.y.torque * (1.0 + x[Id::torque_gain]) + x[Id::torque_offset] + x[Id::torque_viscous] * run.omega +
                 x[Id::torque_bearing] * W;
  out.y.sinkage += x[Id::sinkage_datum] + x[Id::rig_compliance] * W;
  return out;
}

double entry_angle(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run, double guess,
                   Numerics numerics) {
  const Stress s = stress_of(wheel, soil, x, run);
  refuse_unphysical(s);
  const double load = true_load(x, run);
  const auto balance = [&](double entry) { return arc_sums(s, entry, numerics.cells).fz / load - 1.0; };
  double low = guess, high = guess, at_low = balance(guess), at_high = at_low;
  for (double factor = 1.01; at_low > 0; factor *= factor) {
    high = low;
    at_high = at_low;
    low /= factor;
    if (low < 1e-4) throw std::runtime_error("no entry angle carries so little");
    at_low = balance(low);
  }
  for (double factor = 1.01; at_high < 0; factor *= factor) {
    low = high;
    at_low = at_high;
    if (high >= kMostEntry) throw std::runtime_error(fmt::format("no entry angle carries {} N", load));
    high = std::min(high * factor, kMostEntry);
    at_high = balance(high);
  }
  if (at_low == 0) return low;
  if (at_high == 0) return high;
  std::uintmax_t steps = 100;
  const boost::math::tools::eps_tolerance<double> close(38);
  const auto root = boost::math::tools::toms748_solve(balance, low, high, at_low, at_high, close, steps);
  return 0.5 * (root.first + root.second);
}

Channels simulate(const Wheel& wheel, const Soil& soil, const Amplitudes& x, const Condition& run, Numerics numerics) {
  return at_entry(wheel, soil, x, run, entry_angle(wheel, soil, x, run, 0.5, numerics), numerics).y;
}

}  // namespace blind
