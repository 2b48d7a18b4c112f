#include "kernel.h"

#include <cmath>

#include "gauss_rule.h"
#include "stress.h"

namespace grouser::bekker {

namespace {

constexpr int kSizes = static_cast<int>(kRuleSizes.size());
constexpr int sum_of_sizes(const std::array<int, 8>& sizes) {
  int sum = 0;
  for (int n : sizes) sum += n;
  return sum;
}
constexpr int kNodes = sum_of_sizes(kRuleSizes), kRowNodes = sum_of_sizes(kRowSizes);

/// All rules, in static storage: the hot path allocates nothing.
class RuleTable {
 public:
  RuleTable() {
    int first = 0;
    for (int k = 0; k < kSizes; ++k) {
      const int n = kRuleSizes[k];
      const GaussRule& gauss = gauss_rule(n);
      for (int i = 0; i < n; ++i) null_[first + i] = null_weight(n, 2 * gauss.x[i] - 1);
      for (int p = 1; p <= kLargestPower; ++p)
        for (int q = 1; q <= kLargestPower; ++q) {
          double* x = x_[p - 1][q - 1].data() + first;
          double* w = w_[p - 1][q - 1].data() + first;
          for (int i = 0; i < n; ++i) map(p, q, gauss.x[i], gauss.w[i], x[i], w[i]);
          rules_[k][p - 1][q - 1] = {n, x, w, null_.data() + first};
        }
      first += n;
    }
    first = 0;
    for (int k = 0; k < kRowClasses; ++k) {
      const int n = kRowSizes[k];
      const GaussRule& gauss = gauss_rule(n);
      row_rules_[k].n = n;
      row_rules_[k].limit = n <= 10 ? 2e-2 : (n <= 16 ? 1e-2 : 7e-3);
      row_rules_[k].null = row_null_.data() + first;
      for (int i = 0; i < n; ++i) row_null_[first + i] = null_weight(n, 2 * gauss.x[i] - 1);
      for (int p = 0; p < 2; ++p) {
        double *x = row_x_[p].data() + first, *w = row_w_[p].data() + first;
        for (int i = 0; i < n; ++i) map(p + 2, 1, gauss.x[i], gauss.w[i], x[i], w[i]);
        row_rules_[k].x[p] = x;
        row_rules_[k].w[p] = w;
      }
      first += n;
    }
  }
  const RowRule& row(int k) const { return row_rules_[k]; }
  const MappedRule& at(int k, int p, int q) const { return rules_[k][p - 1][q - 1]; }

 private:
  /// phi is the regularised incomplete beta function of whole p and q, a polynomial.
  static void map(int p, int q, double y, double weight, double& x, double& w) {
    const int m = p + q - 1;
    double binomial = 1;  // of m over j
    x = 0;
    for (int j = 0; j <= m; ++j) {
      if (j >= p) x += binomial * std::pow(y, j) * std::pow(1 - y, m - j);
      if (j == p - 1) w = weight * binomial * (m - j) * std::pow(y, p - 1) * std::pow(1 - y, q - 1);
      binomial *= static_cast<double>(m - j) / (j + 1);
    }
  }
  /// Legendre P_(n-1) + P_(n-2)/2, each times its normalisation, so that neither parity escapes.
  static double null_weight(int n, double t) {
    double before = 1, p = t;
    for (int k = 1; k < n - 1; ++k) {
      const double next = ((2 * k + 1) * t * p - k * before) / (k + 1);
      before = p;
      p = next;
    }
    return (2 * n - 1) * (p + 0.5 * before);
  }

  alignas(64) std::array<double, kNodes> null_{};
  alignas(64) std::array<std::array<std::array<double, kNodes>, kLargestPower>, kLargestPower> x_{};
  alignas(64) std::array<std::array<std::array<double, kNodes>, kLargestPower>, kLargestPower> w_{};
  std::array<std::array<std::array<MappedRule, kLargestPower>, kLargestPower>, kSizes> rules_{};
  std::array<double, kRowNodes> row_null_{};
  std::array<std::array<double, kRowNodes>, 2> row_x_{}, row_w_{};
  std::array<RowRule, kRowClasses> row_rules_{};
};

const RuleTable& rule_table() {
  static const RuleTable table;
  return table;
}

const Kernel& choose() {
#ifdef __x86_64__
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return kernel_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return kernel_avx2;
#endif
  return kernel_base;
}

// Filled before main, so that the first force costs no more than the others.
[[maybe_unused]] const RuleTable& warm = rule_table();

}  // namespace

const MappedRule& mapped_rule(int size_index, int p, int q) { return rule_table().at(size_index, p, q); }

const RowRule& row_rule(int row_class) { return rule_table().row(row_class); }

const Kernel& kernel() noexcept {
  static const Kernel& chosen = choose();
  return chosen;
}

ArcStress stress_at(const Arc& arc, double theta, ArcSlope& slope) {
  const StressPoint<double> p = stress_of<true>(arc, place_of(arc, theta), false);
  slope = {p.t_by_t, p.l_by_t, p.t_by_l, p.l_by_l};
  return {p.sigma, p.tau_t, p.tau_l};
}

}  // namespace grouser::bekker
