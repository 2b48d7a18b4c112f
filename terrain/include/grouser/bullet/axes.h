#pragma once
// Between a Bullet world (single or double precision, z up or y up) and grouser's world W (z up, double).
#include <LinearMath/btTransform.h>

#include "grouser/terrain/types.h"

namespace grouser::bullet {

/// Which axis of the Bullet world points up.
enum class UpAxis { z, y };

/// Rotation from the Bullet world to W. z up: identity. y up: x_W = x, y_W = -z, z_W = y (a proper rotation, +90 degrees about x).
/// Only the world is mapped: the axes of a body stay what they are in Bullet, so X_BG is given in Bullet's body frame.
class Axes {
 public:
  explicit Axes(UpAxis up = UpAxis::z) : y_up_(up == UpAxis::y) {}

  bool y_up() const { return y_up_; }
  Vec3 to_W(const btVector3& v) const {
    const auto x = static_cast<double>(v.x()), y = static_cast<double>(v.y()), z = static_cast<double>(v.z());
    return y_up_ ? Vec3(x, -z, y) : Vec3(x, y, z);
  }
  btVector3 from_W(const Vec3& v) const {
    const Vec3 b = y_up_ ? Vec3(v.x(), v.z(), -v.y()) : v;
    return {static_cast<btScalar>(b.x()), static_cast<btScalar>(b.y()), static_cast<btScalar>(b.z())};
  }
  /// Rotation matrix from Bullet's world to W.
  Mat3 matrix() const {
    Mat3 R = Mat3::Identity();
    if (y_up_) R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    return R;
  }
  Pose pose_W(const btTransform& X) const {
    Pose p = pose(X);
    p.p = to_W(X.getOrigin());
    if (y_up_) p.q = Quat(matrix()) * p.q;
    return p;
  }
  /// A transform without change of axes (X_BG).
  static Pose pose(const btTransform& X) {
    const btQuaternion q = X.getRotation();
    Pose p;
    p.p = {static_cast<double>(X.getOrigin().x()), static_cast<double>(X.getOrigin().y()),
           static_cast<double>(X.getOrigin().z())};
    p.q = Quat(static_cast<double>(q.w()), static_cast<double>(q.x()), static_cast<double>(q.y()),
               static_cast<double>(q.z()))
              .normalized();
    return p;
  }

 private:
  bool y_up_;
};

}  // namespace grouser::bullet
