#include "grouser/terrain/wheel_motion.h"

#include <cmath>

namespace grouser {

namespace {
Mat3 cross_matrix(const Vec3& r) {
  Mat3 S;
  S << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return S;
}
}  // namespace

WheelMotion wheel_motion(const BodySpec& body, const BodyMotion& motion, double radius, double width) {
  WheelMotion w;
  const Pose X_WG = motion.X_WB_end * body.X_BG;
  w.pose = {X_WG.p, X_WG.q * Vec3::UnitY(), radius, width};
  if (std::hypot(w.pose.axis_W.x(), w.pose.axis_W.y()) < 1e-6)
    throw TerrainError("spin axis of body '" + body.name +
                       "' is vertical: a wheel lying on its side has no contact law");
  w.lever_W = X_WG.p - motion.X_WB_end.p;
  w.V = {motion.V_WB_end.at(w.lever_W), motion.V_WB_end.w};
  w.spin = w.V.w.dot(w.pose.axis_W);
  w.carrier = carrier_axes(w.pose.axis_W);
  return w;
}

void clear_result(BodyResult& result) {
  result.impulse.setZero();
  result.angular_impulse.setZero();
  result.linearisation.reset();
  result.report = {};
}

void fill_result(const WheelMotion& wheel, const ContactPatch& patch, const Wrench& about_hub, const Mat6& K,
                 const Mat6& D, double dt, BodyResult& result) {
  result.impulse = dt * about_hub.f;
  result.angular_impulse = dt * (about_hub.t + wheel.lever_W.cross(about_hub.f));
  // V_hub = J V_body, so K_body = J^T K J.
  Mat6 J = Mat6::Identity();
  J.topRightCorner<3, 3>() = -cross_matrix(wheel.lever_W);
  Linearisation& L = result.linearisation.emplace();
  if (wheel.lever_W.isZero(0)) {
    L.dF_dx = K;
    L.dF_dv = D;
  } else {
    L.dF_dx.noalias() = J.transpose() * K * J;
    L.dF_dv.noalias() = J.transpose() * D * J;
  }
  ContactReport& r = result.report;
  r.in_contact = true;
  r.sinkage = patch.sinkage;
  r.entry_angle = patch.angle;
  r.normal_force = about_hub.f.dot(wheel.carrier.col(2));
  r.drawbar_pull = about_hub.f.dot(wheel.carrier.col(0));
  r.side_force = about_hub.f.dot(wheel.carrier.col(1));
  r.driving_torque = -about_hub.t.dot(wheel.carrier.col(1));
  r.point_W = patch.point_W;
  r.force_W = about_hub.f;
}

Slip slip_of(double rw, double vx, double vy, double still) {
  const double speed = std::max(std::abs(rw), std::abs(vx));
  Slip s;
  if (speed > still) s.slip = (rw - vx) / speed;
  if (std::hypot(vx, vy) > still) s.angle = std::atan2(vy, std::abs(vx));
  return s;
}

}  // namespace grouser
