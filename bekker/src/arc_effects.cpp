#include "arc_effects.h"

#include <algorithm>

#include "effect_arc.h"
#include "pieces.h"
#include "stress.h"

namespace grouser::bekker {

namespace {

constexpr int kPoints = 20;  // rates and pans bend the stresses where the pieces have no end

WheelForces integrate(const EffectArc& arc, const ContactRange& range, int points) {
  WheelForces out;
  out.range = range;
  const Pieces pieces = pieces_of(arc, 1e-6, false);
  const GaussRule& rule = gauss_rule(points);
  // Pressure acts at r, shear at R: forces go with R/r, moments with its square.
  const double q = arc.shear_radius / arc.r, rb = arc.r * arc.b;
  const auto add = [&](std::array<double, 6>& d, double t, double l, double sine, double cosine) {
    const double lever = q * arc.shear_radius;
    d[0] += q * t * cosine;
    d[1] -= q * l;
    d[2] += q * t * sine;
    d[3] -= lever * l * cosine;
    d[4] -= lever * t;
    d[5] -= lever * l * sine;
  };
  std::array<double, 6> shear{};
  for (int k = 0; k < pieces.count; ++k) {
    const MappedPiece& m = pieces.at[static_cast<std::size_t>(k)];
    const int p = std::min(m.p, 2), e = std::min(m.q, 2);
    const double c1 = p == 1 ? e : 0, c2 = p == 1 ? 1 - e : 2 * e - 1, c3 = p == 2 ? 2 - 2 * e : 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(points); ++i) {
      const double y = rule.x[i], s = m.piece.start + m.piece.length * (y * (c1 + y * (c2 + y * c3)));
      const double w = rb * m.piece.length * rule.w[i] * (c1 + y * (2 * c2 + y * (3 * c3)));
      const Place<double> place =
          m.piece.front ? Place<double>{s, s, s - (arc.theta_f - arc.theta_ca)}
                        : Place<double>{(arc.theta_f - arc.theta_r) - s, s * arc.stretch, s * arc.stretch_ca};
      const StressPoint<double> at = stress_of<true>(arc, place, m.piece.front);
      out.pressure_x -= w * at.sigma * at.sin;
      out.pressure_z += w * at.sigma * at.cos;
      out.capacity += w * q * at.tau_max;
      add(shear, w * at.tau_t, w * at.tau_l, at.sin, at.cos);
      add(out.d_t, w * at.t_by_t, w * at.l_by_t, at.sin, at.cos);
      add(out.d_l, w * at.t_by_l, w * at.l_by_l, at.sin, at.cos);
    }
  }
  out.Fx = out.pressure_x + shear[0];
  out.Fy = shear[1];
  out.Fz = out.pressure_z + shear[2];
  out.Mx = shear[3];
  out.My = shear[4];
  out.Mz = shear[5];
  out.evaluations = pieces.count * points;
  return out;
}

}  // namespace

ArcEffects::ArcEffects(const EffectConstants& constants, double radius, double reference_width, int pass, double order)
    : constants_(constants), radius_(radius), reference_width_(reference_width), order_(order), pass_(pass) {}

void ArcEffects::set(Effect e, double amplitude) {
  const auto i = static_cast<std::size_t>(e);
  value_[i] = amplitude;
  const std::uint32_t bit = 1U << i;
  active_ = amplitude == effect_table()[i].off ? active_ & ~bit : active_ | bit;
}

WheelSize ArcEffects::size(const WheelSize& nominal, double load) const {
  WheelSize s = nominal;
  if (on(Effect::flexible_wheel)) s.radius *= 1 + of(Effect::flexible_wheel) * relative_load(load);
  return s;
}

double ArcEffects::shear_radius(const WheelSize& loaded) const {
  const double r = loaded.outer_radius();
  return on(Effect::lugs) ? r + constants_.lug_share * of(Effect::lugs) : r;
}

SoilLaw ArcEffects::law(const SoilLaw& nominal, double theta_f, double slip, double load) const {
  SoilLaw s = nominal;
  const double size = std::abs(slip);
  if (on(Effect::slip_sinkage_exponent)) {
    const double more = of(Effect::slip_sinkage_exponent) * size;
    s.n += more;
    s.modulus /= std::pow(reference_width_, more);
  }
  if (on(Effect::slip_sinkage_factor))
    s.modulus *= std::pow((1 + size) / (1 - 0.5 * size), -of(Effect::slip_sinkage_factor) * s.n);
  if (on(Effect::repetitive_loading) && pass_ >= 2) s.modulus *= 1 + of(Effect::repetitive_loading);
  if (on(Effect::preparation_drift)) s.modulus *= 1 + of(Effect::preparation_drift) * order_;
  if (on(Effect::plate_size)) {
    const double length = radius_ * (theta_f < 0.5 * pi ? std::sin(theta_f) : 1.0);
    s.modulus *= std::pow(length / constants_.plate_length, -of(Effect::plate_size));
  }
  if (on(Effect::shear_modulus_load)) {
    const double k = std::pow(relative_load(load), of(Effect::shear_modulus_load));
    s.shear.K *= k;
    s.shear.Kw *= k;
  }
  if (on(Effect::pass_strength) && pass_ >= 2) s.tan_phi *= 1 + of(Effect::pass_strength);
  if (on(Effect::interface_friction)) s.tan_phi *= of(Effect::interface_friction);
  if (on(Effect::exit_angle)) s.angles.b0 += of(Effect::exit_angle);
  return s;
}

double ArcEffects::dug(double slip) const {
  if (!on(Effect::slip_digging) || slip <= 0) return 0;
  const double s = std::min(slip, 0.95);
  return of(Effect::slip_digging) * s / (1 - s);
}

double ArcEffects::resistance(const WheelSize& loaded, const SoilLaw& nominal, double theta_f) const {
  if (!on(Effect::bulldozing) && !on(Effect::side_wall)) return 0;
  const double r = loaded.outer_radius(), c = nominal.shear.cohesion, phi = nominal.shear.friction_angle;
  const double half = std::sin(0.5 * theta_f), z = 2 * r * half * half,
               weight = constants_.density * constants_.gravity;
  double F = 0;
  if (on(Effect::bulldozing)) {
    const double root = std::tan(0.25 * pi + 0.5 * phi);
    F += of(Effect::bulldozing) * loaded.width * (0.5 * weight * z * z * root * root + 2 * c * z * root);
  }
  if (on(Effect::side_wall)) {
    const double stronger = on(Effect::pass_strength) && pass_ >= 2 ? 1 + of(Effect::pass_strength) : 1;
    const double segment = r * r * (theta_f - std::sin(theta_f) * std::cos(theta_f));
    F += of(Effect::side_wall) * segment * (c + (1 - std::sin(phi)) * weight * z * stronger * nominal.tan_phi);
  }
  return F;
}

double ArcEffects::pan_stiffness(double sinkage) const {
  if (!on(Effect::hard_pan)) return 0;
  const double per_pan = of(Effect::hard_pan), x = std::min(sinkage * per_pan, 0.95);
  return per_pan / (1 - x);
}

WheelForces ArcEffects::force(const WheelSize& loaded, const SoilLaw& nominal, const ArcPoint& at, Quadrature q,
                              double pressure_factor) const {
  constexpr double locked = 1e9;  // as in wheel_forces.cpp
  const SoilLaw soil = law(nominal, at.theta_f, at.slip, at.load);
  WheelForces out;
  ContactRange range = contact_range(soil, at.theta_f, at.slip);
  if (on(Effect::contact_angle_curvature)) {
    range.theta_m += of(Effect::contact_angle_curvature) * at.slip * std::abs(at.slip) * at.theta_f;
    range.theta_m = std::max(range.theta_m, range.theta_r);
    range.front_branch_empty = range.theta_m >= range.theta_f;
  }
  out.range = range;
  if (!(at.theta_f > 0) || range.front_branch_empty) return out;
  const ShearState e{std::clamp(at.e.t, -locked, locked), std::clamp(at.e.l, -locked, locked)};
  EffectArc arc(loaded, soil, {range.theta_f, range.theta_m, range.theta_r}, e, 0, pressure_factor);
  arc.shear_radius = shear_radius(loaded);
  if (on(Effect::hard_pan)) arc.per_pan = of(Effect::hard_pan);
  arc.plate_speed = constants_.plate_speed;
  arc.least_speed = constants_.least_speed;
  arc.forward = at.motion.forward;
  arc.rolling = at.motion.rolling;
  arc.side = at.motion.side;
  if (on(Effect::pressure_rate)) arc.rate = of(Effect::pressure_rate);
  if (on(Effect::shear_rate)) arc.zeta = of(Effect::shear_rate);
  if (on(Effect::residual_shear)) arc.residual = of(Effect::residual_shear);
  arc.per_Kw = 1 / constants_.residual_length;
  out = integrate(arc, range, std::max(q.points, kPoints));
  for (int points = 2 * std::max(q.points, kPoints); q.tolerance > 0 && points <= 96; points *= 2) {
    const WheelForces finer = integrate(arc, range, points);
    const double scale = q.tolerance * std::hypot(finer.Fx, finer.Fy, finer.Fz);
    const bool done = std::abs(finer.Fx - out.Fx) <= scale && std::abs(finer.Fy - out.Fy) <= scale &&
                      std::abs(finer.Fz - out.Fz) <= scale && std::abs(finer.My - out.My) <= scale * arc.r;
    out = finer;
    if (done) break;
  }
  return out;
}

}  // namespace grouser::bekker
