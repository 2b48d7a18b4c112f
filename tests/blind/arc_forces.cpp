#include "arc_forces.h"

#include <algorithm>
#include <array>
#include <boost/math/constants/constants.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <vector>

namespace blind {
namespace {

constexpr int kHalf = 22, kPoints = 2 * kHalf + 1, kMost = 512;

struct Rule {
  std::array<double, kPoints> x{}, w{};  // on [-1, 1]
};

// x = tanh(pi/2 sinh t): trapezoids in t converge exponentially even where the integrand ends in a root.
const Rule& double_exponential() {
  static const Rule rule = [] {
    Rule out;
    const double step = 3.1 / kHalf, half_pi = boost::math::constants::half_pi<double>();
    for (int i = -kHalf; i <= kHalf; ++i) {
      const double t = step * i, u = half_pi * std::sinh(t), e = std::cosh(u);
      out.x[static_cast<std::size_t>(i + kHalf)] = std::tanh(u);
      out.w[static_cast<std::size_t>(i + kHalf)] = step * half_pi * std::cosh(t) / (e * e);
    }
    return out;
  }();
  return rule;
}

struct Arc {
  const Stress& s;
  double entry, mid, rear, plate;
};

// Depth ahead of theta_m r (cos theta - cos theta_f); behind it the same at theta_e = theta_f - (theta - theta_r)
// stretch.
void add_points(const Arc& arc, bool behind, int count, const double* theta, const double* weight, Sums& out) {
  const Stress& s = arc.s;
  std::array<double, kMost> sigma{}, tau{};
  const double slope = behind ? -(arc.entry - arc.mid) / (arc.mid - arc.rear) : 1.0;
  const double shift = behind ? arc.entry - slope * arc.rear : 0.0;
  const double least = 1e-300, per_width = s.radius / s.reference_width, cos_entry = std::cos(arc.entry),
               scale = s.k * arc.plate;
  for (int i = 0; i < count; ++i) {
    const double depth = std::max(per_width * (std::cos(slope * theta[i] + shift) - cos_entry), least);
    const double pan = std::max(1.0 - depth * s.reference_width * s.inverse_pan_depth, 1e-9);
    sigma[static_cast<std::size_t>(i)] = scale * std::exp(s.n * std::log(depth)) / pan;
  }
  const double travel_speed = s.travel * s.omega;
  if (s.pressure_rate != 0) {
    for (int i = 0; i < count; ++i) {
      const double v = std::max(travel_speed * std::sin(theta[i]), kRateFloor);
      sigma[static_cast<std::size_t>(i)] *= std::exp(s.pressure_rate * std::log(v / kRateSpeed));
    }
  }
  const double middle = 0.5 * (theta[0] + theta[count - 1]), sin_entry = std::sin(arc.entry);
  const double sense = s.lever - s.travel * std::cos(middle) < 0 ? -1.0 : 1.0;
  for (int i = 0; i < count; ++i) {
    const double j = std::abs(s.lever * (arc.entry - theta[i]) - s.travel * (sin_entry - std::sin(theta[i])));
    const double rise = 1.0 - std::exp(-j / s.K), residual = 1.0 + s.residual * std::exp(-j / kResidualLength);
    const auto at = static_cast<std::size_t>(i);
    tau[at] = sense * (s.c + sigma[at] * s.tan_phi) * rise * residual;
  }
  if (s.shear_rate != 0) {
    for (int i = 0; i < count; ++i) {
      const double v = std::max(std::abs(s.omega * s.lever - travel_speed * std::cos(theta[i])), kRateFloor);
      tau[static_cast<std::size_t>(i)] *= 1.0 + s.shear_rate * std::log(v / kRateSpeed);
    }
  }
  double fx = 0, fz = 0, torque = 0;
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double c = std::cos(theta[i]), q = std::sin(theta[i]), p = s.radius * sigma[at], t = s.lever * tau[at];
    fx += weight[i] * (t * c - p * q);
    fz += weight[i] * (p * c + t * q);
    torque += weight[i] * t;
  }
  out.fx += s.width * fx;
  out.fz += s.width * fz;
  out.torque += s.lever * s.width * torque;
}

// Angle below the entry at which |j| has grown to `length`; to first order in the angle where the wheel slides, second
// where it does not.
double layer_end(double lever, double travel, double entry, double length) {
  const double a = lever - travel * std::cos(entry), b = travel * std::sin(entry);
  if (a < 0) return entry - length / -a;
  return entry - 2.0 * length / (a + std::sqrt(a * a + 2.0 * b * length));
}

std::vector<double> cuts_of(const Arc& arc) {
  const Stress& s = arc.s;
  std::vector<double> cuts{arc.rear, arc.mid, arc.entry};
  const auto cut = [&](double theta) {
    if (theta > arc.rear + 1e-9 && theta < arc.entry - 1e-9) cuts.push_back(theta);
  };
  if (s.travel > s.lever) {
    const double turn = std::acos(s.lever / s.travel);
    cut(turn);
    cut(-turn);
    const auto g = [&](double t) { return s.lever * (arc.entry - t) - s.travel * (std::sin(arc.entry) - std::sin(t)); };
    const double low = std::max(arc.rear, -turn), high = std::min(turn, arc.entry);
    if (high < arc.entry && g(high) > 0 && g(low) < 0) {
      std::uintmax_t steps = 60;
      const auto root =
          boost::math::tools::toms748_solve(g, low, high, boost::math::tools::eps_tolerance<double>(40), steps);
      cut(0.5 * (root.first + root.second));
    }
  }
  cut(layer_end(s.lever, s.travel, arc.entry, 12.0 * s.K));
  const double travel_speed = s.travel * s.omega;
  if (s.pressure_rate != 0 && travel_speed > kRateFloor) cut(std::asin(kRateFloor / travel_speed));
  if (s.shear_rate != 0 && travel_speed > 0) {
    for (const double side : {-kRateFloor, kRateFloor}) {
      const double c = (s.omega * s.lever + side) / travel_speed;
      if (std::abs(c) < 1) {
        cut(std::acos(c));
        cut(-std::acos(c));
      }
    }
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

}  // namespace

double sinkage(const Stress& s, double entry) {
  const double h = std::sin(0.5 * entry);
  return 2.0 * s.radius * h * h;
}

Sums arc_sums(const Stress& s, double entry, int cells) {
  Arc arc{s, entry, s.mid_share * entry, -s.rear_share * entry, 1.0};
  if (s.plate_exponent != 0) {
    arc.plate = std::exp(-s.plate_exponent * std::log(s.radius * std::sin(entry) / kPlateLength));
  }
  Sums out;
  std::array<double, kMost> theta{}, weight{};
  if (cells > 0) {
    cells = std::min(cells, kMost);
    for (const bool behind : {true, false}) {
      const double low = behind ? arc.rear : arc.mid, high = behind ? arc.mid : entry, step = (high - low) / cells;
      for (int i = 0; i < cells; ++i) {
        theta[0] = low + (i + 0.5) * step;
        weight[0] = step;
        add_points(arc, behind, 1, theta.data(), weight.data(), out);
      }
    }
    return out;
  }
  const Rule& rule = double_exponential();
  const std::vector<double> cuts = cuts_of(arc);
  for (std::size_t p = 1; p < cuts.size(); ++p) {
    const double half = 0.5 * (cuts[p] - cuts[p - 1]), centre = 0.5 * (cuts[p] + cuts[p - 1]);
    if (half < 1e-12) continue;
    for (std::size_t i = 0; i < kPoints; ++i) {
      theta[i] = centre + half * rule.x[i];
      weight[i] = half * rule.w[i];
    }
    add_points(arc, centre < arc.mid, kPoints, theta.data(), weight.data(), out);
  }
  return out;
}

}  // namespace blind
