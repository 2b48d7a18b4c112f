#include "soil_search.h"

#include <nlopt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <stdexcept>

namespace grouser::app {

namespace {

const std::vector<std::pair<std::string, nlopt_algorithm>> methods{
    {"bobyqa", NLOPT_LN_BOBYQA}, {"sbplx", NLOPT_LN_SBPLX}, {"nelder-mead", NLOPT_LN_NELDERMEAD}};

std::vector<Point> space_filling(std::size_t dimensions, std::size_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto unit = [](std::uint64_t x) { return static_cast<double>(x >> 11) * 0x1p-53; };
  Point shift;
  for (std::size_t k = 0; k < dimensions; ++k) shift.push_back(unit(random()));
  boost::random::sobol sobol(dimensions);
  std::vector<Point> out(n, Point(dimensions));
  for (Point& p : out)
    for (std::size_t k = 0; k < dimensions; ++k) {
      const double x = unit(sobol()) + shift[k];
      p[k] = x - std::floor(x);
    }
  return out;
}

struct Call {
  const Values* values;
  nlopt_opt method;
  std::set<Point> asked;
  std::size_t most;
  std::exception_ptr failed;
};

double one_value(unsigned n, const double* x, double*, void* data) {
  auto& c = *static_cast<Call*>(data);
  const Point p(x, x + n);
  // The method's first point may be known already, or be moved by it.
  if (c.asked.insert(p).second && c.asked.size() > c.most) {
    nlopt_force_stop(c.method);
    return 0;
  }
  try {
    return (*c.values)({p}).at(0);
  } catch (...) {
    // No exception may pass through a C library.
    c.failed = std::current_exception();
    nlopt_force_stop(c.method);
    return 0;
  }
}

}  // namespace

const std::vector<std::string>& search_methods() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const auto& m : methods) out.push_back(m.first);
    return out;
  }();
  return names;
}

void search(std::size_t dimensions, const SearchSettings& s, const Values& values) {
  if (dimensions == 0 || s.first == 0 || s.most == 0)
    throw std::invalid_argument("search: dimensions and points must be positive");
  if (std::none_of(methods.begin(), methods.end(), [&](const auto& m) { return m.first == s.method; }))
    throw std::invalid_argument("search: unknown method " + s.method);
  const std::vector<Point> set = space_filling(dimensions, std::min(s.first, s.most), s.seed);
  const std::vector<double> y = values(set);
  std::size_t best = set.size();
  for (std::size_t k = 0; k < y.size(); ++k)
    if (std::isfinite(y[k]) && (best == set.size() || y[k] < y[best])) best = k;
  if (best == set.size() || s.most <= s.first) return;
  const auto chosen = std::find_if(methods.begin(), methods.end(), [&](const auto& m) { return m.first == s.method; });
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> method(
      nlopt_create(chosen->second, static_cast<unsigned>(dimensions)), nlopt_destroy);
  Call call{&values, method.get(), std::set<Point>(set.begin(), set.end()), s.most, nullptr};
  nlopt_set_min_objective(method.get(), one_value, &call);
  nlopt_set_lower_bounds1(method.get(), 0);
  nlopt_set_upper_bounds1(method.get(), 1);
  nlopt_set_initial_step1(method.get(), s.step);
  nlopt_set_xtol_abs1(method.get(), s.tolerance);
  Point x = set[best];
  double found = 0;
  const nlopt_result end = nlopt_optimize(method.get(), x.data(), &found);
  if (call.failed) std::rethrow_exception(call.failed);
  // Rounding may end a search that has come as far as it gets; all else is a mistake of ours.
  if (end < 0 && end != NLOPT_ROUNDOFF_LIMITED && end != NLOPT_FORCED_STOP)
    throw std::logic_error("search: " + s.method + " ended with code " + std::to_string(end));
}

std::vector<bool> pareto_front(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<bool> front(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    front[k] = std::isfinite(a[k]) && std::isfinite(b[k]);
    for (std::size_t i = 0; i < a.size() && front[k]; ++i)
      if (a[i] <= a[k] && b[i] <= b[k] && (a[i] < a[k] || b[i] < b[k])) front[k] = false;
  }
  return front;
}

std::vector<Slope> plane_through(const std::vector<Point>& x, const std::vector<double>& y) {
  if (x.empty()) return {};
  const auto rows = static_cast<Eigen::Index>(x.size()), columns = static_cast<Eigen::Index>(x[0].size()) + 1;
  if (rows < columns) return {};
  Eigen::MatrixXd A(rows, columns);
  Eigen::VectorXd v(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    A(r, 0) = 1;
    for (Eigen::Index c = 1; c < columns; ++c)
      A(r, c) = x[static_cast<std::size_t>(r)][static_cast<std::size_t>(c - 1)];
    v(r) = y[static_cast<std::size_t>(r)];
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  if (qr.rank() < columns) return {};
  const Eigen::VectorXd b = qr.solve(v);
  const Eigen::MatrixXd cofactor = (A.transpose() * A).inverse();
  const double free = static_cast<double>(rows - columns);
  std::vector<Slope> out;
  for (Eigen::Index c = 1; c < columns; ++c) {
    double half = std::numeric_limits<double>::quiet_NaN();
    if (free > 0) {
      const double t = boost::math::quantile(boost::math::students_t(free), 0.975);
      half = t * std::sqrt((v - A * b).squaredNorm() / free * cofactor(c, c));
    }
    out.push_back({b(c), half});
  }
  return out;
}

}  // namespace grouser::app
