// forces() of many rows at once against the rows one by one and against a tolerance far below theirs.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "bekker_random_rows.h"
#include "kernel.h"
#include "rows.h"

namespace grouser::bekker {
namespace {

using test_rows::any_row;
using test_rows::gap_of;

constexpr double kTolerance = 1e-6;

std::vector<ForceCase> rows_of(unsigned seed, int count, bool driven_smooth) {
  std::mt19937_64 rng(seed);
  std::vector<ForceCase> cases;
  for (int i = 0; i < count; ++i) {
    ForceCase c = any_row(rng);
    if (driven_smooth) {
      c.slip = std::abs(c.slip);
      c.wheel.lug_height = c.unloading_sinkage = 0;
    }
    cases.push_back(c);
  }
  return cases;
}
std::vector<ForceResult> batch(const std::vector<ForceCase>& cases, double tolerance = kTolerance,
                               Method method = Method::nonlinear) {
  std::vector<ForceResult> results(cases.size());
  forces(cases, method, tolerance, results);
  return results;
}
std::array<double, 6> six(const WheelWrench& w) { return {w.Fx, w.Fy, w.Fz, w.Mx, w.My, w.Mz}; }
bool same_bits(const ForceResult& a, const ForceResult& b) {
  return six(a.wrench) == six(b.wrench) && a.status == b.status;
}

/// Largest difference of batch rows to single ones and to singles at 1e-11, of the force or the moment; how many rows
/// took a path of their own.
struct Worst {
  double to_single = 0, to_truth = 0;
  int other_bits = 0;
};
Worst worst_of(const std::vector<ForceCase>& cases) {
  const std::vector<ForceResult> results = batch(cases);
  Worst w;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const double r = cases[i].wheel.outer_radius();
    const ForceResult one = forces(cases[i], Method::nonlinear, kTolerance);
    const ForceResult truth = forces(cases[i], Method::nonlinear, 1e-11);
    EXPECT_EQ(results[i].status, one.status) << i;
    const auto size = [](const auto& gap) { return std::max(gap.force, gap.moment); };
    w.to_single = std::max(w.to_single, size(gap_of(results[i].wrench, six(one.wrench), r)));
    w.to_truth = std::max(w.to_truth, size(gap_of(results[i].wrench, six(truth.wrench), r)));
    w.other_bits += !same_bits(results[i], one);
  }
  return w;
}

TEST(Batch, OfTenThousandRowsWithEveryFeatureIsTheRowsOneByOne) {
  // Each may err by the tolerance.
  const Worst w = worst_of(rows_of(20261122, 10000, false));
  std::printf("rows with every feature: %.1e from single rows, %.1e from 1e-11; %d of 10000 in lanes\n", w.to_single,
              w.to_truth, w.other_bits);
  EXPECT_LE(w.to_single, 2 * kTolerance);
  EXPECT_LE(w.to_truth, kTolerance);
}

TEST(Batch, OfTenThousandDrivenSmoothWheelsIsTheRowsOneByOne) {
  const Worst w = worst_of(rows_of(7, 10000, true));
  std::printf("driven smooth wheels: %.1e from single rows, %.1e from 1e-11; %d of 10000 in lanes\n", w.to_single,
              w.to_truth, w.other_bits);
  EXPECT_LE(w.to_single, 2 * kTolerance);
  EXPECT_LE(w.to_truth, kTolerance);
  EXPECT_GT(w.other_bits, 8500);  // otherwise the lanes are not what is tested here
}

TEST(Batch, MeetsItsToleranceAgainstAnIndependentQuadrature) {
  const std::vector<ForceCase> cases = rows_of(8, 300, true);
  const std::vector<ForceResult> results = batch(cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto gap =
        gap_of(results[i].wrench, test_rows::WrittenOut(cases[i]).integral(), cases[i].wheel.outer_radius());
    EXPECT_LE(gap.force, kTolerance) << i;
    EXPECT_LE(gap.moment, kTolerance) << i;
  }
}

TEST(Batch, GivesARowTheSameBitsInAnyPlaceAndCompany) {
  // 4000 rows of all laws and rules fill and empty the groups in another order each time.
  std::vector<ForceCase> cases = rows_of(9, 3000, true), mixed = rows_of(10, 1000, false);
  cases.insert(cases.end(), mixed.begin(), mixed.end());
  const std::vector<ForceResult> results = batch(cases);
  std::vector<std::size_t> order(cases.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(11));
  std::vector<ForceCase> shuffled;
  for (const std::size_t i : order) shuffled.push_back(cases[i]);
  const std::vector<ForceResult> other = batch(shuffled);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_TRUE(same_bits(other[i], results[order[i]])) << order[i];
  for (std::size_t i = 0; i < 200; ++i) EXPECT_TRUE(same_bits(batch({cases[i]})[0], results[i])) << "alone " << i;
}

TEST(Batch, IsTheRowsOneByOneToTheLastBitBelow1e6AndForClosedForms) {
  const std::vector<ForceCase> cases = rows_of(3, 200, false);
  for (const auto& [method, tolerance] :
       {std::pair{Method::nonlinear, 1e-8}, {Method::quadratic, 1e-6}, {Method::linear, 1e-6}}) {
    const std::vector<ForceResult> results = batch(cases, tolerance, method);
    for (std::size_t i = 0; i < cases.size(); ++i)
      EXPECT_TRUE(same_bits(results[i], forces(cases[i], method, tolerance))) << i;
  }
}

TEST(Batch, NamesTheRowsThatItRefuses) {
  std::vector<ForceCase> cases = rows_of(4, 20, true);
  cases[3].wheel.radius = -1;
  cases[7].arc.theta_m = cases[7].arc.theta_f;
  const std::vector<ForceResult> results = batch(cases);
  for (std::size_t i = 0; i < cases.size(); ++i)
    EXPECT_EQ(results[i].status, i == 3   ? ForceStatus::bad_argument
                                 : i == 7 ? ForceStatus::no_pressure
                                          : ForceStatus::ok)
        << i;
  for (const ForceResult& r : batch(cases, 0)) EXPECT_NE(r.status, ForceStatus::ok);
}

TEST(RowsOfEveryInstructionSet, Agree) {
  std::vector<const Kernel*> kernels;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels.push_back(&kernel_avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) kernels.push_back(&kernel_avx512);
#endif
  std::vector<ForceCase> cases = rows_of(5, 2000, true);
  std::erase_if(cases, [](const ForceCase& c) { return !Rows::takes(c); });
  for (const ForceCase& c : cases) {
    const ShearLaw::Type type = c.soil.shear.type;
    const bool anisotropic = c.soil.lateral == Lateral::anisotropic;
    const auto run = [&](const Kernel& k, RowPlan& plan, RowSums& sums) {
      Rows rows;
      for (int i = 0; i < Rows::kSize; ++i) rows.set(i, c);
      k.plan_rows(rows, type, anisotropic, plan);
      if (plan.front[0] >= 0)
        k.integrate_rows(rows, type, anisotropic, row_rule(plan.front[0]), row_rule(plan.rear[0]), sums);
    };
    RowPlan plan, other;
    RowSums a, b;
    run(kernel_base, plan, a);
    for (const Kernel* k : kernels) {
      run(*k, other, b);
      ASSERT_EQ(plan.front[0], other.front[0]) << k->name;
      ASSERT_EQ(plan.rear[0], other.rear[0]) << k->name;
      if (plan.front[0] < 0) continue;
      const auto& w = a.wrench;
      const double force = std::hypot(w[0][0], w[1][0], w[2][0]), moment = std::hypot(w[3][0], w[4][0], w[5][0]);
      // Ten digits of each function, of which the instruction sets keep different ones.
      for (int i = 0; i < 6; ++i)
        EXPECT_NEAR(w[i][0], b.wrench[i][0], 1e-8 * std::max(i < 3 ? force : moment, i < 3 ? 0 : 0.01 * force));
    }
  }
}

}  // namespace
}  // namespace grouser::bekker
