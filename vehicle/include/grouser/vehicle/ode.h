#pragma once
// Thin wrapper of SUNDIALS CVODE: stiff initial-value problems dy/dt = f(t, y) with root finding.
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace grouser::vehicle {

/// The integrator gave up: what() names the time, CVODE's own words and the remedy.
struct OdeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct OdeOptions {
  double relative = 1e-8;        ///< [-] > 0, relative tolerance of every component
  std::vector<double> absolute;  ///< unit of each component, > 0; one value serves all; default 1e-10
  double max_step =
      std::numeric_limits<double>::infinity();  ///< [s] > 0; keeps the solver from stepping over a short bump
  long max_steps = 1000000;                     ///< internal steps per advance()
};

/// dy/dt = f(t, y) by variable-order, variable-step backward differentiation (BDF 1..5), Newton with a dense difference-quotient
/// Jacobian. Cost per step: 1-3 evaluations of f, n + 1 more when the Jacobian is renewed. Not copyable, one thread at a time.
/// An exception thrown by f or by the root functions ends advance() and is rethrown there unchanged.
/// Source: Hindmarsh et al. (2005), SUNDIALS: suite of nonlinear and differential/algebraic equation solvers, ACM TOMS 31(3).
class Ode {
 public:
  using Rhs = std::function<void(double t, std::span<const double> y, std::span<double> dydt)>;
  /// g(t, y): advance() stops where any g changes sign.
  using Roots = std::function<void(double t, std::span<const double> y, std::span<double> g)>;
  enum class Stop { end, root };

  /// @throws OdeError: no component, tolerance not positive, or `absolute` neither of size 1 nor of y's size.
  Ode(double t0, std::vector<double> y0, Rhs f, OdeOptions options = {});
  ~Ode();
  Ode(Ode&&) noexcept;

  /// Watch n functions. Call before the first advance().
  void watch(int n, Roots g);

  /// Integrate to t_end exactly, or to the first root on the way. f is never evaluated beyond t_end. @throws OdeError
  Stop advance(double t_end);

  double time() const;
  std::span<const double> state() const;
  /// After Stop::root: +1 / -1 where g[i] crossed upward / downward, 0 elsewhere.
  const std::vector<int>& crossings() const;
  /// Forget the history: needed where f or y jumps (touch-down, impact).
  void restart(double t, std::span<const double> y);

  long steps() const;        ///< internal steps so far
  long evaluations() const;  ///< of f so far

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grouser::vehicle
