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

struct Displacement {
  Stick end;
  Eigen::Matrix2d du_dv;  // d(end u)/dv / dt
  bool pressing = false;  // u is at y and takes y along
};

Displacement displace(const Stick& begin, const Vec2& v, double rho, double K, double dt) {
  Displacement r;
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
  r.pressing = true;
  const double dy = rest * (mean_decay(x) + outward * rest / K * mean_decay_slope(x) - start / K * left);
  const double radial = dy * whole / part / dt, turning = y / reach * whole / dt;
  const Eigen::Matrix2d along = direction * direction.transpose();
  r.du_dv = radial * along + turning * (Eigen::Matrix2d::Identity() - along);
  return r;
}

}  // namespace

StickStep advance(const Stick& begin, const Vec2& v, double rho, double K, double tau, double dt) {
  const Displacement d = displace(begin, v, rho, K, dt);
  const double y = d.end.y;
  const double lead = tau / (1 + rho * tau), share = 1 - rho * lead;  // less than 1/rho, else it could give energy
  // Where the disc y is smaller than 1 mm/s moves `felt`, damping is dry friction, which has no derivative at rest: there none is told.
  const double told = lead > 0 ? std::min(1.0, y / (lead * 1e-3)) : 0;
  StickStep r{d.end, share * d.end.u + lead * v, d.du_dv};
  r.dfelt_dv += told * (lead / dt * Eigen::Matrix2d::Identity() - rho * lead * d.du_dv);
  const double reach = r.felt.norm();
  if (reach <= y) return r;
  const Vec2 n = r.felt / reach;
  const Eigen::Matrix2d along = n * n.transpose();
  r.felt = y * n;
  r.dfelt_dv = (y / reach) * (Eigen::Matrix2d::Identity() - along) * r.dfelt_dv;
  if (d.pressing) r.dfelt_dv += n * (d.end.u / y).transpose() * d.du_dv;
  return r;
}

}  // namespace grouser::bekker
