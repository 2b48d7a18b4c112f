#include <algorithm>
#include <cmath>

#include "closed_form.h"
#include "load_root.h"
#include "nonlinear.h"

namespace grouser::bekker {

namespace {

constexpr double kHub = pi / 2;
constexpr double kPlanReach = 0.05;  // of theta_f
constexpr double kSmooth = 1e-11;
constexpr double kSteep = 1.1;  // [rad] beyond it the pressure itself may lift less with depth
constexpr double kShearShare =
    0.25;  // of the pressure's lift: below it Fz rises all the way to the root (tested on random rows)

/// Wheel forces of a load case over theta_f by one method. Keeps those of the last angle.
struct Evaluator {
  const LoadCase& c;
  Method method;
  double tolerance, tan_beta;
  ShearState e;
  ArcAngles angles;
  WheelWrench wrench;
  double pressure_z = 0;  ///< closed forms only
  ForceStatus status = ForceStatus::ok;
  RulePlan plan;          ///< nonlinear only: kept while theta_f moves little, so that Fz is smooth
  double plan_theta = 0;  ///< where it was made
  bool rough = false;     ///< no plan was possible: a tolerance so small that its steps do not matter stands in for it

  Evaluator(const LoadCase& l, Method m, double tol)
      : c(l), method(m), tolerance(tol), tan_beta(std::tan(l.slip_angle)) {
    const double kappa = l.slip > -1 ? kappa_of_slip(l.slip) : 1;
    e = {1 - kappa, kappa * tan_beta};
  }

  ArcAngles angles_at(double theta_f) const {
    const ContactRange range = contact_range(c.soil, theta_f, c.slip);
    return {theta_f, range.theta_m, range.theta_r};
  }
  double operator()(double theta_f) {
    angles = angles_at(theta_f);
    if (!(theta_f > 0) || angles.theta_m >= theta_f) {
      wrench = {};
      return 0;
    }
    Arc arc(c.wheel, c.soil, angles, e, c.unloading_sinkage);
    arc.locked = c.slip <= -1;
    arc.tan_beta = tan_beta;
    if (method == Method::nonlinear) {
      if (std::abs(theta_f - plan_theta) > kPlanReach * plan_theta) plan.pieces = 0;
      const bool follows = plan.pieces > 0;
      const ForceResult r = nonlinear_forces(arc, rough ? std::min(tolerance, kSmooth) : tolerance, &plan);
      if (!follows) plan_theta = theta_f;
      rough = plan.pieces == 0;
      wrench = r.wrench;
      status = r.status;
    } else {
      wrench = closed_form(arc, method, pressure_z);
    }
    return wrench.Fz / c.load;
  }
};

ForceStatus status_of(const LoadCase& c) {
  if (!(c.load > 0) || !std::isfinite(c.load)) return ForceStatus::bad_argument;
  ForceCase f{c.wheel, c.soil, {kHub, 0, 0}, c.slip, c.slip_angle, c.unloading_sinkage};
  if (!(std::abs(c.slip) <= 1)) return ForceStatus::bad_argument;
  const ContactRange range = contact_range(c.soil, kHub, c.slip);
  f.arc = {kHub, range.theta_m, range.theta_r};
  return status_of(f);
}

/// Where the root is expected, from the pressure alone: a parabola over the arc makes Fz ~ theta_f^(2 n + 1) on
/// virgin soil, a shallow dent in a bed of springs on a reloading wheel.
RootRange expected(const LoadCase& c, const ArcAngles& unit) {
  const double r = c.wheel.outer_radius(), b = c.wheel.width, n = c.soil.n;
  const double am = unit.theta_m, length = 1 - unit.theta_r;  // per theta_f
  const double depth = 0.5 * r * (1 - am * am);               // z at theta_m per theta_f^2
  const double middle = (3 + am) / (4 * (1 + am));            // z at theta_fm over z at theta_m
  const double scale = r * b * length / 6 * (1 + 4 * std::exp(n * std::log(middle))) * c.soil.modulus;
  RootRange s;
  s.hi = kHub;
  s.exponent = 2 * n + 1;
  s.guess = std::exp((std::log(c.load / scale) - n * std::log(depth)) / s.exponent);
  const double zu = c.unloading_sinkage, slope = c.soil.ko + c.soil.Au * zu;
  if (zu > 0 && depth * s.guess * s.guess < zu) {
    const double touch = std::max(zu - c.soil.modulus * std::pow(zu, n) / slope, 0.0);
    const double dent = std::cbrt(std::pow(c.load / (b * slope * 4 / 3 * std::sqrt(2 * r)), 2));
    const double z = touch + std::min(dent, zu - touch);
    s.lo = std::sqrt(touch / depth) * (1 - 0.1 * touch / r);
    s.guess = std::sqrt(z / depth);
    s.exponent = std::max(3 * z / (z - touch + 1e-300), s.exponent);
  }
  s.guess = std::min(s.guess, kHub);
  return s;
}

/// Under driving with type A, pressure, mobilisation, its direction and sin theta all grow with theta_f.
bool grows_with_depth(const SoilLaw& soil, double slip, const LoadRoot& root) {
  return root.end != RootEnd::not_reached && root.theta <= kSteep && slip >= 0 && soil.shear.type == ShearLaw::Type::A;
}

/// Whether Fz rises with theta_f up to the root, so that there is no smaller one: it grows with depth, or the shear
/// is too small to undo the pressure: what acts at the root (type A), what could act at any smaller angle (types B
/// and C, which pass a peak).
bool surely_rising(const LoadCase& c, const Evaluator& at, const LoadRoot& root) {
  if (grows_with_depth(c.soil, c.slip, root)) return true;
  if (root.end == RootEnd::not_reached || root.theta > kSteep) return false;
  double shear = std::abs(at.wrench.Fz - at.pressure_z);
  if (c.soil.shear.type != ShearLaw::Type::A)
    shear = std::max(shear,
                     c.soil.tan_phi * std::tan(0.7 * root.theta) * at.pressure_z +
                         c.soil.shear.cohesion * c.wheel.width * c.wheel.outer_radius() * (1 - std::cos(root.theta)));
  return root.exponent > 0.5 && shear < kShearShare * at.pressure_z;
}

Solution answer(const LoadCase& c, const Evaluator& at, const LoadRoot& root) {
  Solution s;
  s.status = root.end == RootEnd::not_reached ? ForceStatus::too_soft : at.status;
  s.arc = at.angles_at(root.theta);
  s.slip = c.slip;
  const double half = std::sin(0.5 * root.theta);
  s.sinkage = 2 * c.wheel.outer_radius() * half * half;
  s.unloading_sinkage = std::max(c.unloading_sinkage, s.sinkage);
  s.wrench = at.wrench;
  return s;
}

}  // namespace

std::string_view name_of(ForceStatus status) {
  switch (status) {
    case ForceStatus::ok:
      return "ok";
    case ForceStatus::bad_argument:
      return "bad_argument";
    case ForceStatus::tolerance_not_met:
      return "tolerance_not_met";
    case ForceStatus::no_pressure:
      return "no_pressure";
    case ForceStatus::too_soft:
      return "too_soft";
    case ForceStatus::torque_not_reached:
      return "torque_not_reached";
  }
  return "";
}

Solution solve(const LoadCase& c, Method method, double tolerance) noexcept {
  Solution bad;
  bad.slip = c.slip;
  bad.status = status_of(c);
  if (bad.status == ForceStatus::ok && !(tolerance >= 1e-13 && tolerance <= 1e-2))
    bad.status = ForceStatus::bad_argument;
  if (bad.status != ForceStatus::ok) return bad;

  // Closed form first: its root, and whether it is the smallest.
  const bool fixed_m = c.soil.theta_m_law == ThetaMLaw::wong_braking && c.slip < 0;
  Evaluator closed(c, method == Method::nonlinear ? Method::quadratic : method, tolerance);
  RootRange range;
  bool rising = false;
  LoadRoot root;
  if (fixed_m) {
    range.lo = closed.angles_at(kHub).theta_m;
    range.hi = kHub;
    range.guess = 1.05 * range.lo;
    range.exponent = 2 * c.soil.n + 1;
  } else {
    const ArcAngles unit = closed.angles_at(1);
    range = expected(c, unit);
    if (method == Method::nonlinear) range.tolerance = 1e-3;
    root = load_root(closed, range);
    rising = surely_rising(c, closed, root);
    range.guess = root.theta;
    range.exponent = root.exponent;
    range.tolerance = RootRange{}.tolerance;
  }
  if (method != Method::nonlinear) {
    if (!rising) root = first_load_root(closed, range.lo, kHub, range.guess, range.exponent, range.tolerance);
    return answer(c, closed, root);
  }
  Evaluator exact(c, method, tolerance);
  if (!rising) {
    root = first_load_root(exact, range.lo, kHub, range.guess, range.exponent, range.tolerance);
  } else {
    root = load_root(exact, range);
  }
  return answer(c, exact, root);
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
  Equilibrium out;
  const double slip = slip_of(e);
  const ForceStatus status = status_of(LoadCase{wheel, soil, load, std::clamp(slip, -1.0, 1.0), 0, 0});
  if (status != ForceStatus::ok) {
    out.status =
        status == ForceStatus::no_pressure ? Equilibrium::Status::no_pressure : Equilibrium::Status::bad_argument;
    return out;
  }
  const auto ratio = [&](double theta_f) {
    out.forces = steady_forces(wheel, soil, theta_f, e, q);
    return out.forces.Fz / load;
  };
  const ContactRange unit = contact_range(soil, 1, slip);
  const RootRange range = expected({wheel, soil, load, slip, 0, 0}, {1, unit.theta_m, unit.theta_r});
  LoadRoot root = load_root(ratio, range);
  if (!grows_with_depth(soil, slip, root))
    root = first_load_root(ratio, 0, kHub, root.theta, range.exponent, range.tolerance);
  if (root.end == RootEnd::not_reached) out.status = Equilibrium::Status::too_soft;
  out.theta_f = root.theta;
  const double half = std::sin(0.5 * root.theta);
  out.sinkage = 2 * wheel.outer_radius() * half * half;
  return out;
}

}  // namespace grouser::bekker
