#include "lack_of_fit.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <map>
#include <numeric>
#include <set>

namespace grouser::diagnosis {
namespace {

template <class Distribution>
double beyond(const Distribution& d, double x) {
  return boost::math::cdf(boost::math::complement(d, x));
}

/// Cells: condition and channel, with two runs or more, each on a preparation of its own.
void add_replicates(const Search& s, const Eigen::VectorXd& u, double parameters, std::vector<FitTest>& out) {
  std::map<std::pair<int, int>, std::vector<double>> cells;
  std::map<std::pair<int, int>, std::set<int>> batches;
  const DataLayout& l = s.series().layout();
  for (int i = 0; i < l.size(); ++i) {
    const Run& r = s.series().runs()[static_cast<std::size_t>(l[i].run)];
    const std::pair<int, int> key{r.condition, l[i].channel};
    cells[key].push_back(u[i]);
    batches[key].insert(r.batch);
  }
  double within = 0, between = 0, within_dof = 0, between_dof = 0;
  for (const auto& [key, values] : cells) {
    const double n = static_cast<double>(values.size()), mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
    if (batches[key].size() < values.size()) continue;
    between += n * mean * mean;
    ++between_dof;
    for (const double x : values) within += (x - mean) * (x - mean);
    within_dof += n - 1;
  }
  between_dof -= parameters;
  if (within_dof < 4 || between_dof < 1 || !(within > 0)) return;
  const double F = between / between_dof / (within / within_dof);
  out.push_back({"replicates", "", F, beyond(boost::math::fisher_f(between_dof, within_dof), F), 1});
}

}  // namespace

double runs_z(const std::vector<double>& r) {
  double plus = 0, minus = 0, runs = 0;
  int last = 0;
  for (const double x : r) {
    if (x == 0) continue;
    const int sign = x > 0 ? 1 : -1;
    (sign > 0 ? plus : minus) += 1;
    runs += sign != last ? 1 : 0;
    last = sign;
  }
  const double n = plus + minus, mean = 2 * plus * minus / n + 1,
               variance = (mean - 1) * (mean - 2) / std::max(n - 1, 1.0);
  return variance > 0 ? (runs - mean) / std::sqrt(variance) : 0;
}

double ljung_box(const std::vector<double>& r, int lags) {
  const double n = static_cast<double>(r.size()), mean = std::accumulate(r.begin(), r.end(), 0.0) / n;
  double own = 0, q = 0;
  for (const double x : r) own += (x - mean) * (x - mean);
  for (int k = 1; k <= lags; ++k) {
    double sum = 0;
    for (std::size_t i = static_cast<std::size_t>(k); i < r.size(); ++i)
      sum += (r[i] - mean) * (r[i - static_cast<std::size_t>(k)] - mean);
    q += sum * sum / (own * own) / (n - k);
  }
  return own > 0 ? n * (n + 2) * q : 0;
}

void adjust_holm(std::vector<FitTest>& tests) {
  std::vector<std::size_t> order(tests.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return tests[a].p < tests[b].p; });
  double least = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    least = std::max(least, std::min(1.0, static_cast<double>(order.size() - k) * tests[order[k]].p));
    tests[order[k]].holm = least;
  }
}

std::vector<FitTest> lack_of_fit(const Search& s, const Fit& f, const Search::Remainder& structure, bool ordered) {
  std::vector<FitTest> out;
  Eigen::MatrixXd u = f.residual;
  s.whitener().apply(u);
  add_replicates(s, u.col(0), static_cast<double>(f.x.size()), out);
  out.push_back({"structure", structure.id, structure.gain, std::min(structure.p, 1.0), 1});
  const DataLayout& l = s.series().layout();
  for (int c = 0; c < channel_count && ordered; ++c) {
    std::vector<std::pair<std::pair<double, double>, double>> along;
    for (int i = 0; i < l.size(); ++i) {
      const Run& r = s.series().runs()[static_cast<std::size_t>(l[i].run)];
      if (l[i].channel == c) along.push_back({{r.order, r.time}, f.residual[i] / l[i].sd});
    }
    if (along.size() < 20) continue;
    std::stable_sort(along.begin(), along.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<double> r;
    for (const auto& [place, x] : along) r.push_back(x);
    const char* name = channel_names()[static_cast<std::size_t>(c)].short_name;
    const double z = runs_z(r), q = ljung_box(r, 5);
    out.push_back({"runs", name, z, 2 * beyond(boost::math::normal(), std::abs(z)), 1});
    out.push_back({"Ljung-Box", name, q, beyond(boost::math::chi_squared(5), q), 1});
  }
  adjust_holm(out);
  return out;
}

}  // namespace grouser::diagnosis
