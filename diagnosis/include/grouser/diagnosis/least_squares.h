#pragma once
// Nonlinear least squares with standard errors that say when they cannot be trusted. The minimiser is Ceres.
#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace grouser::diagnosis {

/// Normal prior of a variable, of its logarithm where the variable is logarithmic.
struct Prior {
  double mean = 0, sd = 1;  ///< in the fitted coordinate
};

/// One unknown. The fitted coordinate is x = value, or x = ln value where `logarithmic` (value > 0, intervals are factors).
struct FitVariable {
  std::string name;
  double start = 0;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  double scale =
      1;  ///< > 0, typical size of x: steps of the difference quotients and the spread of the starts are fractions of it
  bool logarithmic = false;
  std::optional<Prior> prior;
  int cluster = -1;  ///< >= 0: acts on the residuals of this cluster only (zero offset of one test); one per
                     ///< cluster, without a prior
};

/// How the standard errors follow from the residuals r = (model - measured)/weight, J = dr/dx, A = J'J:
///   stated     V = A^-1                                     the weights are standard deviations that are trusted
///   scaled     V = A^-1 r'r/(N - p)                         independent errors of unknown size
///   clustered  V = (G-1)/G A^-1 (sum_g u_g u_g') A^-1,  u_g = (I - A_g A^-1)^-1 J_g' r_g
///              errors of one test belong together, G tests; the linearised leave-one-test-out jackknife (CR3: Bell & McCaffrey 2002,
///              Survey Methodology 28). Variables of one test alone are projected out of that test's rows first.
/// Intervals: x +- t(level; dof) sqrt(V_ii), dof = N - p, clustered: G - 1, stated: normal.
enum class ErrorModel { stated, scaled, clustered };

struct LeastSquaresProblem {
  std::vector<FitVariable> variables;
  std::size_t residuals = 0;
  /// Weighted residuals at these values; false = the model has no answer there (the minimiser steps back).
  std::function<bool(std::span<const double> values, std::span<double> residuals)> model;
  std::vector<int> cluster;  ///< 0..G-1 of each residual; may be empty unless `clustered`
  ErrorModel errors = ErrorModel::scaled;
  double level = 0.95;
  int starts = 1;      ///< first from `start`, the others around it (fixed seed); the best minimum wins
  double step = 1e-5;  ///< central differences: x +- step * scale
};

struct Estimate {
  std::string name;
  double value = 0, standard_error = 0;  ///< of ln value where logarithmic; NaN = cannot be said
  double lower = 0, upper = 0;           ///< interval at `level`
  bool logarithmic = false;
  bool at_bound = false;  ///< the minimum lies on a bound: held there, no error
  int cluster = -1;
  double prior_z = 0;  ///< (x - prior mean)/prior sd; 0 without a prior
};

/// A direction along which the data hardly speak: unit vector over the free variables in their scaled coordinates.
struct WeakDirection {
  double condition_index = 0;          ///< largest singular value of J with columns of unit length over this one
  std::string text;                    ///< "0.71 ln k - 0.70 n"
  std::vector<std::string> variables;  ///< those with a share above 0.3
};

struct LeastSquaresResult {
  bool converged = false;
  std::string message;              ///< why not
  std::vector<Estimate> estimates;  ///< in the order of the variables
  /// Of the fitted coordinates; rows and columns of variables at a bound or not identified are NaN.
  Eigen::MatrixXd covariance, correlation;
  std::vector<double> residuals;
  double sum_of_squares = 0;  ///< r'r of the data rows
  double quantile = 0;        ///< of the intervals
  double scale = 0;           ///< sqrt(r'r/dof): 1 = the residuals are as large as the weights say
  int dof = 0;
  int clusters = 0;
  double condition = 0;  ///< largest condition index over the shared variables; infinity = singular
  /// Condition index above 30: near-collinear (Belsley, Kuh & Welsch 1980); above 1e7: not identifiable.
  std::vector<WeakDirection> weak;
  bool singular = false;                ///< some direction is not identifiable: the errors of its variables are NaN
  int starts = 0, starts_agreeing = 0;  ///< starts that ended within 1 % of the best sum of squares

  const Estimate& at(const std::string& name) const;  ///< @throws std::out_of_range
};

/// @throws std::invalid_argument: no variable, fewer residuals than variables, a start outside its bounds or not finite, a cluster
/// number missing. A model that fails at the first start gives converged = false.
LeastSquaresResult solve_least_squares(const LeastSquaresProblem& problem);

/// Quantities that follow from the fitted ones, g(values), with errors by the delta method (gradient by differences).
struct Derived {
  std::string name;
  std::function<double(std::span<const double> values)> g;
  bool logarithmic = false;  ///< interval of ln g
};
/// The result with `derived` in place of the variables; what says how good the fit is stays.
LeastSquaresResult derive(const LeastSquaresProblem& problem, const LeastSquaresResult& fit,
                          const std::vector<Derived>& derived);

/// Straight line y = a + b x with weights w: values and covariance scaled by the residuals; dof = n - 2.
struct LineFit {
  double a = 0, b = 0, se_a = 0, se_b = 0, covariance = 0;
  int dof = 0;
};
LineFit fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> w = {});

/// Two-sided quantile of Student's t, of the normal for dof <= 0.
double t_quantile(double level, double dof);

}  // namespace grouser::diagnosis
