#include <algorithm>
#include <array>

#include "arc.h"
#include "kernel.h"
#include "nonlinear.h"

namespace grouser::bekker {

namespace {

constexpr double kRowTolerance = 1e-6;  // what the rules of rows.h are made for
constexpr int kKinds = 6;               // shear type and lateral model
constexpr int kOpen = 40;               // groups that can be filled at a time

/// Eight rows at most that take the same rules. Groups that are not full run with copies of their first row: what is
/// computed for a row depends on that row alone.
struct Group {
  Rows rows;
  std::array<std::size_t, Rows::kSize> at;
  int count = 0;

  void add(std::size_t row) { at[count++] = row; }
  bool full() const { return count == Rows::kSize; }
  void pad() {
    for (int i = count; i < Rows::kSize; ++i) rows.copy(i, rows, 0);
  }
};

/// Sorts rows into groups by shear law and rules and integrates each group when it is full.
class Batch {
 public:
  Batch(std::span<const ForceCase> cases, double tolerance, std::span<ForceResult> results)
      : cases_(cases), tolerance_(tolerance), results_(results) {
    open_.fill(-1);
  }
  void run() {
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      const ForceCase& c = cases_[i];
      const ForceStatus status = status_of(c);
      if (status != ForceStatus::ok) {
        results_[i] = {{}, status};
      } else if (!Rows::takes(c)) {
        alone(i);
      } else {
        const int kind = 2 * static_cast<int>(c.soil.shear.type) + static_cast<int>(c.soil.lateral);
        Group& g = arriving_[kind];
        g.rows.set(g.count, c);
        g.add(i);
        if (g.full()) sort(kind);
      }
    }
    for (int kind = 0; kind < kKinds; ++kind) sort(kind);
    for (int i = 0; i < kOpen; ++i) integrate(i);
  }

 private:
  static constexpr int kKeys = kKinds * kRowClasses * kRowClasses;
  static ShearLaw::Type type_of(int kind) { return static_cast<ShearLaw::Type>(kind / 2); }
  static bool anisotropic(int kind) { return kind % 2 == 1; }

  void alone(std::size_t i) { results_[i] = nonlinear_forces(Arc(cases_[i]), tolerance_); }

  void sort(int kind) {
    Group& g = arriving_[kind];
    if (g.count == 0) return;
    g.pad();
    RowPlan plan;
    kernel_.plan_rows(g.rows, type_of(kind), anisotropic(kind), plan);
    for (int i = 0; i < g.count; ++i) {
      if (plan.front[i] < 0) {
        alone(g.at[i]);
        continue;
      }
      const int k = group_of((kind * kRowClasses + plan.front[i]) * kRowClasses + plan.rear[i]);
      Group& to = groups_[k];
      to.rows.copy(to.count, g.rows, i);
      to.add(g.at[i]);
      if (to.full()) integrate(k);
    }
    g.count = 0;
  }

  /// The open group of a key; where all are taken the next in turn makes room.
  int group_of(int key) {
    if (open_[key] >= 0) return open_[key];
    const int k = next_;
    next_ = (next_ + 1) % kOpen;
    integrate(k);
    if (key_[k] >= 0) open_[key_[k]] = -1;
    key_[k] = key;
    open_[key] = static_cast<signed char>(k);
    return k;
  }

  void integrate(int k) {
    Group& g = groups_[k];
    if (g.count == 0) return;
    g.pad();
    const int key = key_[k], kind = key / (kRowClasses * kRowClasses);
    RowSums sums;
    kernel_.integrate_rows(g.rows, type_of(kind), anisotropic(kind), row_rule(key / kRowClasses % kRowClasses),
                           row_rule(key % kRowClasses), sums);
    for (int i = 0; i < g.count; ++i) {
      const auto& w = sums.wrench;
      if (sums.smooth[i]) {
        results_[g.at[i]] = {{w[0][i], w[1][i], w[2][i], w[3][i], w[4][i], w[5][i]}, ForceStatus::ok};
      } else {
        alone(g.at[i]);
      }
    }
    g.count = 0;
  }

  std::span<const ForceCase> cases_;
  double tolerance_;
  std::span<ForceResult> results_;
  const Kernel& kernel_ = kernel();
  std::array<Group, kKinds> arriving_;
  std::array<Group, kOpen> groups_;
  std::array<int, kOpen> key_ = [] {
    std::array<int, kOpen> none;
    none.fill(-1);
    return none;
  }();
  std::array<signed char, kKeys> open_;  ///< group of each key, -1: none
  int next_ = 0;
};

}  // namespace

void forces(std::span<const ForceCase> cases, Method method, double tolerance,
            std::span<ForceResult> results) noexcept {
  if (method == Method::nonlinear && tolerance >= kRowTolerance && tolerance <= 1e-2) {
    Batch(cases, tolerance, results).run();
    return;
  }
  for (std::size_t i = 0; i < cases.size(); ++i) results[i] = forces(cases[i], method, tolerance);
}

}  // namespace grouser::bekker
