#include "nonlinear.h"

#include <algorithm>
#include <cmath>

#include "pieces.h"

namespace grouser::bekker {

namespace {

constexpr int kFinest = static_cast<int>(kRuleSizes.size()) - 1;
constexpr int kBudget = 2000;  // rules tried in all
constexpr double kRounding = 2.3e-16;
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

/// Rules of growing size, then halves, until two in a row agree.
class Refinement {
 public:
  Refinement(const Kernel& k, const Arc& arc) : k_(k), arc_(arc) {}
  bool ok() const { return ok_; }
  int reached() const { return reached_; }  ///< size of the last piece's rule, -1: the piece was halved

  PieceSums refine(const MappedPiece& m, int size, const PieceSums& coarse, const Allowed& allowed) {
    PieceSums last = coarse;
    for (int s = size + 1; s <= kFinest; ++s) {
      const PieceSums finer = integrate(m, s);
      if (allowed.holds(finer, last)) {
        reached_ = s;
        return finer;
      }
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
  const double limit = size == 0 ? 1e-2 : 3e-3;
  const double shear = std::abs(s.null_t) + std::abs(s.null_l);
  return std::abs(s.null_sigma) + shear <= limit * force && shear <= limit * moment + kNothing * force;
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
  std::array<PieceSums, 24> part;
  PieceSums total{};
  double force_sum = 0, moment_sum = 0;
  for (int i = 0; i < pieces.count; ++i) {
    const MappedPiece& m = pieces.at[i];
    part[i] = k.integrate(arc, m.piece, mapped_rule(m.size, m.p, m.q));
    total = total + part[i];
    force_sum += force_of(part[i]);
    moment_sum += moment_of(part[i]);
  }
  // Shares of the tolerance. Sums that cancel cannot be had better than the rounding of their parts: that of j/K counts
  // most.
  const double share = tolerance / pieces.count;
  const double turns = std::abs(1 - arc.e.t) + std::abs(arc.e.l) + 1;
  const double rounding = kRounding * (10 + turns * arc.r * arc.inv_K * (arc.theta_f - arc.theta_r));
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
  if (!refinement.ok()) result.status = ForceStatus::tolerance_not_met;
  result.wrench = wrench_of(arc, total);
  return result;
}

}  // namespace grouser::bekker
