#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "grouser/bekker/forces.h"

namespace grouser::bekker {

namespace {

constexpr double kTorque = 1e-9;  // of |torque| + load r
constexpr std::array kSlips{0.005, 0.01, 0.02, 0.035, 0.05, 0.07, 0.1, 0.14, 0.2,
                            0.3,   0.4,  0.5,  0.6,   0.7,  0.8,  0.9, 0.95, 1.0};

}  // namespace

// The torque of the wheel that carries its load, followed from slip 0 towards the wanted one: the first slip that
// meets it. Torque grows with slip on type A; types B and C have a peak, and behind it the wheel spins up.
Solution solve_free_slip(const LoadCase& given, double torque, Method method, double tolerance) noexcept {
  LoadCase c = given;
  Solution found;
  const auto excess = [&](double slip) {
    c.slip = slip;
    found = solve(c, method, tolerance);
    return -found.wrench.My - torque;
  };
  const auto refuse = [&](ForceStatus status) {
    found.status = status;
    return found;
  };
  double a = 0, fa = excess(0);
  if (found.status != ForceStatus::ok) return found;
  if (!std::isfinite(torque)) return refuse(ForceStatus::bad_argument);
  const double allowed = kTorque * (std::abs(torque) + c.load * c.wheel.outer_radius());
  if (std::abs(fa) <= allowed) return found;
  const double sign = fa < 0 ? 1 : -1;
  for (const double slip : kSlips) {
    const double b = sign * slip, fb = excess(b);
    if (found.status != ForceStatus::ok) return refuse(ForceStatus::torque_not_reached);  // too soft at this slip
    if (fa * fb > 0) {
      a = b;
      fa = fb;
      continue;
    }
    std::uintmax_t iterations = 60;
    const auto close = [&](double x, double y) { return std::abs(x - y) <= 1e-15; };
    const auto root = a < b ? boost::math::tools::toms748_solve(excess, a, b, fa, fb, close, iterations)
                            : boost::math::tools::toms748_solve(excess, b, a, fb, fa, close, iterations);
    const double miss = std::abs(excess(root.first));
    if (miss > allowed) excess(root.second);
    if (std::abs(-found.wrench.My - torque) > allowed)
      return refuse(ForceStatus::torque_not_reached);  // the torque jumps over it
    return found;
  }
  return refuse(ForceStatus::torque_not_reached);
}

}  // namespace grouser::bekker
