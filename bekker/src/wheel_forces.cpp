#include "grouser/bekker/wheel_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "arc.h"
#include "pieces.h"
#include "stress.h"

namespace grouser::bekker {

namespace {

constexpr double kLocked =
    1e9;  // e of a locked wheel: exp(-j/K) underflows everywhere but within 1e-8 rad of the entry
WheelForces integrate(const Arc& arc, const ContactRange& range, int points) {
  WheelForces out;
  out.range = range;
  const Pieces pieces = pieces_of(arc, 1e-6, false);
  const GaussRule& rule = gauss_rule(points);
  SlopeSums s;
  for (int i = 0; i < pieces.count; ++i) {
    const MappedPiece& m = pieces.at[i];
    kernel().integrate_slopes(arc, m.piece, std::min(m.p, 2), std::min(m.q, 2), rule, s);
  }
  out.evaluations = pieces.count * rule.n;
  const double rb = arc.r * arc.b, rrb = rb * arc.r;
  out.Fx = rb * s.Fx;
  out.Fy = rb * s.Fy;
  out.Fz = rb * s.Fz;
  out.Mx = rrb * s.Mx;
  out.My = rrb * s.My;
  out.Mz = rrb * s.Mz;
  out.pressure_x = rb * s.pressure_x;
  out.pressure_z = rb * s.pressure_z;
  out.capacity = rb * s.capacity;
  for (int i = 0; i < 6; ++i) {
    out.d_t[i] = (i < 3 ? rb : rrb) * s.d_t[i];
    out.d_l[i] = (i < 3 ? rb : rrb) * s.d_l[i];
  }
  return out;
}

}  // namespace

SoilLaw SoilLaw::of(const BekkerSoil& soil, double wheel_width, ThetaMLaw law) {
  const RepetitiveLoading r = soil.repetitive.value_or(RepetitiveLoading{});
  return {soil.pressure.modulus(wheel_width),
          soil.pressure.n,
          soil.shear,
          std::tan(soil.shear.friction_angle),
          soil.angles,
          law,
          r.ko,
          r.Au};
}

ShearState shear_state(double kappa, double beta) {
  if (std::abs(kappa) > kLocked) kappa = kappa > 0 ? kLocked : -kLocked;
  return {1 - kappa, kappa * std::tan(beta)};
}

double slip_of(ShearState e) { return e.t / std::max(1.0, std::abs(1 - e.t)); }

double kappa_of_slip(double s) {
  if (s <= -1) return std::numeric_limits<double>::infinity();
  if (s < 0) return 1 / (1 + s);
  return s <= 1 ? 1 - s : 1 / (1 - s);
}

double mobilised(const ShearLaw& law, double j) {
  SoilLaw soil;
  soil.shear = law;
  return mobilised_at(Arc({}, soil, {}, {}), j).f;
}

ContactRange contact_range(const SoilLaw& soil, double theta_f, double slip) {
  ContactRange c;
  c.theta_f = theta_f;
  const double s = std::abs(slip);
  if (soil.theta_m_law == ThetaMLaw::wong_braking && slip < 0) {
    const double x = std::tan(pi / 4 - soil.shear.friction_angle / 2);
    c.theta_m =
        std::max(0.0, std::acos((1 + slip) / std::sqrt(1 + x * x)) - std::atan(x));  // 0 at slip 0 but for rounding
  } else {
    c.theta_m = (soil.angles.a0 + soil.angles.a1 * s) * theta_f;
  }
  c.theta_r = -(soil.angles.b0 + soil.angles.b1 * s) * theta_f;
  c.front_branch_empty = c.theta_m >= theta_f;
  return c;
}

Stress stress_at(const WheelSize& wheel, const SoilLaw& soil, const ContactRange& range, ShearState e, double theta) {
  if (theta < range.theta_r || theta > range.theta_f || range.front_branch_empty) return {};
  const Arc arc(wheel, soil, {range.theta_f, range.theta_m, range.theta_r}, e);
  const StressPoint<double> p = stress_of<false>(arc, place_of(arc, theta), false);
  return {p.sigma, p.tau_t, p.tau_l, p.j};
}

WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, Quadrature q,
                          double pressure_factor) {
  return steady_forces(wheel, soil, theta_f, e, slip_of(e), q, pressure_factor);
}

WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, double slip,
                          Quadrature q, double pressure_factor) {
  WheelForces out;
  e.t = std::clamp(e.t, -kLocked, kLocked);
  e.l = std::clamp(e.l, -kLocked, kLocked);
  const ContactRange range = contact_range(soil, theta_f, slip);
  out.range = range;
  if (!(theta_f > 0) || range.front_branch_empty) return out;  // no arc, or a law that carries nothing
  const Arc arc(wheel, soil, {range.theta_f, range.theta_m, range.theta_r}, e, 0, pressure_factor);
  out = integrate(arc, range, q.points);
  if (q.tolerance > 0) {
    int evaluations = out.evaluations;
    for (int points = 2 * q.points; points <= 96; points *= 2) {
      const WheelForces finer = integrate(arc, range, points);
      evaluations += finer.evaluations;
      const double scale = q.tolerance * std::hypot(finer.Fx, finer.Fy, finer.Fz);
      const bool done = std::abs(finer.Fx - out.Fx) <= scale && std::abs(finer.Fy - out.Fy) <= scale &&
                        std::abs(finer.Fz - out.Fz) <= scale && std::abs(finer.My - out.My) <= scale * arc.r;
      out = finer;
      if (done) break;
    }
    out.evaluations = evaluations;
  }
  return out;
}

WheelForces steady_forces(const WheelSize& wheel, const SoilLaw& soil, double theta_f, double kappa, double beta,
                          Quadrature q) {
  return steady_forces(wheel, soil, theta_f, shear_state(kappa, beta), q, 1);
}

}  // namespace grouser::bekker
