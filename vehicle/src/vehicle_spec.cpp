#include "grouser/vehicle/vehicle_spec.h"

#include <algorithm>
#include <cmath>

namespace grouser::vehicle {

double MotorSpec::limit(double w, double sign) const {
  // Against the motion (and at rest) the standstill value holds.
  if (w * sign <= 0) return torque.front();
  const double a = std::abs(w);
  if (a >= speed.back()) return speed.size() == 1 ? torque.back() : 0.0;
  const auto it = std::upper_bound(speed.begin(), speed.end(), a);
  const auto i = static_cast<std::size_t>(it - speed.begin());
  const double u = (a - speed[i - 1]) / (speed[i] - speed[i - 1]);
  return torque[i - 1] + u * (torque[i] - torque[i - 1]);
}

double VehicleSpec::total_mass() const {
  double m = 0;
  for (const LinkSpec& l : links) m += l.mass;
  return m;
}

Vec3 VehicleSpec::centre_of_mass_V() const {
  Vec3 c = Vec3::Zero();
  for (const LinkSpec& l : links) c += l.mass * l.X_VB.p;
  return c / total_mass();
}

double VehicleSpec::track() const {
  double left = 0, right = 0;
  int nl = 0, nr = 0;
  for (const WheelSpec& w : wheels) {
    const double y = links[w.link].X_VB.p.y();
    (w.left ? left : right) += y;
    ++(w.left ? nl : nr);
  }
  return nl && nr ? left / nl - right / nr : 0.0;
}

double VehicleSpec::wheelbase() const {
  double lo = 1e30, hi = -1e30;
  for (const WheelSpec& w : wheels) {
    lo = std::min(lo, links[w.link].X_VB.p.x());
    hi = std::max(hi, links[w.link].X_VB.p.x());
  }
  return wheels.empty() ? 0.0 : hi - lo;
}

namespace {
/// Parallel axes: inertia of a point mass m at r.
Mat3 point_inertia(double m, const Vec3& r) { return m * (r.squaredNorm() * Mat3::Identity() - r * r.transpose()); }
}  // namespace

void merge_fixed(LinkSpec& a, const LinkSpec& b) {
  const double m = a.mass + b.mass;
  const Vec3 c_V = (a.mass * a.X_VB.p + b.mass * b.X_VB.p) / m;
  const Mat3 R_VA = a.X_VB.q.toRotationMatrix(), R_VB = b.X_VB.q.toRotationMatrix();
  const Mat3 I_V = R_VA * a.inertia * R_VA.transpose() + point_inertia(a.mass, a.X_VB.p - c_V) +
                   R_VB * b.inertia * R_VB.transpose() + point_inertia(b.mass, b.X_VB.p - c_V);
  const Pose old_VA = a.X_VB;
  a.mass = m;
  a.X_VB.p = c_V;
  a.inertia = R_VA.transpose() * I_V * R_VA;
  for (Visual& s : a.visuals) s.X_BS = a.X_VB.inverse() * (old_VA * s.X_BS);
  for (Visual s : b.visuals) {
    s.X_BS = a.X_VB.inverse() * (b.X_VB * s.X_BS);
    a.visuals.push_back(s);
  }
}

Mat3 box_inertia(double m, const Vec3& s) {
  return Vec3(s.y() * s.y() + s.z() * s.z(), s.x() * s.x() + s.z() * s.z(), s.x() * s.x() + s.y() * s.y())
             .asDiagonal() *
         Mat3(Mat3::Identity() * (m / 12));
}

Mat3 cylinder_inertia(double m, double r, double length) {
  const double across = m * (3 * r * r + length * length) / 12;
  return Mat3(Vec3(across, 0.5 * m * r * r, across).asDiagonal());
}

}  // namespace grouser::vehicle
