#include "stick.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker {

namespace {

/// (1 - exp(-x))/x and its derivative.
double mean_decay(double x) { return x > 1e-8 ? -std::expm1(-x) / x : 1 - 0.5 * x; }
double mean_decay_slope(double x) { return x > 1e-4 ? (std::exp(-x) - mean_decay(x)) / x : -0.5 + x / 3; }

/// Way s >= 0 with |u + s v| = y, for |u| <= y.
double way_to(const Vec2& u, const Vec2& v, double y) {
  const double a = v.squaredNorm(), b = u.dot(v), c = std::min(u.squaredNorm() - y * y, 0.0);
  const double root = std::sqrt(b * b - a * c);
  if (!(root > 0)) return 0;
  return b > 0 ? -c / (b + root) : (root - b) / a;
}

}  // namespace

StickStep advance(const Stick& begin, const Vec2& v, double rho, double K, double dt) {
  StickStep r;
  const double keep = std::exp(-rho * dt), whole = dt * mean_decay(rho * dt);
  const Vec2 trial = begin.u * keep + v * whole;
  const double reach = trial.norm(), edge = begin.y * keep;
  if (reach <= edge) {
    r.end = {trial, edge};
    r.du_dv = (whole / dt) * Eigen::Matrix2d::Identity();
    return r;
  }
  // With exp(rho t) taken out, u moves straight: it meets y after the way s = (exp(rho t) - 1)/rho.
  const double s = std::min(way_to(begin.u, v, begin.y), whole / keep);
  const double t = std::min(rho * s > 1e-8 ? std::log1p(rho * s) / rho : s, dt), rest = dt - t;
  const double start = begin.y * std::exp(-rho * t), part = std::max(rest * mean_decay(rho * rest), 1e-9 * whole);
  const double outward = (reach - edge) / part;  // speed at which |u| would grow
  const double x = (rho + outward / K) * rest, left = std::exp(-x);
  const double y = std::min(start * left + outward * rest * mean_decay(x), K);
  const Vec2 direction = trial / reach;
  r.end = {y * direction, y};
  const double dy = rest * (mean_decay(x) + outward * rest / K * mean_decay_slope(x) - start / K * left);
  const double radial = dy * whole / part / dt, turning = y / reach * whole / dt;
  const Eigen::Matrix2d along = direction * direction.transpose();
  r.du_dv = radial * along + turning * (Eigen::Matrix2d::Identity() - along);
  return r;
}

}  // namespace grouser::bekker
