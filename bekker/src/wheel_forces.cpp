#include "grouser/bekker/wheel_forces.h"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>

#include "gauss_rule.h"

namespace grouser::bekker {

namespace {

constexpr double kLocked =
    1e9;  // e of a locked wheel: exp(-j/K) underflows everywhere but within 1e-8 rad of the entry
constexpr double kDirection =
    1e-4;  // floor of |v_j| in derivatives of the stress direction: its true derivative is unbounded

struct Shear {
  double f, df;  // mobilised share and its derivative by j
};

Shear shear_of(const ShearLaw& law, double j) {
  switch (law.type) {
    case ShearLaw::Type::A: {
      const double e = std::exp(-j / law.K);
      return {1 - e, e / law.K};
    }
    case ShearLaw::Type::B: {
      const double x = j / law.Kw, e = std::exp(1 - x);
      return {x * e, (1 - x) * e / law.Kw};
    }
    case ShearLaw::Type::C: {
      constexpr double inv_e = 0.36787944117144233;
      const double x = j / law.Kw, e = std::exp(-x), a = 1 / (law.Kr * (1 - inv_e)) - 1, p = a * e / inv_e;
      return {law.Kr * (1 + p) * (1 - e), law.Kr * ((1 + p) * e - p * (1 - e)) / law.Kw};
    }
  }
  return {0, 0};
}

/// Everything that is the same for all points of one arc.
struct Arc {
  const WheelSize& wheel;
  const SoilLaw& soil;
  ContactRange range;
  ShearState e;
  double factor, sin_f, cos_f, stretch;
  Arc(const WheelSize& w, const SoilLaw& s, const ContactRange& r, ShearState es, double f)
      : wheel(w),
        soil(s),
        range(r),
        e(es),
        factor(f),
        sin_f(std::sin(r.theta_f)),
        cos_f(std::cos(r.theta_f)),
        stretch(r.theta_m > r.theta_r ? (r.theta_f - r.theta_m) / (r.theta_m - r.theta_r) : 0) {}

  struct Point {
    double s, c, sigma, tau_max, f, df, ct, cl, norm, jt, jl, j, dj;  // dj = r (sin theta_f - sin theta)
  };
  Point at(double theta) const {
    Point p;
    p.s = std::sin(theta);
    p.c = std::cos(theta);
    const double cos_e = theta >= range.theta_m ? p.c : std::cos(range.theta_f - (theta - range.theta_r) * stretch);
    const double z = wheel.radius * (cos_e - cos_f);
    p.sigma = z > 0 ? factor * soil.modulus * std::pow(z, soil.n) : 0;
    p.tau_max = p.sigma > 0 ? soil.shear.cohesion + p.sigma * soil.tan_phi : 0;
    p.dj = wheel.radius * (sin_f - p.s);
    const double arc = wheel.radius * (range.theta_f - theta);
    p.jt = arc - (1 - e.t) * p.dj;
    p.jl = e.l * arc;
    p.j = std::sqrt(p.jt * p.jt + p.jl * p.jl);
    const Shear m = shear_of(soil.shear, p.j);
    p.f = m.f;
    p.df = m.df;
    const double vt = 1 - (1 - e.t) * p.c;
    p.norm = std::sqrt(vt * vt + e.l * e.l);
    p.ct = p.norm > 0 ? vt / p.norm : 0;
    p.cl = p.norm > 0 ? e.l / p.norm : 0;
    return p;
  }
};

void add_piece(const Arc& arc, double lo, double hi, const GaussRule& rule, WheelForces& out) {
  const double length = hi - lo;
  const bool entry = hi >= arc.range.theta_f, exit = lo <= arc.range.theta_r;
  for (int i = 0; i < rule.n; ++i) {
    const double x = rule.x[i];
    double theta, w;
    if (entry) {
      theta = hi - length * x * x;
      w = rule.w[i] * length * 2 * x;
    } else if (exit) {
      theta = lo + length * x * x;
      w = rule.w[i] * length * 2 * x;
    } else {
      theta = lo + length * x;
      w = rule.w[i] * length;
    }
    const Arc::Point p = arc.at(theta);
    const double tau = p.tau_max * p.f;
    const double st = w * tau * p.ct, sl = w * tau * p.cl;
    out.pressure_x -= w * p.sigma * p.s;
    out.pressure_z += w * p.sigma * p.c;
    out.capacity += w * p.tau_max;
    out.Fx += st * p.c;
    out.Fz += st * p.s;
    out.Fy -= sl;
    out.Mx -= sl * p.c;
    out.My -= st;
    out.Mz -= sl * p.s;
    // tau_t = tau_max f(j) ct: j and the direction depend on e.
    const double slope = p.j > 0 ? p.tau_max * p.df / p.j : 0;
    const double turn = tau / std::max(p.norm, kDirection);
    const double jt_t = slope * p.jt * p.dj, jl_l = slope * p.jl * arc.wheel.radius * (arc.range.theta_f - theta);
    const auto add = [&](std::array<double, 6>& d, double t, double l) {
      d[0] += w * t * p.c;
      d[1] -= w * l;
      d[2] += w * t * p.s;
      d[3] -= w * l * p.c;
      d[4] -= w * t;
      d[5] -= w * l * p.s;
    };
    add(out.d_t, jt_t * p.ct + turn * p.c * p.cl * p.cl, jt_t * p.cl - turn * p.c * p.ct * p.cl);
    // At j_l = 0 the derivative of |j| by e.l vanishes and the direction alone turns.
    add(out.d_l, jl_l * p.ct - turn * p.ct * p.cl, jl_l * p.cl + turn * p.ct * p.ct);
  }
  out.evaluations += rule.n;
}

/// Under braking v_jt vanishes at cos theta = 1/kappa; j_t, positive just behind the entry, vanishes further down.
int sign_changes(const Arc& arc, std::array<double, 2>& at) {
  if (!(arc.e.t < 0)) return 0;
  const double kappa = 1 - arc.e.t, lo = arc.range.theta_r, hi = arc.range.theta_f;
  if (!(kappa * arc.cos_f < 1)) return 0;
  const double t0 = std::acos(1 / kappa);
  if (!(t0 > lo && t0 < hi)) return 0;
  int n = 0;
  at[n++] = t0;
  const auto j = [&](double t) { return (hi - t) - kappa * (arc.sin_f - std::sin(t)); };
  if (j(lo) < 0) {
    // j is near a parabola about t0, so the root lies about as far below t0 as the entry above: Newton, kept in its bracket.
    double a = lo, b = t0, t = std::clamp(t0 - (hi - t0), lo, t0);
    for (int i = 0; i < 40; ++i) {
      const double f = j(t);
      (f < 0 ? a : b) = t;
      const double slope = -1 + kappa * std::cos(t);
      double next = slope > 0 ? t - f / slope : 0.5 * (a + b);
      if (!(next > a && next < b)) next = 0.5 * (a + b);
      const bool done = std::abs(next - t) < 1e-10;
      t = next;
      if (done) break;
    }
    at[n++] = t;
  }
  return n;
}

WheelForces integrate(const Arc& arc, int points) {
  WheelForces out;
  out.range = arc.range;
  std::array<double, 5> cuts{arc.range.theta_r, arc.range.theta_m, arc.range.theta_f, 0, 0};
  std::array<double, 2> extra{};
  const int more = sign_changes(arc, extra);
  for (int i = 0; i < more; ++i) cuts[3 + i] = extra[i];
  std::sort(cuts.begin(), cuts.begin() + 3 + more);
  const GaussRule& rule = gauss_rule(points);
  for (int i = 0; i < 2 + more; ++i)
    if (cuts[i + 1] > cuts[i]) add_piece(arc, cuts[i], cuts[i + 1], rule, out);
  const double rb = arc.wheel.radius * arc.wheel.width, r = arc.wheel.radius;
  out.pressure_x *= rb;
  out.pressure_z *= rb;
  out.capacity *= rb;
  out.Fx = out.Fx * rb + out.pressure_x;
  out.Fz = out.Fz * rb + out.pressure_z;
  out.Fy *= rb;
  out.Mx *= rb * r;
  out.My *= rb * r;
  out.Mz *= rb * r;
  for (int i = 0; i < 6; ++i) {
    const double scale = i < 3 ? rb : rb * r;
    out.d_t[i] *= scale;
    out.d_l[i] *= scale;
  }
  return out;
}

}  // namespace

SoilLaw SoilLaw::of(const BekkerSoil& soil, double wheel_width, ThetaMLaw law) {
  return {soil.pressure.modulus(wheel_width),  soil.pressure.n, soil.shear,
          std::tan(soil.shear.friction_angle), soil.angles,     law};
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

double mobilised(const ShearLaw& law, double j) { return shear_of(law, j).f; }

ContactRange contact_range(const SoilLaw& soil, double theta_f, double slip) {
  ContactRange c;
  c.theta_f = theta_f;
  const double s = std::abs(slip);
  if (soil.theta_m_law == ThetaMLaw::wong_braking && slip < 0) {
    const double x = std::tan(pi / 4 - soil.shear.friction_angle / 2);
    c.theta_m = std::acos((1 + slip) / std::sqrt(1 + x * x)) + std::atan2(-x, 1.0);
  } else {
    c.theta_m = (soil.angles.a0 + soil.angles.a1 * s) * theta_f;
  }
  c.theta_r = -(soil.angles.b0 + soil.angles.b1 * s) * theta_f;
  c.front_branch_empty = c.theta_m >= theta_f;
  return c;
}

Stress stress_at(const WheelSize& wheel, const SoilLaw& soil, const ContactRange& range, ShearState e, double theta) {
  if (theta < range.theta_r || theta > range.theta_f || range.front_branch_empty) return {};
  const Arc::Point p = Arc(wheel, soil, range, e, 1).at(theta);
  return {p.sigma, p.tau_max * p.f * p.ct, p.tau_max * p.f * p.cl, p.j};
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
  const Arc arc(wheel, soil, range, e, pressure_factor);
  out = integrate(arc, q.points);
  if (q.tolerance > 0) {
    int evaluations = out.evaluations;
    for (int points = 2 * q.points; points <= 96; points *= 2) {
      const WheelForces finer = integrate(arc, points);
      evaluations += finer.evaluations;
      const double scale = q.tolerance * std::hypot(finer.Fx, finer.Fy, finer.Fz);
      const bool done = std::abs(finer.Fx - out.Fx) <= scale && std::abs(finer.Fy - out.Fy) <= scale &&
                        std::abs(finer.Fz - out.Fz) <= scale && std::abs(finer.My - out.My) <= scale * wheel.radius;
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

std::string_view name_of(Equilibrium::Status status) {
  switch (status) {
    case Equilibrium::Status::ok:
      return "ok";
    case Equilibrium::Status::bad_argument:
      return "load and sizes must be positive and finite";
    case Equilibrium::Status::too_soft:
      return "the soil does not carry the load with the wheel sunk to its hub";
    case Equilibrium::Status::no_pressure:
      return "theta_m >= theta_f: the pressure law carries nothing";
  }
  return "";
}

Equilibrium steady_equilibrium(const WheelSize& wheel, const SoilLaw& soil, double load, ShearState e, Quadrature q) {
  Equilibrium result;
  if (!(load > 0) || !std::isfinite(load) || !(wheel.radius > 0) || !(wheel.width > 0)) {
    result.status = Equilibrium::Status::bad_argument;
    return result;
  }
  const auto f = [&](double theta_f) { return steady_forces(wheel, soil, theta_f, e, q).Fz - load; };
  double hi = 0.05, lo = 0, fl = -load, fh = f(hi);
  while (fh < 0 && hi < pi / 2) {
    lo = hi;
    fl = fh;
    hi = std::min(1.6 * hi, pi / 2);
    fh = f(hi);
  }
  result.theta_f = hi;
  if (fh < 0) {
    result.forces = steady_forces(wheel, soil, hi, e, q);
    result.status =
        result.forces.range.front_branch_empty ? Equilibrium::Status::no_pressure : Equilibrium::Status::too_soft;
  } else {
    std::uintmax_t iterations = 60;
    const auto close = [](double a, double b) { return std::abs(b - a) <= 1e-13 * std::max(std::abs(a), std::abs(b)); };
    const auto bracket = boost::math::tools::toms748_solve(f, lo, hi, fl, fh, close, iterations);
    result.theta_f = 0.5 * (bracket.first + bracket.second);
    result.forces = steady_forces(wheel, soil, result.theta_f, e, q);
  }
  const double half = std::sin(0.5 * result.theta_f);
  result.sinkage = 2 * wheel.radius * half * half;
  return result;
}

}  // namespace grouser::bekker
