#pragma once
// What a unit impulse on one wheel does to the twist of every wheel once Bullet's joints have been solved.
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "grouser/bullet/host_body.h"
#include "grouser/bullet/implicit_step.h"
#include "grouser/terrain/state.h"

namespace grouser::bullet {

/// Wheels that feel each other through joints (or that are links of one btMultiBody), with their mobility
///
///   W = E^T [ M^-1 - M^-1 G^T (G M^-1 G^T)^-1 G M^-1 ] E                                                                  (2)
///
/// M: masses of the bodies reached through joints; G: Jacobian of the joint rows that hold; E picks the wheels. A joint row holds when
/// it has no impulse limit (hinge, slider, fixed) or when it is a motor that is not saturated: satisfying it would take less than 5 % of
/// its limit. One-sided rows (stops), saturated motors, soft springs and collisions are left out: their reaction is taken from the last
/// step instead. Rows come from the constraints themselves (getInfo1/getInfo2, what Bullet's solver asks for), so every constraint
/// type, also a user's own, is served. Links of a btMultiBody: joint space, exact; its btMultiBodyConstraints are left out.
struct WheelGroup {
  std::vector<std::size_t> wheels;
  std::vector<btRigidBody*> bodies;
  std::vector<btTypedConstraint*> joints;
  btMultiBody* multi = nullptr;
  Eigen::MatrixXd W;           ///< 6n x 6n, frame W, order (x, y, z, rx, ry, rz) per wheel
  std::vector<LinkRows> rows;  ///< multibody only: one per wheel
};

class Mobility {
 public:
  /// refresh: rigid groups get a new W every so many steps (1 = each); multibodies each step, because they need their rows anyway.
  Mobility(btDiscreteDynamicsWorld& world, const Axes& axes, int refresh)
      : world_(world), axes_(axes), refresh_(refresh) {}

  /// Groups with W for the present configuration, or one up to `refresh` steps old. dt: the step [s].
  const std::vector<WheelGroup>& update(const std::vector<HostBody>& hosts, double dt) {
    if (topology_changed(hosts)) {
      build_groups(hosts);
      age_ = 0;
    }
    for (WheelGroup& g : groups_) {
      if (g.multi)
        update_multi(g, hosts);
      else if (age_ == 0)
        update_rigid(g, hosts, dt);
    }
    age_ = (age_ + 1) % refresh_;
    return groups_;
  }

  /// W is state as long as it is not computed afresh in each step.
  void traverse(State& s, const std::vector<HostBody>& hosts) {
    if (topology_changed(hosts)) build_groups(hosts);  // also when saved before the first step
    s.field("age", age_);
    for (WheelGroup& g : groups_) {
      std::vector<double> w(g.W.data(), g.W.data() + g.W.size());
      s.field("W", w);
      const auto n = static_cast<Eigen::Index>(6 * g.wheels.size());
      if (w.empty()) continue;  // saved before the first step
      if (static_cast<Eigen::Index>(w.size()) != n * n) throw StateError("mobility of a wheel group has another size");
      g.W = Eigen::Map<const Eigen::MatrixXd>(w.data(), n, n);
    }
  }

 private:
  struct Row {
    std::array<btScalar, 4> linear_a, angular_a, linear_b, angular_b;
    btScalar error, cfm, lower, upper;
  };
  static constexpr int row_skip = sizeof(Row) / sizeof(btScalar);

  static bool dynamic(const btRigidBody& b) { return b.getInvMass() > 0; }

  bool topology_changed(const std::vector<HostBody>& hosts) {
    bool changed = hosts.size() != host_count_ || static_cast<std::size_t>(world_.getNumConstraints()) != seen_.size();
    for (std::size_t i = 0; !changed && i < seen_.size(); ++i) {
      const btTypedConstraint* c = world_.getConstraint(static_cast<int>(i));
      changed = c != seen_[i].first || c->isEnabled() != seen_[i].second;
    }
    for (std::size_t i = 0; !changed && i < hosts.size(); ++i)
      changed = hosts[i].rigid() && dynamic(*hosts[i].rigid()) != was_dynamic_[i];
    return changed;
  }

  void build_groups(const std::vector<HostBody>& hosts) {
    host_count_ = hosts.size();
    seen_.clear();
    for (int i = 0; i < world_.getNumConstraints(); ++i)
      seen_.emplace_back(world_.getConstraint(i), world_.getConstraint(i)->isEnabled());
    was_dynamic_.assign(hosts.size(), false);
    for (std::size_t i = 0; i < hosts.size(); ++i) was_dynamic_[i] = hosts[i].rigid() && dynamic(*hosts[i].rigid());

    groups_.clear();
    std::vector<bool> placed(hosts.size(), false);
    for (std::size_t i = 0; i < hosts.size(); ++i) {
      if (placed[i]) continue;
      WheelGroup g;
      if (hosts[i].multi()) {
        g.multi = hosts[i].multi();
        for (std::size_t k = i; k < hosts.size(); ++k)
          if (hosts[k].multi() == g.multi) g.wheels.push_back(k);
      } else {
        g.bodies.push_back(hosts[i].rigid());
        if (dynamic(*hosts[i].rigid())) reach(g);
        for (std::size_t k = i; k < hosts.size(); ++k)
          if (hosts[k].rigid() && index(g, hosts[k].rigid()) >= 0) g.wheels.push_back(k);
      }
      for (const std::size_t k : g.wheels) placed[k] = true;
      groups_.push_back(std::move(g));
    }
  }

  /// Every dynamic body that enabled joints connect to those already in the group.
  void reach(WheelGroup& g) const {
    std::vector<bool> taken(seen_.size(), false);
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t i = 0; i < seen_.size(); ++i) {
        if (taken[i] || !seen_[i].second) continue;
        btTypedConstraint* c = seen_[i].first;
        btRigidBody *a = &c->getRigidBodyA(), *b = &c->getRigidBodyB();
        if (index(g, a) < 0 && index(g, b) < 0) continue;
        taken[i] = grown = true;
        g.joints.push_back(c);
        for (btRigidBody* body : {a, b})
          if (dynamic(*body) && index(g, body) < 0) g.bodies.push_back(body);
      }
    }
  }

  static Eigen::Index index(const WheelGroup& g, const btRigidBody* b) {
    const auto it = std::find(g.bodies.begin(), g.bodies.end(), b);
    return it == g.bodies.end() ? -1 : static_cast<Eigen::Index>(it - g.bodies.begin());
  }

  void update_rigid(WheelGroup& g, const std::vector<HostBody>& hosts, double dt) {
    const auto nb = static_cast<Eigen::Index>(g.bodies.size());
    inverse_mass_.assign(g.bodies.size(), Mat6::Zero());
    for (Eigen::Index i = 0; i < nb; ++i) {
      const btRigidBody& b = *g.bodies[static_cast<std::size_t>(i)];
      Mat6& m = inverse_mass_[static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k) {
        m(k, k) = static_cast<double>(b.getInvMass() * b.getLinearFactor()[k]);
        for (int l = 0; l < 3; ++l)
          m(3 + k, 3 + l) = static_cast<double>(b.getAngularFactor()[k] * b.getInvInertiaTensorWorld()[k][l]);
      }
    }
    joint_rows(g, dt);

    std::vector<Eigen::Index> body;
    for (const std::size_t k : g.wheels) body.push_back(index(g, hosts[k].rigid()));
    g.W = joint_mobility(inverse_mass_, G_, cfm_, body);
    if (axes_.y_up()) g.W = rotate_blocks(g.W, axes_.matrix());
  }

  /// Joint rows that hold, as the dense G of eq 2 (frame of the Bullet world) and their softness.
  void joint_rows(const WheelGroup& g, double dt) {
    std::vector<std::vector<double>> kept;
    std::vector<double> cfm;
    const btContactSolverInfo& solver = world_.getSolverInfo();
    const std::size_t size = 6 * g.bodies.size();
    for (btTypedConstraint* joint : g.joints) {
      joint->buildJacobian();
      btTypedConstraint::btConstraintInfo1 info1{};
      joint->getInfo1(&info1);
      if (info1.m_numConstraintRows <= 0) continue;
      scratch_.assign(static_cast<std::size_t>(info1.m_numConstraintRows), Row{});
      for (Row& r : scratch_) {
        r.lower = -SIMD_INFINITY;
        r.upper = SIMD_INFINITY;
      }
      Row& first = scratch_.front();
      first.cfm = solver.m_globalCfm;
      btTypedConstraint::btConstraintInfo2 info2{};
      info2.fps = static_cast<btScalar>(1.0 / dt);
      info2.erp = solver.m_erp;
      info2.m_J1linearAxis = first.linear_a.data();
      info2.m_J1angularAxis = first.angular_a.data();
      info2.m_J2linearAxis = first.linear_b.data();
      info2.m_J2angularAxis = first.angular_b.data();
      info2.rowskip = row_skip;
      info2.m_constraintError = &first.error;
      info2.cfm = &first.cfm;
      info2.m_lowerLimit = &first.lower;
      info2.m_upperLimit = &first.upper;
      info2.m_numIterations = solver.m_numIterations;
      info2.m_damping = solver.m_damping;
      joint->getInfo2(&info2);

      const Eigen::Index a = index(g, &joint->getRigidBodyA()), b = index(g, &joint->getRigidBodyB());
      for (const Row& r : scratch_) {
        std::vector<double> row(size, 0.0);
        for (int k = 0; k < 3; ++k) {
          const auto i = static_cast<std::size_t>(k);
          if (a >= 0) {
            row[6 * static_cast<std::size_t>(a) + i] = static_cast<double>(r.linear_a[i]);
            row[6 * static_cast<std::size_t>(a) + 3 + i] = static_cast<double>(r.angular_a[i]);
          }
          if (b >= 0) {
            row[6 * static_cast<std::size_t>(b) + i] = static_cast<double>(r.linear_b[i]);
            row[6 * static_cast<std::size_t>(b) + 3 + i] = static_cast<double>(r.angular_b[i]);
          }
        }
        if (!holds(g, *joint, r, row)) continue;
        kept.push_back(std::move(row));
        cfm.push_back(static_cast<double>(r.cfm));
      }
    }
    G_.resize(static_cast<Eigen::Index>(kept.size()), static_cast<Eigen::Index>(size));
    cfm_.resize(static_cast<Eigen::Index>(kept.size()));
    for (std::size_t i = 0; i < kept.size(); ++i) {
      for (std::size_t c = 0; c < size; ++c)
        G_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = kept[i][c];
      cfm_[static_cast<Eigen::Index>(i)] = cfm[i];
    }
  }

  bool holds(const WheelGroup& g, const btTypedConstraint& joint, const Row& r, const std::vector<double>& row) const {
    double response = 0, speed = 0;  // G M^-1 G^T of this row, and G v now
    for (std::size_t i = 0; i < g.bodies.size(); ++i) {
      const double* j = &row[6 * i];
      for (int k = 0; k < 6; ++k)
        for (int l = 0; l < 6; ++l) response += j[k] * inverse_mass_[i](k, l) * j[l];
      const btVector3 &v = g.bodies[i]->getLinearVelocity(), &w = g.bodies[i]->getAngularVelocity();
      for (int k = 0; k < 3; ++k) speed += j[k] * static_cast<double>(v[k]) + j[3 + k] * static_cast<double>(w[k]);
    }
    if (!(response > 0)) return false;
    constexpr double unlimited =
        1e17;  // Bullet's infinity is FLT_MAX or DBL_MAX, and users write 1e18 and BT_LARGE_FLOAT
    const auto breaking = static_cast<double>(joint.getBreakingImpulseThreshold());
    const double up = std::min(static_cast<double>(r.upper), breaking),
                 down = std::max(static_cast<double>(r.lower), -breaking);
    if (up > unlimited && down < -unlimited) return true;
    const double limit = std::min(up, -down);
    if (!(limit > 0)) return false;
    return std::abs(static_cast<double>(r.error) - speed) / response < 0.05 * limit;
  }

  void update_multi(WheelGroup& g, const std::vector<HostBody>& hosts) const {
    g.rows.clear();
    for (const std::size_t k : g.wheels) g.rows.push_back(hosts[k].rows());
    const auto n = static_cast<Eigen::Index>(g.wheels.size());
    Eigen::MatrixXd W(6 * n, 6 * n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        W.block(6 * i, 6 * j, 6, 6).noalias() =
            g.rows[static_cast<std::size_t>(i)].jacobian * g.rows[static_cast<std::size_t>(j)].response;
    g.W = axes_.y_up() ? rotate_blocks(W, axes_.matrix()) : W;
  }

  btDiscreteDynamicsWorld& world_;
  Axes axes_;
  int refresh_, age_ = 0;
  std::size_t host_count_ = 0;
  std::vector<std::pair<btTypedConstraint*, bool>> seen_;
  std::vector<bool> was_dynamic_;
  std::vector<WheelGroup> groups_;
  std::vector<Mat6> inverse_mass_;
  std::vector<Row> scratch_;
  Eigen::MatrixXd G_;
  Eigen::VectorXd cfm_;
};

}  // namespace grouser::bullet
