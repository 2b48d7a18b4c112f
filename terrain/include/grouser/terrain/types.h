#pragma once
// Poses, twists and wrenches. World frame W: z up, x forward, y left (ISO 8855); SI units; radians.
// Unaligned Eigen types, so that a program compiled with other vector flags than the library still agrees on the layout.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace grouser {

using Vec2 = Eigen::Matrix<double, 2, 1, Eigen::DontAlign>;
using Vec3 = Eigen::Matrix<double, 3, 1, Eigen::DontAlign>;
using Vec6 = Eigen::Matrix<double, 6, 1, Eigen::DontAlign>;
using Mat3 = Eigen::Matrix<double, 3, 3, Eigen::DontAlign>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

inline constexpr double pi = 3.14159265358979323846;

/// Rigid transform X_AB: position p of B's origin in A [m] and rotation q of B in A. p_A = X_AB * p_B.
struct Pose {
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();
  Vec3 operator*(const Vec3& x) const { return p + q * x; }
  Pose operator*(const Pose& b) const { return {p + q * b.p, (q * b.q).normalized()}; }
  Pose inverse() const {
    const Quat c = q.conjugate();
    return {-(c * p), c};
  }
};

/// Velocity of a body: v of its origin [m/s], w angular [rad/s], both in W.
struct Twist {
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
  /// Velocity of the point at offset r [m, W] from the body's origin.
  Vec3 at(const Vec3& r) const { return v + w.cross(r); }
};

/// Force f [N] and torque t [N m] about the body's origin, both in W.
struct Wrench {
  Vec3 f = Vec3::Zero();
  Vec3 t = Vec3::Zero();
  Wrench& operator+=(const Wrench& o) {
    f += o.f;
    t += o.t;
    return *this;
  }
  /// Power on a body that moves with V [W].
  double power(const Twist& V) const { return f.dot(V.v) + t.dot(V.w); }
};

/// Wheel frame C (carrier axes without spin) of a body whose spin axis is y_W (unit): y_C = spin axis, x_C forward and
/// perpendicular to world z, z_C up in the wheel plane. Spin axis must not be vertical.
inline Mat3 carrier_axes(const Vec3& y_W) {
  Mat3 R;
  const Vec3 x = y_W.cross(Vec3::UnitZ()).normalized();
  R.col(0) = x;
  R.col(1) = y_W;
  R.col(2) = x.cross(y_W);
  return R;
}

}  // namespace grouser
