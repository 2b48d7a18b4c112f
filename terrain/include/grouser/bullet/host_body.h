#pragma once
// One wheel as Bullet holds it: a btRigidBody, or a link of a btMultiBody.
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <vector>

#include "grouser/bullet/axes.h"

namespace grouser::bullet {

/// Joint-space rows of a link: row i of `jacobian` gives component i of the link's twist (x, y, z, rx, ry, rz in Bullet's world, about
/// the link's centre of mass); column i of `response` is the change of the joint velocities under a unit impulse of that component.
struct LinkRows {
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;
  Eigen::Matrix<double, Eigen::Dynamic, 6> response;
};

class HostBody {
 public:
  explicit HostBody(btRigidBody& b) : rigid_(&b) {}
  HostBody(btMultiBody& b, int link) : multi_(&b), link_(link) {}

  btRigidBody* rigid() const { return rigid_; }
  btMultiBody* multi() const { return multi_; }

  Pose pose_W(const Axes& axes) const {
    if (rigid_) return axes.pose_W(rigid_->getCenterOfMassTransform());
    // The link's cached world transform is only as fresh as its last drawing: ask for the frame itself.
    const btMatrix3x3 R = link_ < 0 ? btMatrix3x3(multi_->getWorldToBaseRot().inverse())
                                    : multi_->localFrameToWorld(link_, btMatrix3x3::getIdentity());
    return axes.pose_W(btTransform(R, origin()));
  }

  Twist twist_W(const Axes& axes) const {
    if (rigid_) return {axes.to_W(rigid_->getLinearVelocity()), axes.to_W(rigid_->getAngularVelocity())};
    Twist V;
    std::vector<btScalar> jac(dofs());
    for (int i = 0; i < 6; ++i) {
      fill_jacobian(i, jac.data());
      double s = 0;
      for (std::size_t k = 0; k < jac.size(); ++k) s += static_cast<double>(jac[k] * multi_->getVelocityVector()[k]);
      (i < 3 ? V.v : V.w)[i % 3] = s;
    }
    const Mat3 R = axes.matrix();
    return {R * V.v, R * V.w};
  }

  /// Mass of the body alone [kg]; 0 = it does not answer to impulses.
  double own_mass() const {
    if (rigid_) return rigid_->getInvMass() > 0 ? 1.0 / static_cast<double>(rigid_->getInvMass()) : 0.0;
    return static_cast<double>(link_ < 0 ? multi_->getBaseMass() : multi_->getLinkMass(link_));
  }
  /// Rotational inertia of the body alone about its origin, in W [kg m^2]; zero where it does not turn.
  Mat3 own_inertia_W(const Axes& axes) const {
    btVector3 I;
    if (rigid_)
      I = rigid_->getLocalInertia();
    else
      I = link_ < 0 ? multi_->getBaseInertia() : multi_->getLinkInertia(link_);
    const Mat3 R = pose_W(axes).q.toRotationMatrix();
    const Vec3 d(static_cast<double>(I.x()), static_cast<double>(I.y()), static_cast<double>(I.z()));
    return R * d.asDiagonal() * R.transpose();
  }

  /// Impulse f [N s] and angular impulse t [N m s] about the body's origin, in W.
  void apply(const Axes& axes, const Vec3& f, const Vec3& t, const LinkRows* rows) const {
    if (rigid_) {
      rigid_->applyCentralImpulse(axes.from_W(f));
      rigid_->applyTorqueImpulse(axes.from_W(t));
      return;
    }
    const Mat3 R = axes.matrix();
    Eigen::Matrix<double, 6, 1> J;
    J << R.transpose() * f, R.transpose() * t;
    const Eigen::VectorXd dv = rows->response * J;
    std::vector<btScalar> delta(dofs());
    for (std::size_t k = 0; k < delta.size(); ++k) delta[k] = static_cast<btScalar>(dv[static_cast<Eigen::Index>(k)]);
    multi_->applyDeltaVeeMultiDof(delta.data(), btScalar(1));
  }

  /// Joint-space rows at the present configuration. The mass matrix is that of the last solve (Bullet's cache, half a step old).
  LinkRows rows() const {
    LinkRows r;
    const auto n = static_cast<Eigen::Index>(dofs());
    r.jacobian.resize(6, n);
    r.response.resize(n, 6);
    std::vector<btScalar> jac(dofs()), out(dofs());
    btAlignedObjectArray<btScalar> sr;
    btAlignedObjectArray<btVector3> sv;
    for (int i = 0; i < 6; ++i) {
      fill_jacobian(i, jac.data());
      multi_->calcAccelerationDeltasMultiDof(jac.data(), out.data(), sr, sv);
      for (Eigen::Index k = 0; k < n; ++k) {
        r.jacobian(i, k) = static_cast<double>(jac[static_cast<std::size_t>(k)]);
        r.response(k, i) = static_cast<double>(out[static_cast<std::size_t>(k)]);
      }
    }
    return r;
  }

  /// Bullet puts slow bodies to sleep after 2 s, and a sleeping body ignores soil that moves or a slope it creeps on.
  void keep_awake() const {
    if (rigid_) {
      rigid_->activate(true);
      return;
    }
    multi_->wakeUp();
    if (auto* c = multi_->getBaseCollider()) c->activate(true);
    if (auto* c = multi_->getLinkCollider(link_)) c->activate(true);
  }

  const btCollisionObject* collision_object() const {
    if (rigid_) return rigid_;
    return link_ < 0 ? multi_->getBaseCollider() : multi_->getLinkCollider(link_);
  }

 private:
  std::size_t dofs() const { return 6u + static_cast<std::size_t>(multi_->getNumDofs()); }
  btVector3 origin() const {
    return link_ < 0 ? multi_->getBasePos() : multi_->localPosToWorld(link_, btVector3(0, 0, 0));
  }
  void fill_jacobian(int component, btScalar* jac) const {
    btVector3 lin(0, 0, 0), ang(0, 0, 0);
    (component < 3 ? lin : ang)[component % 3] = 1;
    btAlignedObjectArray<btScalar> sr;
    btAlignedObjectArray<btVector3> sv;
    btAlignedObjectArray<btMatrix3x3> sm;
    multi_->fillConstraintJacobianMultiDof(link_, origin(), ang, lin, jac, sr, sv, sm);
  }

  btRigidBody* rigid_ = nullptr;
  btMultiBody* multi_ = nullptr;
  int link_ = -1;
};

}  // namespace grouser::bullet
