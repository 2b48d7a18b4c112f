#pragma once
// The steady wheel with named effects, written once for plain numbers and for numbers that carry derivatives.
#include <array>
#include <cmath>
#include <cstdint>

#include "grouser/bekker/effects.h"
#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// What one run sets beside load and slip.
struct EffectCondition {
  double rim_speed = 0.1;  ///< |r w| [m/s] with the outer radius; 0 for a locked wheel
  int pass = 1;
  double order = 0;  ///< 0..1, place of the run in the series
};

/// Wheel and constants of a series of runs. Smooth wheel, type A, slip angle 0, virgin soil.
struct EffectWheel {
  double radius = 0, width = 0, reference_width = 0;  ///< r, b_wheel, b of sigma = k (z/b)^n [m]
  EffectConstants constants;
};

/// Everything a run's forces depend on. S: double, or a number with derivatives.
template <class S>
struct WheelState {
  S k, n, c, phi, K, a0, a1;  ///< [Pa], [-], [Pa], [rad], [m], [-], [-]
  S slip, load;               ///< s = (r w - v)/max(|r w|, |v|) in [-1, 1); [N]
  std::array<S, effect_count> effect;
  std::uint32_t active = 0;  ///< bit of each effect that is looked at; the others cost nothing and leave no trace

  bool on(Effect e) const { return active >> static_cast<unsigned>(e) & 1U; }
  const S& of(Effect e) const { return effect[static_cast<std::size_t>(e)]; }
};

template <class S>
struct WheelAnswer {
  S drawbar, torque, sinkage, Fz;  ///< [N], [N m], [m], [N]
};

/// Plain part of a number; specialise it for a type that carries derivatives.
template <class S>
struct PlainPart {
  static double of(const S& x) { return x; }
};

namespace effect_detail {

constexpr int kPoints = 10;
struct Rule {
  std::array<double, kPoints> x, w;    ///< Gauss-Legendre on 0..1
  std::array<double, kPoints> x2, w2;  ///< the same in the root of the distance: x^2, 2 x w
};
const Rule& rule();

/// Ends of a piece: distances from the entry [rad] are offset + share of what is named.
enum class Anchor : std::uint8_t { entry, theta_m, exit, turn, mirrored_turn };
struct End {
  Anchor anchor;
  double behind;  ///< [rad] behind the anchor (towards the exit)
};
struct Piece {
  End from, to;  ///< from is nearer to the entry
  bool rear, root_from, root_to;
  double direction;  ///< of the sliding velocity
};
struct Layout {
  std::array<Piece, 16> piece;
  int count = 0;
};

/// Pieces on which the stresses are smooth.
struct Shape {
  double theta_f, theta_m, theta_r, shear_radius, kappa_r, K;  ///< kappa_r = v/w [m]; infinity: locked
};
Layout layout_of(const Shape& s) noexcept;

}  // namespace effect_detail

/// Force of the soil on the wheel at entry angle theta_f > 0 and the sinkage that goes with it:
///   Fx = b int (R tau cos theta - r sigma sin theta), Fz = b int (r sigma cos theta + R tau sin theta), T = b int R^2 tau
/// with R = r but for lugs; each effect as in `Effect`. `drawbar` and `sinkage` include the added forces and digging; Fz is that
/// of the arc. Gauss-Legendre with 10 points on each smooth piece: entry, theta_m, exit, where sliding or its path turns round, and
/// the layers in which the shear builds up; error below 1e-6 of the force (measured in tests/diagnosis).
/// Without active effects this is the law of `bekker::solve`. False: theta_m >= theta_f, or a hard pan that is reached.
/// Cost: 30 to 80 points; about 2 us with doubles.
template <class S>
bool effect_forces(const EffectWheel& w, const EffectCondition& run, const WheelState<S>& q, const S& theta_f,
                   WheelAnswer<S>& out) {
  using std::abs, std::acos, std::cos, std::exp, std::log, std::pow, std::sin, std::sqrt, std::tan;
  using namespace effect_detail;
  const auto plain = [](const S& x) { return PlainPart<S>::of(x); };
  const EffectConstants& k0 = w.constants;
  const double s = plain(q.slip);
  const bool locked = s <= -1, later = run.pass >= 2;
  const S size = s < 0 ? S(-q.slip) : q.slip;

  S r = S(w.radius), k = q.k, n = q.n, K = q.K, tan_tau = tan(q.phi);
  if (q.on(Effect::flexible_wheel)) r *= 1.0 + q.of(Effect::flexible_wheel) * q.load / k0.load;
  if (q.on(Effect::slip_sinkage_exponent)) n += q.of(Effect::slip_sinkage_exponent) * size;
  if (q.on(Effect::repetitive_loading) && later) k *= 1.0 + q.of(Effect::repetitive_loading);
  if (q.on(Effect::preparation_drift)) k *= 1.0 + q.of(Effect::preparation_drift) * run.order;
  if (q.on(Effect::plate_size)) k *= exp(-q.of(Effect::plate_size) * log(w.radius * sin(theta_f) / k0.plate_length));
  if (q.on(Effect::shear_modulus_load)) K *= exp(q.of(Effect::shear_modulus_load) * log(q.load / k0.load));
  if (q.on(Effect::pass_strength) && later) tan_tau *= 1.0 + q.of(Effect::pass_strength);
  const S tan_soil = tan_tau;
  if (q.on(Effect::interface_friction)) tan_tau *= q.of(Effect::interface_friction);
  S R = r;
  if (q.on(Effect::lugs)) R += k0.lug_share * q.of(Effect::lugs);

  S share = q.a0 + q.a1 * size;
  if (q.on(Effect::contact_angle_curvature)) share += q.of(Effect::contact_angle_curvature) * q.slip * size;
  const S theta_m = share * theta_f;
  S theta_r = S(0.0);
  if (q.on(Effect::exit_angle)) theta_r = -q.of(Effect::exit_angle) * theta_f;
  if (!(plain(theta_m) < plain(theta_f)) || !(plain(theta_m) > plain(theta_r)) || !(plain(k) > 0) || !(plain(K) > 0) ||
      !(plain(r) > 0))
    return false;
  const S stretch = (theta_f - theta_m) / (theta_m - theta_r);

  // v/w as it was travelled: slip is stated by the wheel's own radius, whatever shears.
  const S kappa_r = locked ? S(INFINITY) : (s < 0 ? S(w.radius / (1.0 + q.slip)) : S(w.radius * (1.0 - q.slip)));
  const Layout layout = layout_of(
      {plain(theta_f), plain(theta_m), plain(theta_r), plain(R), locked ? INFINITY : plain(kappa_r), plain(K)});
  S turn = S(0.0);
  if (!locked && plain(kappa_r) > plain(R)) turn = acos(R / kappa_r);

  S inv_z = S(1.0) / w.reference_width;
  if (q.on(Effect::slip_sinkage_factor))
    inv_z *= exp(-q.of(Effect::slip_sinkage_factor) * log((1.0 + size) / (1.0 - 0.5 * size)));
  const S log_k = log(k) + n * log(inv_z), inv_K = 1.0 / K, zero = S(0.0);
  const double omega = run.rim_speed / w.radius;
  const S speed = locked ? S(run.rim_speed) : S(omega * kappa_r);  // of travel

  const Rule& g = rule();
  S Fx = zero, Fz = zero, M = zero;
  const auto place = [&](const End& e) -> S {  // distance behind the entry
    switch (e.anchor) {
      case Anchor::entry:
        return S(e.behind);
      case Anchor::theta_m:
        return theta_f - theta_m + e.behind;
      case Anchor::exit:
        return theta_f - theta_r + e.behind;
      case Anchor::turn:
        return theta_f - turn + e.behind;
      case Anchor::mirrored_turn:
        return theta_f + turn + e.behind;
    }
    return zero;
  };
  for (int p = 0; p < layout.count; ++p) {
    const Piece& piece = layout.piece[static_cast<std::size_t>(p)];
    const S from = place(piece.from), to = place(piece.to), length = to - from;
    for (std::size_t i = 0; i < kPoints; ++i) {
      S u;
      double weight;
      if (piece.root_to) {
        u = to - g.x2[i] * length;
        weight = g.w2[i];
      } else {
        u = from + (piece.root_from ? g.x2[i] : g.x[i]) * length;
        weight = piece.root_from ? g.w2[i] : g.w[i];
      }
      const S theta = theta_f - u, sin_t = sin(theta), cos_t = cos(theta);
      const S half_u = 0.5 * u, lift = 2.0 * sin(half_u) * cos(theta_f - half_u);  // sin theta_f - sin theta
      S z;
      if (piece.rear) {
        const S half_e = 0.5 * stretch * (theta - theta_r);
        z = 2.0 * r * sin(half_e) * sin(theta_f - half_e);
      } else {
        z = 2.0 * r * sin(half_u) * sin(theta_f - half_u);
      }
      S log_sigma = log_k + n * log(z);
      if (q.on(Effect::pressure_rate)) {
        const S v_n = speed * sin_t;
        const S used = plain(v_n) > k0.least_speed ? v_n : S(k0.least_speed);
        log_sigma += q.of(Effect::pressure_rate) * log(used / k0.plate_speed);
      }
      S sigma = exp(log_sigma);
      if (q.on(Effect::hard_pan)) {
        const S left = 1.0 - z * q.of(Effect::hard_pan);
        if (!(plain(left) > 0)) return false;
        sigma /= left;
      }
      S tau = q.c + tan_tau * sigma;
      if (locked) {
        tau = -tau;
      } else {
        const S j = R * u - kappa_r * lift;
        const S path = plain(j) < 0 ? S(-j) : j;
        tau *= piece.direction * (1.0 - exp(-path * inv_K));
        if (q.on(Effect::residual_shear)) tau *= 1.0 + q.of(Effect::residual_shear) * exp(-path / k0.residual_length);
        if (q.on(Effect::shear_rate)) {
          const S v_j = piece.direction * omega * (R - kappa_r * cos_t);
          const S used = plain(v_j) > k0.least_speed ? v_j : S(k0.least_speed);
          tau *= 1.0 + q.of(Effect::shear_rate) * log(used / k0.plate_speed);
        }
      }
      const S wl = weight * length, a = wl * R * tau, p_r = wl * r * sigma;
      Fx += a * cos_t - p_r * sin_t;
      Fz += p_r * cos_t + a * sin_t;
      M += a;
    }
  }
  out.drawbar = w.width * Fx;
  out.Fz = w.width * Fz;
  out.torque = w.width * R * M;
  const S half_f = sin(0.5 * theta_f), z0 = 2.0 * r * half_f * half_f;
  out.sinkage = z0;
  if (q.on(Effect::bulldozing)) {
    const S root = tan(0.25 * 3.14159265358979323846 + 0.5 * q.phi);  // sqrt Kp
    out.drawbar -= q.of(Effect::bulldozing) * w.width *
                   (0.5 * k0.density * k0.gravity * z0 * z0 * root * root + 2.0 * q.c * z0 * root);
  }
  if (q.on(Effect::side_wall)) {
    const S area = r * r * (theta_f - sin(theta_f) * cos(theta_f));
    out.drawbar -=
        q.of(Effect::side_wall) * area * (q.c + (1.0 - sin(q.phi)) * (k0.density * k0.gravity) * z0 * tan_soil);
  }
  if (q.on(Effect::slip_digging) && s > 0)
    out.sinkage += q.of(Effect::slip_digging) * (s < 0.95 ? S(q.slip / (1.0 - q.slip)) : S(19.0));
  return true;
}

/// Entry angle at which Fz = load, to 1e-9 of it. `guess` [rad] near it, or 0. ok, bad_argument (a value outside its range),
/// no_pressure (theta_m >= theta_f) or too_soft (not reached at theta_f = pi/2 or below a hard pan).
ForceStatus effect_equilibrium(const EffectWheel& w, const EffectCondition& run, const WheelState<double>& q,
                               double guess, double& theta_f, WheelAnswer<double>& answer) noexcept;

}  // namespace grouser::bekker
