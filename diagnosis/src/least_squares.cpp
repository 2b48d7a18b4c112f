#include "grouser/diagnosis/least_squares.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

namespace grouser::diagnosis {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double to_coordinate(const FitVariable& v, double value) { return v.logarithmic ? std::log(value) : value; }
double to_value(const FitVariable& v, double x) { return v.logarithmic ? std::exp(x) : x; }

/// Data residuals, then one row per prior; the parameter block is x/scale.
class Rows final : public ceres::CostFunction {
 public:
  explicit Rows(const LeastSquaresProblem& p) : p_(p) {
    std::vector<std::size_t> of_tests;
    for (std::size_t i = 0; i < p.variables.size(); ++i) {
      if (p.variables[i].prior) priors_.push_back(i);
      if (p.variables[i].cluster >= 0)
        of_tests.push_back(i);
      else
        groups_.push_back({i});
    }
    if (!of_tests.empty()) groups_.push_back(std::move(of_tests));
    set_num_residuals(static_cast<int>(p.residuals + priors_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(p.variables.size()));
  }

  bool residuals(const double* u, double* r) const {
    const std::size_t n = p_.variables.size();
    std::vector<double> value(n);
    for (std::size_t i = 0; i < n; ++i) value[i] = to_value(p_.variables[i], u[i] * p_.variables[i].scale);
    if (!p_.model(value, std::span<double>(r, p_.residuals))) return false;
    for (std::size_t i = 0; i < p_.residuals; ++i)
      if (!std::isfinite(r[i])) return false;
    for (std::size_t k = 0; k < priors_.size(); ++k) {
      const FitVariable& v = p_.variables[priors_[k]];
      r[p_.residuals + k] = (u[priors_[k]] * v.scale - v.prior->mean) / v.prior->sd;
    }
    return true;
  }

  bool Evaluate(double const* const* parameters, double* r, double** jacobians) const override {
    const double* u = parameters[0];
    if (!residuals(u, r)) return false;
    if (!jacobians || !jacobians[0]) return true;
    return differences(u, jacobians[0]);
  }

  /// Row-major d r/d u, central; one-sided at a bound and where the model ends. Variables of different tests do not meet in a row and are
  /// moved together.
  bool differences(const double* u, double* jacobian) const {
    const std::size_t n = p_.variables.size(), m = static_cast<std::size_t>(num_residuals());
    std::fill(jacobian, jacobian + n * m, 0.0);
    std::vector<double> x(u, u + n), up(m), down(m), span(n);
    for (const std::vector<std::size_t>& group : groups_) {
      for (const std::size_t j : group) x[j] = std::min(u[j] + p_.step, bounds(j).second);
      const bool above = residuals(x.data(), up.data());
      for (const std::size_t j : group) span[j] = above ? x[j] : u[j];
      for (const std::size_t j : group) x[j] = std::max(u[j] - p_.step, bounds(j).first);
      const bool below = residuals(x.data(), down.data());
      for (const std::size_t j : group) span[j] -= below ? x[j] : u[j];
      for (const std::size_t j : group) x[j] = u[j];
      if ((!above && !below) || (!above && !residuals(u, up.data())) || (!below && !residuals(u, down.data())))
        return false;
      for (const std::size_t j : group) {
        if (!(span[j] > 0)) return false;
        const int cluster = p_.variables[j].cluster;
        for (std::size_t i = 0; i < m; ++i)
          if (cluster < 0 || (i < p_.residuals && p_.cluster[i] == cluster))
            jacobian[i * n + j] = (up[i] - down[i]) / span[j];
      }
    }
    return true;
  }

  std::pair<double, double> bounds(std::size_t j) const {
    const FitVariable& v = p_.variables[j];
    const double lo = v.logarithmic && !(v.lower > 0) ? -INFINITY : to_coordinate(v, v.lower);
    return {lo / v.scale, to_coordinate(v, v.upper) / v.scale};
  }
  std::size_t prior_rows() const { return priors_.size(); }

 private:
  const LeastSquaresProblem& p_;
  std::vector<std::size_t> priors_;
  std::vector<std::vector<std::size_t>> groups_;  ///< moved together
};

void check(const LeastSquaresProblem& p) {
  if (p.variables.empty()) throw std::invalid_argument("least squares: no variable");
  std::size_t priors = 0;
  for (const FitVariable& v : p.variables) {
    if (!(v.start >= v.lower && v.start <= v.upper) || !std::isfinite(v.start) || !(v.scale > 0))
      throw std::invalid_argument("least squares: start of '" + v.name + "' is outside its bounds");
    if (v.logarithmic && !(v.start > 0))
      throw std::invalid_argument("least squares: '" + v.name + "' must be positive");
    if (v.prior) ++priors;
    if (v.cluster < 0) continue;
    if (v.prior ||
        std::count_if(p.variables.begin(), p.variables.end(), [&](auto& o) { return o.cluster == v.cluster; }) > 1)
      throw std::invalid_argument("least squares: '" + v.name + "': one variable of each test, without a prior");
  }
  if (p.residuals + priors < p.variables.size())
    throw std::invalid_argument("least squares: " + std::to_string(p.residuals) + " residuals for " +
                                std::to_string(p.variables.size()) + " unknowns");
  const bool grouped = p.errors == ErrorModel::clustered ||
                       std::any_of(p.variables.begin(), p.variables.end(), [](auto& v) { return v.cluster >= 0; });
  if (grouped && p.cluster.size() != p.residuals)
    throw std::invalid_argument("least squares: every residual needs its cluster");
}

struct Minimum {
  std::vector<double> u;
  double cost = INFINITY;
  bool converged = false;
  std::string message;
};

/// held: indices that stay as they are.
Minimum minimise(const LeastSquaresProblem& p, std::vector<double> u, const std::vector<int>& held = {}) {
  auto* rows = new Rows(p);  // owned by the problem
  ceres::Problem problem;
  problem.AddResidualBlock(rows, nullptr, u.data());
  if (held.size() == u.size())
    problem.SetParameterBlockConstant(u.data());
  else if (!held.empty())
    problem.SetManifold(u.data(), new ceres::SubsetManifold(static_cast<int>(u.size()), held));
  for (std::size_t j = 0; j < u.size(); ++j) {
    const auto [lo, hi] = rows->bounds(j);
    if (std::isfinite(lo)) problem.SetParameterLowerBound(u.data(), static_cast<int>(j), lo);
    if (std::isfinite(hi)) problem.SetParameterUpperBound(u.data(), static_cast<int>(j), hi);
  }
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_QR;
  o.logging_type = ceres::SILENT;
  FLAGS_minloglevel = google::GLOG_FATAL;  // failed trial points are our own to report
  o.num_threads = 1;
  o.max_num_iterations = 500;
  o.function_tolerance = 1e-14;
  o.gradient_tolerance = 1e-14;
  o.parameter_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(o, &problem, &summary);
  Minimum m;
  m.converged = summary.termination_type == ceres::CONVERGENCE;
  m.message = summary.message;
  if (summary.IsSolutionUsable()) m.cost = summary.final_cost;
  m.u = std::move(u);
  return m;
}

/// Ceres creeps along a bound: variables close to one are put on it and the rest is solved again, as often as that is no worse.
Minimum minimise_with_bounds(const LeastSquaresProblem& p, std::vector<double> u) {
  Minimum best = minimise(p, std::move(u));
  const Rows rows(p);
  std::vector<int> held;
  while (std::isfinite(best.cost)) {
    std::vector<int> now;
    std::vector<double> at = best.u;
    for (std::size_t j = 0; j < at.size(); ++j) {
      const auto [lo, hi] = rows.bounds(j);
      const double near = std::min(1e-2, 1e-2 * (hi - lo));
      if (at[j] - lo > near && hi - at[j] > near) continue;
      at[j] = at[j] - lo <= near ? lo : hi;
      now.push_back(static_cast<int>(j));
    }
    if (now == held) break;
    Minimum bound = minimise(p, std::move(at), now);
    if (!(bound.cost <= best.cost * (1 + 1e-9))) break;
    best = std::move(bound);
    held = std::move(now);
  }
  return best;
}

std::vector<double> start_near(const LeastSquaresProblem& p, int which) {
  std::mt19937_64 engine(static_cast<std::uint64_t>(which));
  std::vector<double> u;
  Rows rows(p);
  for (std::size_t j = 0; j < p.variables.size(); ++j) {
    const FitVariable& v = p.variables[j];
    const auto [lo, hi] = rows.bounds(j);
    double x = to_coordinate(v, v.start) / v.scale;
    const double share = static_cast<double>(engine() >> 11) * 0x1p-53;
    if (which > 0 && v.cluster < 0) x += 2 * share - 1;
    // A start on a bound gives a one-sided gradient only: stay a little inside.
    const double margin = std::isfinite(hi - lo) ? 1e-3 * (hi - lo) : 1e-3;
    u.push_back(std::clamp(x, std::isfinite(lo) ? lo + margin : lo, std::isfinite(hi) ? hi - margin : hi));
  }
  return u;
}

std::string label(const FitVariable& v) { return v.logarithmic ? "ln " + v.name : v.name; }

std::string direction_text(const VectorXd& d, const std::vector<std::string>& names) {
  std::string text;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(d.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  const auto share = [&](Eigen::Index i) { return std::round(100 * std::abs(d[i])); };  // equal shares keep their order
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return share(a) > share(b); });
  const double sign = d[order[0]] < 0 ? -1 : 1;
  for (const auto i : order) {
    if (std::abs(d[i]) < 0.1) continue;
    char number[32];
    std::snprintf(number, sizeof number, "%.2f ", std::abs(d[i]));
    text += text.empty() ? "" : (sign * d[i] < 0 ? " - " : " + ");
    text += number + names[static_cast<std::size_t>(i)];
  }
  return text;
}

/// J and r of the free variables, with what belongs to one test alone projected out of that test's rows.
struct Linear {
  MatrixXd J;  // data rows, shared free variables
  MatrixXd prior;
  VectorXd r;
};

Linear project(const LeastSquaresProblem& p, const MatrixXd& J, const VectorXd& r,
               const std::vector<Eigen::Index>& shared, const std::vector<Eigen::Index>& own) {
  const auto N = static_cast<Eigen::Index>(p.residuals);
  Linear l{J(Eigen::seq(0, N - 1), shared), J(Eigen::seq(N, J.rows() - 1), shared), r.head(N)};
  for (const Eigen::Index c : own) {
    // One offset per test: Frisch-Waugh, v = column of the offset, rows of its test.
    const VectorXd v = J(Eigen::seq(0, N - 1), c);
    const double vv = v.squaredNorm();
    if (!(vv > 0)) continue;
    const Eigen::RowVectorXd s = v.transpose() * l.J / vv;
    const double t = v.dot(l.r) / vv;
    l.J -= v * s;
    l.r -= v * t;
  }
  return l;
}

MatrixXd clustered_covariance(const LeastSquaresProblem& p, const Linear& l, const MatrixXd& A,
                              const MatrixXd& A_inverse, int G) {
  const Eigen::Index n = A.rows();
  MatrixXd meat = l.prior.transpose() * l.prior;
  for (int g = 0; g < G; ++g) {
    MatrixXd A_g = MatrixXd::Zero(n, n);
    VectorXd s = VectorXd::Zero(n);
    for (std::size_t i = 0; i < p.residuals; ++i) {
      if (p.cluster[i] != g) continue;
      const auto row = l.J.row(static_cast<Eigen::Index>(i));
      A_g += row.transpose() * row;
      s += row.transpose() * l.r[static_cast<Eigen::Index>(i)];
    }
    const VectorXd u = (MatrixXd::Identity(n, n) - A_g * A_inverse).fullPivLu().solve(s);
    meat += u * u.transpose() * (double(G - 1) / G);
  }
  (void)A;
  return A_inverse * meat * A_inverse;
}

void find_weak(const LeastSquaresProblem& p, const Linear& l, const std::vector<Eigen::Index>& shared,
               LeastSquaresResult& out) {
  MatrixXd M(l.J.rows() + l.prior.rows(), l.J.cols());
  M << l.J, l.prior;
  std::vector<std::string> names;
  names.reserve(shared.size());
  for (const auto i : shared) names.push_back(label(p.variables[static_cast<std::size_t>(i)]));
  for (Eigen::Index j = 0; j < M.cols(); ++j) {
    const double length = M.col(j).norm();
    if (length > 0) M.col(j) /= length;
  }
  const Eigen::JacobiSVD<MatrixXd> svd(M, Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  for (Eigen::Index k = 0; k < s.size(); ++k) {
    const double index = s[k] > 0 ? s[0] / s[k] : INFINITY;
    out.condition = std::max(out.condition, index);
    if (index < 30) continue;
    const VectorXd d = svd.matrixV().col(k);
    WeakDirection w{index, direction_text(d, names), {}};
    for (Eigen::Index j = 0; j < d.size(); ++j)
      if (std::abs(d[j]) > 0.3)
        w.variables.push_back(p.variables[static_cast<std::size_t>(shared[static_cast<std::size_t>(j)])].name);
    if (index > 1e7) out.singular = true;
    out.weak.push_back(std::move(w));
  }
}

void errors_of(const LeastSquaresProblem& p, const MatrixXd& J, const VectorXd& r, LeastSquaresResult& out) {
  const auto n = static_cast<Eigen::Index>(p.variables.size());
  std::vector<Eigen::Index> shared, own;
  for (Eigen::Index j = 0; j < n; ++j) {
    if (out.estimates[static_cast<std::size_t>(j)].at_bound) continue;
    (p.variables[static_cast<std::size_t>(j)].cluster < 0 ? shared : own).push_back(j);
  }
  out.covariance = out.correlation = MatrixXd::Constant(n, n, nan);
  for (Estimate& e : out.estimates) e.standard_error = e.lower = e.upper = nan;
  out.dof = static_cast<int>(p.residuals) - static_cast<int>(shared.size() + own.size());
  for (const FitVariable& v : p.variables) out.dof += v.prior ? 1 : 0;
  out.scale = out.dof > 0 ? std::sqrt(out.sum_of_squares / out.dof) : nan;
  for (const int c : p.cluster) out.clusters = std::max(out.clusters, c + 1);
  if (shared.empty()) return;
  const Linear l = project(p, J, r, shared, own);
  find_weak(p, l, shared, out);
  if (out.singular) return;
  // In scaled coordinates A can still be badly scaled: unit diagonal first.
  MatrixXd A = l.J.transpose() * l.J + l.prior.transpose() * l.prior;
  const VectorXd d = A.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd unit = d.asDiagonal() * A * d.asDiagonal();
  const MatrixXd A_inverse =
      d.asDiagonal() * unit.ldlt().solve(MatrixXd::Identity(unit.rows(), unit.cols())) * d.asDiagonal();
  MatrixXd V;
  double& quantile = out.quantile;
  if (p.errors == ErrorModel::clustered) {
    if (out.clusters < 2) return;
    V = clustered_covariance(p, l, A, A_inverse, out.clusters);
    quantile = t_quantile(p.level, out.clusters - 1);
  } else if (p.errors == ErrorModel::scaled) {
    if (out.dof < 1) return;
    V = A_inverse * out.scale * out.scale;
    quantile = t_quantile(p.level, out.dof);
  } else {
    V = A_inverse;
    quantile = t_quantile(p.level, 0);
  }
  for (std::size_t a = 0; a < shared.size(); ++a) {
    const auto ia = static_cast<std::size_t>(shared[a]);
    const FitVariable& va = p.variables[ia];
    Estimate& e = out.estimates[ia];
    const auto A1 = static_cast<Eigen::Index>(a);
    e.standard_error = va.scale * std::sqrt(V(A1, A1));
    const double x = to_coordinate(va, e.value);
    e.lower = to_value(va, x - quantile * e.standard_error);
    e.upper = to_value(va, x + quantile * e.standard_error);
    for (std::size_t b = 0; b < shared.size(); ++b) {
      const auto B1 = static_cast<Eigen::Index>(b);
      const FitVariable& vb = p.variables[static_cast<std::size_t>(shared[b])];
      out.covariance(shared[a], shared[b]) = V(A1, B1) * va.scale * vb.scale;
      out.correlation(shared[a], shared[b]) = V(A1, B1) / std::sqrt(V(A1, A1) * V(B1, B1));
    }
  }
}

}  // namespace

const Estimate& LeastSquaresResult::at(const std::string& name) const {
  for (const Estimate& e : estimates)
    if (e.name == name) return e;
  throw std::out_of_range("no variable '" + name + "' in this fit");
}

double t_quantile(double level, double dof) {
  const double p = 0.5 + 0.5 * level;
  if (!(dof > 0)) return boost::math::quantile(boost::math::normal(), p);
  return boost::math::quantile(boost::math::students_t(dof), p);
}

LeastSquaresResult derive(const LeastSquaresProblem& p, const LeastSquaresResult& fit,
                          const std::vector<Derived>& derived) {
  const std::size_t n = p.variables.size();
  const auto m = static_cast<Eigen::Index>(derived.size());
  std::vector<double> value(n);
  std::vector<Eigen::Index> free;
  for (std::size_t j = 0; j < n; ++j) {
    value[j] = fit.estimates[j].value;
    const bool held = fit.estimates[j].at_bound || p.variables[j].cluster >= 0;
    if (!held) free.push_back(static_cast<Eigen::Index>(j));
  }
  LeastSquaresResult out = fit;
  out.estimates.clear();
  MatrixXd G(m, static_cast<Eigen::Index>(free.size()));
  for (Eigen::Index i = 0; i < m; ++i) {
    const Derived& d = derived[static_cast<std::size_t>(i)];
    const auto coordinate = [&](std::span<const double> v) { return d.logarithmic ? std::log(d.g(v)) : d.g(v); };
    for (std::size_t k = 0; k < free.size(); ++k) {
      const FitVariable& v = p.variables[static_cast<std::size_t>(free[k])];
      std::vector<double> at = value;
      double& x = at[static_cast<std::size_t>(free[k])];
      const double x0 = to_coordinate(v, x), h = 1e-5 * v.scale;
      x = to_value(v, x0 + h);
      const double up = coordinate(at);
      x = to_value(v, x0 - h);
      G(i, static_cast<Eigen::Index>(k)) = (up - coordinate(at)) / (2 * h);
    }
    Estimate e;
    e.name = d.name;
    e.logarithmic = d.logarithmic;
    e.value = d.g(value);
    for (const Estimate& old : fit.estimates)
      if (old.name == d.name) e.at_bound = old.at_bound, e.prior_z = old.prior_z;
    out.estimates.push_back(e);
  }
  const MatrixXd V =
      free.empty() ? MatrixXd(MatrixXd::Zero(m, m)) : MatrixXd(G * fit.covariance(free, free) * G.transpose());
  out.covariance = out.correlation = MatrixXd::Constant(m, m, nan);
  for (Eigen::Index i = 0; i < m; ++i) {
    Estimate& e = out.estimates[static_cast<std::size_t>(i)];
    const bool known = !e.at_bound && V(i, i) > 0;
    e.standard_error = known ? std::sqrt(V(i, i)) : nan;
    const double x = e.logarithmic ? std::log(e.value) : e.value, half = fit.quantile * e.standard_error;
    e.lower = e.logarithmic ? std::exp(x - half) : x - half;
    e.upper = e.logarithmic ? std::exp(x + half) : x + half;
    for (Eigen::Index k = 0; k < m; ++k) {
      if (!known || !(V(k, k) > 0)) continue;
      out.covariance(i, k) = V(i, k);
      out.correlation(i, k) = V(i, k) / std::sqrt(V(i, i) * V(k, k));
    }
  }
  return out;
}

LineFit fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> w) {
  Eigen::MatrixXd M(static_cast<Eigen::Index>(x.size()), 2);
  Eigen::VectorXd v(M.rows());
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double root = w.empty() ? 1 : std::sqrt(w[k]);
    M.row(i) << root, root * x[k];
    v[i] = root * y[k];
  }
  const Eigen::Vector2d p = M.colPivHouseholderQr().solve(v);
  LineFit f{p[0], p[1], nan, nan, nan, static_cast<int>(x.size()) - 2};
  if (f.dof < 1) return f;
  const double s2 = (M * p - v).squaredNorm() / f.dof;
  const Eigen::Matrix2d V = s2 * (M.transpose() * M).inverse();
  f.se_a = std::sqrt(V(0, 0));
  f.se_b = std::sqrt(V(1, 1));
  f.covariance = V(0, 1);
  return f;
}

LeastSquaresResult solve_least_squares(const LeastSquaresProblem& p) {
  check(p);
  LeastSquaresResult out;
  out.starts = std::max(1, p.starts);
  Minimum best;
  std::vector<double> costs;
  for (int k = 0; k < out.starts; ++k) {
    Minimum m = minimise_with_bounds(p, start_near(p, k));
    costs.push_back(m.cost);
    if (k == 0 || m.cost < best.cost) best = std::move(m);
  }
  // Ceres stops early in a long flat valley: from the best point once more, until that no longer helps.
  for (int again = 0; again < 10; ++again) {
    Minimum m = minimise_with_bounds(p, best.u);
    const bool helped = m.cost < best.cost * (1 - 1e-9);
    if (m.cost <= best.cost) best = std::move(m);
    if (!helped) break;
  }
  for (const double c : costs) out.starts_agreeing += c <= best.cost * 1.01 + 1e-300 ? 1 : 0;
  out.converged = best.converged && std::isfinite(best.cost);
  out.message = best.message;

  const Rows rows(p);
  for (std::size_t j = 0; j < p.variables.size(); ++j) {
    const FitVariable& v = p.variables[j];
    const auto [lo, hi] = rows.bounds(j);
    Estimate e;
    e.name = v.name;
    e.logarithmic = v.logarithmic;
    e.cluster = v.cluster;
    e.at_bound = best.u[j] - lo < 1e-6 || hi - best.u[j] < 1e-6;
    if (e.at_bound) best.u[j] = best.u[j] - lo < 1e-6 ? lo : hi;
    e.value = to_value(v, best.u[j] * v.scale);
    if (v.prior) e.prior_z = (best.u[j] * v.scale - v.prior->mean) / v.prior->sd;
    out.estimates.push_back(e);
  }
  const Eigen::Index m = rows.num_residuals(), n = static_cast<Eigen::Index>(p.variables.size());
  VectorXd r(m);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J(m, n);
  if (!rows.residuals(best.u.data(), r.data()) || !rows.differences(best.u.data(), J.data())) {
    out.converged = false;
    if (out.message.empty()) out.message = "the model has no answer at the start values";
    return out;
  }
  out.residuals.assign(r.data(), r.data() + p.residuals);
  out.sum_of_squares = r.head(static_cast<Eigen::Index>(p.residuals)).squaredNorm();
  errors_of(p, J, r, out);
  return out;
}

}  // namespace grouser::diagnosis
