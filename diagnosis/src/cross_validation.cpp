#include "cross_validation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>

namespace grouser::diagnosis {
namespace {

constexpr std::size_t most_blocks = 6;
constexpr double out_of_sight = 1e-12;  // weight of a run that is left out

/// Block of each run, by equal or neighbouring values. Empty: fewer than three levels.
std::vector<int> blocks(const std::vector<Run>& runs, const std::function<double(const Run&)>& of, int& count) {
  std::vector<long> level;
  for (const Run& r : runs) level.push_back(std::lround(of(r) * 1e4));
  std::vector<long> seen = level;
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  count = static_cast<int>(std::min(seen.size(), most_blocks));
  if (seen.size() < 3) return {};
  std::vector<int> out;
  for (const long l : level) {
    const auto at = static_cast<std::size_t>(std::lower_bound(seen.begin(), seen.end(), l) - seen.begin());
    out.push_back(static_cast<int>(seen.size() <= most_blocks ? at : at * most_blocks / seen.size()));
  }
  return out;
}

/// ln density of the rows left out, ~ N(f, C + J V J') with V of the fit without them, but for what depends on C alone. In whitened rows u, J
/// and with M = V^-1 + J'J:  -(u'u - u'J M^-1 J'u + ln det M - ln det V^-1)/2   (Woodbury).
double ln_predicted(const Search& s, const Whitener& without, const Fit& f, const std::function<bool(int)>& left_out) {
  const DataLayout& l = s.series().layout();
  Eigen::MatrixXd u = f.residual, J = f.jacobian, A = f.jacobian;
  s.whitener().apply(u);
  s.whitener().apply(J);
  without.apply(A);
  Eigen::MatrixXd precision = A.transpose() * A;
  precision.diagonal() += f.precision;
  for (int i = 0; i < l.size(); ++i)
    if (!left_out(l[i].run)) u(i, 0) = 0, J.row(i).setZero();
  const Eigen::VectorXd Ju = J.transpose() * u.col(0);
  const Eigen::LLT<Eigen::MatrixXd> M(precision + J.transpose() * J), P(precision);
  if (M.info() != Eigen::Success || P.info() != Eigen::Success) return -0.5 * u.squaredNorm();
  const auto ln_det = [](const auto& llt) { return 2 * llt.matrixLLT().diagonal().array().log().sum(); };
  return -0.5 * (u.squaredNorm() - Ju.dot(M.solve(Ju)) + ln_det(M) - ln_det(P));
}

}  // namespace

std::vector<double> cross_validate(const Search& s, const std::vector<Account>& accounts) {
  const Series& series = s.series();
  const std::function<double(const Run&)> variables[] = {
      [](const Run& r) { return r.load; }, [](const Run& r) { return r.slip; }, [](const Run& r) { return r.omega; }};
  std::vector<double> sum(accounts.size(), 0.0);
  int used = 0;
  for (const auto& of : variables) {
    int count = 0;
    const std::vector<int> block = blocks(series.runs(), of, count);
    if (block.empty()) continue;
    ++used;
    for (int b = 0; b < count; ++b) {
      Noise noise = s.noise();
      for (std::size_t r = 0; r < block.size(); ++r)
        if (block[r] == b) noise.weight[r] = out_of_sight;
      const Whitener w(series.layout(), noise, s.scatter());
      for (std::size_t a = 0; a < accounts.size(); ++a) {
        const Fit f = series.fit(*accounts[a].candidate, w, accounts[a].fit->x, accounts[a].fit->theta, 6);
        sum[a] += ln_predicted(s, w, f.ok ? f : *accounts[a].fit,
                               [&](int run) { return block[static_cast<std::size_t>(run)] == b; });
      }
    }
  }
  std::vector<double> out;
  for (const double x : sum) out.push_back(used > 0 ? (x - sum[0]) / used : std::numeric_limits<double>::quiet_NaN());
  return out;
}

}  // namespace grouser::diagnosis
