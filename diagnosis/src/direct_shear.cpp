#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "grouser/bekker/wheel_forces.h"
#include "grouser/diagnosis/soil_tests.h"

namespace grouser::diagnosis {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Points {
  std::vector<double> sigma, j, tau;
  std::vector<int> test;
};

Points all_points(const std::vector<ShearCurve>& curves) {
  Points p;
  for (std::size_t g = 0; g < curves.size(); ++g)
    for (std::size_t i = 0; i < curves[g].stress.size(); ++i) {
      p.sigma.push_back(curves[g].normal_stress);
      p.j.push_back(curves[g].displacement[i]);
      p.tau.push_back(curves[g].stress[i]);
      p.test.push_back(static_cast<int>(g));
    }
  return p;
}

/// Sums of Wong's weighted least squares: K = jj/jl.
struct WongSums {
  double jj = 0, jl = 0;
};

WongSums wong_sums(const ShearCurve& c, double tau_max) {
  WongSums s;
  for (std::size_t i = 0; i < c.stress.size(); ++i) {
    const double rest = 1 - c.stress[i] / tau_max, j = c.displacement[i];
    if (!(rest > 0)) continue;
    s.jj += rest * rest * j * j;
    s.jl -= rest * rest * j * std::log(rest);
  }
  return s;
}

double largest(const ShearCurve& c) { return *std::max_element(c.stress.begin(), c.stress.end()); }

double third_of_rise(const ShearCurve& c, double tau_max) {
  for (std::size_t i = 1; i < c.stress.size(); ++i) {
    const double a = c.stress[i - 1], b = c.stress[i], at = 0.95 * tau_max;
    if (a < at && b >= at)
      return (c.displacement[i - 1] + (at - a) / (b - a) * (c.displacement[i] - c.displacement[i - 1])) / 3;
  }
  return nan;
}

struct Start {
  double c = 0, phi = 0.5, K = 1e-3, top = 1;
};

Start first_guess(const std::vector<ShearCurve>& curves) {
  std::vector<double> sigma, tau;
  WongSums s;
  Start g;
  g.top = 0;
  for (const ShearCurve& c : curves) {
    const double peak = largest(c);
    sigma.push_back(c.normal_stress);
    tau.push_back(peak);
    g.top = std::max(g.top, peak);
    const WongSums one = wong_sums(c, peak);
    s.jj += one.jj;
    s.jl += one.jl;
  }
  if (s.jl > 0 && s.jj > 0) g.K = s.jj / s.jl;
  const auto [low, high] = std::minmax_element(sigma.begin(), sigma.end());
  if (*high > *low) {
    const LineFit line = fit_line(sigma, tau);
    g.c = std::max(0.0, line.a);
    g.phi = std::clamp(std::atan(line.b), 0.02, 1.4);
  } else if (*high > 0) {
    g.phi = std::clamp(std::atan(g.top / *high), 0.02, 1.4);
  }
  return g;
}

FitVariable cohesion(const Start& g) { return {"c", g.c, 0, INFINITY, 0.05 * g.top, false, {}, -1}; }
FitVariable friction(const Start& g) { return {"phi", g.phi, 0, 1.55, 0.1, false, {}, -1}; }
FitVariable length(const char* name, double K) { return {name, std::clamp(K, 1e-6, 0.9), 1e-7, 1, 1, true, {}, -1}; }

LeastSquaresResult joint_fit(const Points& p, ShearLaw::Type type, const Start& g, ErrorModel errors) {
  LeastSquaresProblem problem;
  problem.variables = {cohesion(g), friction(g), length(type == ShearLaw::Type::A ? "K" : "Kw", g.K)};
  if (type != ShearLaw::Type::A) problem.variables[2].start = std::clamp(2 * g.K, 1e-6, 0.9);
  if (type == ShearLaw::Type::C) problem.variables.push_back({"Kr", 0.7, 0.01, 1, 0.1, false, {}, -1});
  problem.residuals = p.tau.size();
  problem.cluster = p.test;
  problem.errors = errors;
  problem.starts = 5;
  problem.model = [&](std::span<const double> x, std::span<double> r) {
    ShearLaw law{type, x[0], x[1], x[2], x[2], x.size() > 3 ? x[3] : 1};
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = ((x[0] + p.sigma[i] * std::tan(x[1])) * bekker::mobilised(law, std::max(0.0, p.j[i])) - p.tau[i]) / g.top;
    return true;
  };
  return solve_least_squares(problem);
}

/// c and phi of the peaks, then K of the rise: two problems whose estimates are put side by side.
LeastSquaresResult wong_fit(const std::vector<ShearCurve>& curves, const Start& g) {
  LeastSquaresProblem peaks;
  peaks.variables = {cohesion(g), friction(g)};
  peaks.residuals = curves.size();
  peaks.model = [&](std::span<const double> x, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = (x[0] + curves[i].normal_stress * std::tan(x[1]) - largest(curves[i])) / g.top;
    return true;
  };
  LeastSquaresProblem rise;
  rise.variables = {length("K", g.K)};
  std::vector<double> j, rest;
  for (std::size_t t = 0; t < curves.size(); ++t) {
    const double peak = largest(curves[t]);
    for (std::size_t i = 0; i < curves[t].stress.size(); ++i) {
      const double left = 1 - curves[t].stress[i] / peak;
      if (!(left > 0)) continue;
      j.push_back(curves[t].displacement[i]);
      rest.push_back(left);
      rise.cluster.push_back(static_cast<int>(t));
    }
  }
  rise.residuals = j.size();
  rise.errors = curves.size() > 2 ? ErrorModel::clustered : ErrorModel::scaled;
  rise.model = [&](std::span<const double> x, std::span<double> r) {
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = rest[i] * (std::log(rest[i]) + j[i] / x[0]);
    return true;
  };
  LeastSquaresResult a = solve_least_squares(peaks);
  const LeastSquaresResult b = solve_least_squares(rise);
  a.estimates.push_back(b.estimates[0]);
  const Eigen::MatrixXd V = a.covariance, R = a.correlation;
  a.covariance = a.correlation = Eigen::MatrixXd::Zero(3, 3);
  a.covariance.topLeftCorner(2, 2) = V;
  a.correlation.topLeftCorner(2, 2) = R;
  a.covariance(2, 2) = b.covariance(0, 0);
  a.correlation(2, 2) = 1;
  a.converged = a.converged && b.converged;
  if (!b.converged) a.message = b.message;
  a.clusters = static_cast<int>(curves.size());
  return a;
}

double lag_one(std::span<const double> r) {
  double above = 0, below = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    below += r[i] * r[i];
    if (i > 0) above += r[i] * r[i - 1];
  }
  return below > 0 ? above / below : 0;
}

}  // namespace

DirectShearFit fit_direct_shear(const std::vector<ShearCurve>& curves, ShearLaw::Type type, KMethod method,
                                ErrorModel errors) {
  if (curves.empty()) throw std::invalid_argument("direct shear: no test");
  for (const ShearCurve& c : curves)
    if (c.stress.size() < 3 || c.stress.size() != c.displacement.size() || !(largest(c) > 0))
      throw std::invalid_argument("direct shear: test '" + c.test + "' needs three points and a positive stress");
  if (method == KMethod::wong && type != ShearLaw::Type::A)
    throw std::invalid_argument("direct shear: Wong's K belongs to type A");
  if (method == KMethod::wong && curves.size() < 2)
    throw std::invalid_argument(
        "direct shear: Wong's method draws a line through the peaks and needs two normal stresses");
  const Points p = all_points(curves);
  const Start g = first_guess(curves);
  DirectShearFit out;
  out.fit = method == KMethod::wong ? wong_fit(curves, g) : joint_fit(p, type, g, errors);
  out.law.type = type;
  out.law.cohesion = out.fit.at("c").value;
  out.law.friction_angle = out.fit.at("phi").value;
  (type == ShearLaw::Type::A ? out.law.K : out.law.Kw) = out.fit.estimates[2].value;
  if (type == ShearLaw::Type::C) out.law.Kr = out.fit.at("Kr").value;
  for (const ShearCurve& c : curves) {
    ShearTestResult t{c.test, c.normal_stress, largest(c), 0, 0, 0, 0};
    const WongSums s = wong_sums(c, t.tau_max);
    t.K_wong = s.jl > 0 ? s.jj / s.jl : nan;
    t.K_third = third_of_rise(c, t.tau_max);
    std::vector<double> r;
    for (std::size_t i = 0; i < c.stress.size(); ++i)
      r.push_back((out.law.cohesion + c.normal_stress * std::tan(out.law.friction_angle)) *
                      bekker::mobilised(out.law, std::max(0.0, c.displacement[i])) -
                  c.stress[i]);
    for (const double x : r) t.rms += x * x / static_cast<double>(r.size());
    t.rms = std::sqrt(t.rms);
    t.lag1 = lag_one(r);
    out.tests.push_back(t);
  }
  return out;
}

}  // namespace grouser::diagnosis
