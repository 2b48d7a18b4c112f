#include "profile.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>

namespace grouser::diagnosis {

std::array<double, 2> profile_interval(const Search& s, const Candidate& c, const Fit& f, std::size_t term) {
  const Eigen::Index p = s.series().soil_parameters(), at = p + static_cast<Eigen::Index>(term), rest = f.x.size() - 1;
  const Eigen::MatrixXd V = s.covariance(f);
  const double best = f.x[at], sd = std::sqrt(std::max(V(at, at), 1e-300));
  const double t = boost::math::quantile(boost::math::students_t(s.noise_dof(static_cast<double>(f.x.size()))), 0.95);
  Candidate held = c;
  held.terms.erase(held.terms.begin() + static_cast<std::ptrdiff_t>(term));
  held.held.push_back({c.terms[term].input, 0});
  const auto without = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd y(rest);
    y << x.head(at), x.tail(rest - at);
    return y;
  };
  const Eigen::VectorXd x0 = without(f.x), turn = without(V.col(at)) / V(at, at);
  std::array<double, 2> ends{};
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? -1 : 1, bound = side == 0 ? c.terms[term].lower : c.terms[term].upper;
    std::vector<double> theta = f.theta;
    Eigen::VectorXd start = x0;
    double from = best;
    // Root of the rise at an amplitude; NaN where the model has no answer.
    const auto rise = [&](double a) {
      held.held.back().value = a;
      const Fit g = s.series().fit(held, s.whitener(), start + turn * (a - from), theta, 8);
      if (!g.ok) return std::numeric_limits<double>::quiet_NaN();
      start = g.x, theta = g.theta, from = a;
      return std::sqrt(std::max(g.objective() - f.objective(), 0.0));
    };
    double low = 0, low_rise = 0, high = t * sd, high_rise = 0;  // distances from the best
    const double room = sign * (bound - best);
    bool closed = false;
    for (int k = 0; k < 8 && !closed; ++k) {
      const double reach = std::min(high, room);
      const double z = rise(best + sign * reach);
      if (std::isnan(z)) {
        high = 0.5 * (low + reach);
        continue;
      }
      if (z >= t || reach >= room) {
        high = reach, high_rise = z, closed = true;
      } else {
        low = reach, low_rise = z;
        high = reach * std::clamp(1.05 * t / std::max(z, 0.1), 1.2, 3.0);
      }
    }
    if (!closed || high_rise < t) {
      ends[static_cast<std::size_t>(side)] = closed ? bound : best + sign * high;
      continue;
    }
    for (int k = 0; k < 5 && std::abs(high_rise - t) > 0.02; ++k) {
      const double x = low + (high - low) * (t - low_rise) / (high_rise - low_rise), z = rise(best + sign * x);
      if (std::isnan(z)) break;
      (z >= t ? high : low) = x;
      (z >= t ? high_rise : low_rise) = z;
      if (std::abs(z - t) < 0.02) {
        high = x, high_rise = z;
        break;
      }
    }
    ends[static_cast<std::size_t>(side)] = best + sign * high;
  }
  return ends;
}

}  // namespace grouser::diagnosis
