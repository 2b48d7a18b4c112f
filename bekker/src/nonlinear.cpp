#include "nonlinear.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker {

namespace {

constexpr int kFinest = static_cast<int>(kRuleSizes.size()) - 1;
constexpr int kBudget = 2000;  // rules tried in all
constexpr double kRounding = 2.3e-16;
constexpr double kMostSliding = 60;  // j/K
constexpr double kNoisy = 1e-6;      // tolerance below which rounding of j can matter
constexpr double kNothing =
    1e-32;  // of r |F|: smaller errors of the moment are not chased (shear of type B long past its peak)

PieceSums operator+(const PieceSums& a, const PieceSums& b) {
  return {a.Fx + b.Fx,
          a.Fy + b.Fy,
          a.Fz + b.Fz,
          a.Mx + b.Mx,
          a.My + b.My,
          a.Mz + b.Mz,
          a.null_sigma + b.null_sigma,
          a.null_t + b.null_t,
          a.null_l + b.null_l};
}

double force_of(const PieceSums& s) { return std::sqrt(s.Fx * s.Fx + s.Fy * s.Fy + s.Fz * s.Fz); }
double moment_of(const PieceSums& s) { return std::sqrt(s.Mx * s.Mx + s.My * s.My + s.Mz * s.Mz); }
double force_gap(const PieceSums& a, const PieceSums& b) {
  return std::abs(a.Fx - b.Fx) + std::abs(a.Fy - b.Fy) + std::abs(a.Fz - b.Fz);
}
double moment_gap(const PieceSums& a, const PieceSums& b) {
  return std::abs(a.Mx - b.Mx) + std::abs(a.My - b.My) + std::abs(a.Mz - b.Mz);
}

/// Absolute errors of a piece: wanted, and what rounding leaves at best.
struct Allowed {
  double force, moment, force_floor, moment_floor;
  bool holds(const PieceSums& a, const PieceSums& b) const {
    return force_gap(a, b) <= std::max(force, force_floor) && moment_gap(a, b) <= std::max(moment, moment_floor);
  }
};

/// What the next coefficients would add, were those of the last two rules to fall on by a power law: more than an
/// analytic piece has. Two rules can agree by chance; then these are still large.
double tail(double finer, double coarse) { return finer * (finer / std::max({coarse, finer, 1e-300})); }
bool settled(const PieceSums& finer, const PieceSums& coarse, const Allowed& allowed) {
  const double shear =
      tail(std::abs(finer.null_t) + std::abs(finer.null_l), std::abs(coarse.null_t) + std::abs(coarse.null_l));
  const double sigma = tail(std::abs(finer.null_sigma), std::abs(coarse.null_sigma));
  return sigma + shear <= std::max(allowed.force, allowed.force_floor) &&
         shear <= std::max(allowed.moment, allowed.moment_floor);
}

/// Rules of growing size, then halves, until two in a row agree and the stresses are resolved, or three agree.
class Refinement {
 public:
  Refinement(const Kernel& k, const Arc& arc) : k_(k), arc_(arc) {}
  bool ok() const { return ok_; }
  int reached() const { return reached_; }  ///< size of the last piece's rule, -1: the piece was halved

  PieceSums refine(const MappedPiece& m, int size, const PieceSums& coarse, const Allowed& allowed) {
    PieceSums last = coarse;
    bool agreed = false;
    for (int s = size + 1; s <= kFinest; ++s) {
      const PieceSums finer = integrate(m, s);
      const bool agree = allowed.holds(finer, last);
      if (agree && (agreed || settled(finer, last, allowed))) {
        reached_ = s;
        return finer;
      }
      agreed = agree;
      last = finer;
    }
    if (budget_ <= 0) {
      ok_ = false;
      reached_ = -1;
      return last;
    }
    const double half = 0.5 * m.piece.length;
    const MappedPiece near{{m.piece.start, half, m.piece.front}, m.p, 1, 0, true};
    const MappedPiece far{{m.piece.start + half, half, m.piece.front}, 1, m.q, 0, true};
    Allowed part = allowed;
    part.force *= 0.5;
    part.moment *= 0.5;
    const PieceSums a = refine(near, size, integrate(near, size), part);
    const PieceSums sum = a + refine(far, size, integrate(far, size), part);
    reached_ = -1;
    return sum;
  }

 private:
  PieceSums integrate(const MappedPiece& m, int size) {
    --budget_;
    return k_.integrate(arc_, m.piece, mapped_rule(size, m.p, m.q));
  }
  const Kernel& k_;
  const Arc& arc_;
  int budget_ = kBudget;
  int reached_ = -1;
  bool ok_ = true;
};

/// The highest Legendre coefficients, of which the rule's error is about the square, are small against the whole.
bool looks_smooth(const PieceSums& s, double force, double moment, int size) {
  const double limit = size == 0 ? 5e-3 : 2e-3;
  const double shear = std::abs(s.null_t) + std::abs(s.null_l);
  return std::abs(s.null_sigma) + shear <= limit * force && shear <= limit * moment + kNothing * force;
}

/// What rounding of j leaves of the shear where little of it is mobilised: j is the difference of the path rolled and
/// the path travelled, which near pure rolling agree to a millionth and less.
double displacement_noise(const Arc& a, double force_sum) {
  if (a.locked || force_sum == 0) return 0;  // nothing slides, or nothing touches
  const double arc = a.theta_f - a.theta_r, kappa = 1 - a.e.t, per_K = a.r * a.inv_K;
  const double jt = arc - kappa * (a.sin_f - std::sin(a.theta_r)), jl = a.e.l * arc;
  if (per_K * (std::abs(jt) + std::abs(jl)) > 1) return 0;
  return 2 * kRounding * per_K * arc * (1 + std::abs(kappa)) * (a.cohesion * arc + a.tan_phi * force_sum);
}

/// What rounding leaves of the ends of the part that a reloading wheel touches, where that part is a sliver: theta_m
/// close to theta_f, or barely pressing.
double touch_noise(const Arc& a, const Pieces& pieces, const std::array<PieceSums, kMostPieces>& part) {
  double noise = 0;
  if (!(a.zu > 0)) return noise;
  for (int i = 0; i < pieces.count; ++i) {
    const Piece& p = pieces.at[i].piece;
    noise += 1.5 * kRounding * a.theta_f / (p.length * (p.front ? 1 : a.stretch)) * force_of(part[i]);
  }
  return noise;
}

WheelWrench wrench_of(const Arc& arc, const PieceSums& s) {
  const double rb = arc.r * arc.b, rrb = rb * arc.r;
  return {rb * s.Fx, rb * s.Fy, rb * s.Fz, rrb * s.Mx, rrb * s.My, rrb * s.Mz};
}

}  // namespace

ForceResult nonlinear_forces(const Arc& arc, double tolerance, RulePlan* plan) noexcept {
  const Kernel& k = kernel();
  const Pieces pieces = pieces_of(arc, tolerance);
  if (pieces.count == 0) return {};
  if (plan && plan->pieces == pieces.count) {
    PieceSums sum{};
    for (int i = 0; i < pieces.count; ++i) {
      const MappedPiece& m = pieces.at[i];
      sum = sum + k.integrate(arc, m.piece, mapped_rule(plan->size[i], m.p, m.q));
    }
    return {wrench_of(arc, sum), ForceStatus::ok};
  }
  if (plan) plan->pieces = pieces.count;
  std::array<PieceSums, kMostPieces> part;
  PieceSums total{};
  double force_sum = 0, moment_sum = 0;
  for (int i = 0; i < pieces.count; ++i) {
    const MappedPiece& m = pieces.at[i];
    part[i] = k.integrate(arc, m.piece, mapped_rule(m.size, m.p, m.q));
    total = total + part[i];
    force_sum += force_of(part[i]);
    moment_sum += moment_of(part[i]);
  }
  // Shares of the tolerance. Sums that cancel cannot be had better than the rounding of their parts; that of j/K counts
  // until shear is complete or gone.
  const double share = tolerance / pieces.count;
  const double turns = std::abs(1 - arc.e.t) + std::abs(arc.e.l) + 1;
  const double sliding = turns * arc.r * arc.inv_K * (arc.theta_f - arc.theta_r);
  const double rounding = kRounding * (10 + std::min(sliding, kMostSliding));
  const Allowed allowed{share * force_of(total), share * moment_of(total), rounding * force_sum,
                        rounding * moment_sum + kNothing * force_sum};
  Refinement refinement(k, arc);
  const double force = force_of(total), moment = moment_of(total);
  total = {};
  for (int i = 0; i < pieces.count; ++i) {
    const MappedPiece& m = pieces.at[i];
    const bool enough = !m.verify && looks_smooth(part[i], force, moment, m.size);
    total = total + (enough ? part[i] : refinement.refine(m, m.size, part[i], allowed));
    if (plan) plan->size[i] = static_cast<signed char>(enough ? m.size : refinement.reached());
    if (plan && plan->size[i] < 0) plan->pieces = -1;  // halved: no plan
  }
  if (plan && plan->pieces < 0) plan->pieces = 0;
  ForceResult result;
  const double noise = tolerance < kNoisy ? displacement_noise(arc, force_sum) : 0;
  const bool drowned = noise > tolerance * force_of(total) || noise > tolerance * moment_of(total);
  const bool sliver = touch_noise(arc, pieces, part) > tolerance * force_of(total);
  if (!refinement.ok() || (noise > 0 && drowned) || sliver) result.status = ForceStatus::tolerance_not_met;
  result.wrench = wrench_of(arc, total);
  return result;
}

}  // namespace grouser::bekker
