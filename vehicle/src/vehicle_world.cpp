#include "grouser/vehicle/vehicle_world.h"

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "grouser/bullet/terrain_action.h"
#include "joint_solver.h"

namespace grouser::vehicle {

namespace {

btVector3 bt(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 from(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btTransform bt(const Pose& X) { return btTransform(btQuaternion(X.q.x(), X.q.y(), X.q.z(), X.q.w()), bt(X.p)); }

/// Any unit vector across `a`, the same one every time.
Vec3 across(const Vec3& a) {
  const Vec3 other = std::abs(a.z()) < 0.9 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitX());
  return other.cross(a).normalized();
}

/// Right-handed frame whose column `k` is the axis.
Mat3 axis_frame(const Vec3& axis, int k) {
  Mat3 R;
  const Vec3 u = across(axis);
  R.col(k) = axis;
  R.col((k + 1) % 3) = u;
  R.col((k + 2) % 3) = axis.cross(u);
  return R;
}

/// Body as Bullet holds it. P: principal axes, origin at the centre of mass.
struct Body {
  std::unique_ptr<btRigidBody> rigid;
  Quat q_BP = Quat::Identity();
  btVector3 inertia;  // principal
  btVector3 v, w;     // after the last solve, before the soil's impulse
};

struct Joint {
  std::unique_ptr<btTypedConstraint> constraint;
  btJointFeedback feedback;
  Body *a = nullptr, *b = nullptr;  // parent, child
  btVector3 anchor_a, anchor_b;     // body frames P
  btVector3 axis_a, across_a, across_b;
  // At the beginning of the step:
  btVector3 axis, r_a, r_b;  // W; r: from the centres to the child's anchor
  double q = 0, rate = 0;
  double spring = 0, damper = 0, drive = 0;  // [N] or [N m] along q
};

/// No pairs are ever looked for: keep Bullet's pools small, since the world is rebuilt at each checkpoint.
btDefaultCollisionConstructionInfo small_pools() {
  btDefaultCollisionConstructionInfo c;
  c.m_defaultMaxPersistentManifoldPoolSize = 1;
  c.m_defaultMaxCollisionAlgorithmPoolSize = 1;
  return c;
}

/// Called after Bullet's solve and integration and before the terrain.
struct AfterSolve : btActionInterface {
  std::function<void()> f;
  void updateAction(btCollisionWorld*, btScalar) override { f(); }
  void debugDraw(btIDebugDraw*) override {}
};

}  // namespace

struct VehicleWorld::Impl {
  VehicleSpec spec;
  WorldOptions options;
  std::shared_ptr<Terrain> terrain;

  btDefaultCollisionConfiguration configuration{small_pools()};
  btCollisionDispatcher dispatcher{&configuration};
  btSimpleBroadphase broadphase{64};
  JointSolver joint_solver;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver;
  std::unique_ptr<btDiscreteDynamicsWorld> world;
  btEmptyShape nothing;
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  AfterSolve after_solve;
  std::unique_ptr<bullet::TerrainAction> action;
  std::vector<int> soil_body;  // wheel -> index in the action

  double dt = 0, time = 0;
  VehicleEnergy energy;
  std::vector<double> angle_error;  // per wheel, integral of the speed error [rad]
  std::vector<double> motor_torque;
  double motor_power = 0;
  Vec3 acceleration = Vec3::Zero();
  // Soil impulse that the last action applied, with the velocities it saw.
  std::vector<Wrench> soil_applied, soil_model;
  std::vector<Wrench> first_load;  // soil on wheels at rest, found by trim()
  std::vector<Twist> soil_twist;
  // Angular velocity change by Bullet's gyroscopic term of this step.
  std::vector<btVector3> gyro;
  double differential_e = 0, differential_rate = 0, differential_spring = 0, differential_damper = 0;

  Impl(const VehicleSpec& s, std::shared_ptr<Terrain> t, const WorldOptions& o)
      : spec(s), options(o), terrain(std::move(t)) {
    if (o.solver == WorldOptions::Solver::direct)
      solver = std::make_unique<btMLCPSolver>(&joint_solver);
    else
      solver = std::make_unique<btSequentialImpulseConstraintSolver>();
    world = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, solver.get(), &configuration);
    world->setGravity(btVector3(0, 0, -options.gravity));
    world->getSolverInfo().m_numIterations = options.iterations;
    world->getSolverInfo().m_erp = options.erp;
    world->getSolverInfo().m_globalCfm = 0;
    world->getDispatchInfo().m_useContinuous = false;
    build_bodies();
    build_joints();
    // Order matters: the account needs the solved velocities before the soil's impulse changes them.
    after_solve.f = [this] { account(); };
    world->addAction(&after_solve);
    action = std::make_unique<bullet::TerrainAction>(*world, terrain);
    for (const WheelSpec& w : spec.wheels) {
      // Gear frame: y along the axle.
      const LinkSpec& l = spec.links[w.link];
      const Vec3 axis_B = l.X_VB.q.conjugate() * spec.joints[w.joint].axis_V;
      Pose X_PG;
      X_PG.q = bodies[w.link].q_BP.conjugate() * Quat::FromTwoVectors(Vec3(Vec3::UnitY()), axis_B);
      soil_body.push_back(action->add_wheel(*bodies[w.link].rigid, w.gear, w.name, bt(X_PG)));
    }
    world->addAction(action.get());
    const std::size_t n = spec.wheels.size();
    angle_error.assign(n, 0.0);
    motor_torque.assign(n, 0.0);
    soil_applied.assign(n, {});
    soil_model.assign(n, {});
    soil_twist.assign(n, {});
    gyro.assign(bodies.size(), btVector3(0, 0, 0));
  }

  ~Impl() {
    world->removeAction(action.get());
    world->removeAction(&after_solve);
    for (Joint& j : joints) world->removeConstraint(j.constraint.get());
    for (Body& b : bodies) world->removeRigidBody(b.rigid.get());
  }

  void build_bodies() {
    for (const LinkSpec& l : spec.links) {
      Body b;
      // Bullet wants principal axes; keep the file's own axes where they are principal already.
      Mat3 off = l.inertia;
      off.diagonal().setZero();
      Vec3 moments = l.inertia.diagonal();
      if (off.norm() > 1e-12 * l.inertia.norm()) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> s{Eigen::Matrix3d(l.inertia)};
        Eigen::Matrix3d R = s.eigenvectors();
        if (R.determinant() < 0) R.col(2) = -R.col(2);
        b.q_BP = Quat(R);
        moments = s.eigenvalues();
      }
      b.inertia = bt(moments);
      btRigidBody::btRigidBodyConstructionInfo info(l.mass, nullptr, &nothing, b.inertia);
      b.rigid = std::make_unique<btRigidBody>(info);
      b.rigid->setDamping(0, 0);
      b.rigid->setActivationState(DISABLE_DEACTIVATION);
      b.rigid->setFlags(BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
      b.v = b.w = btVector3(0, 0, 0);
      bodies.push_back(std::move(b));
    }
    for (Body& b : bodies) world->addRigidBody(b.rigid.get(), 0, 0);  // group and mask 0: no pair is ever formed
    set_design_pose({});
  }

  void set_design_pose(const Pose& X_WV) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Pose X_WP = X_WV * spec.links[i].X_VB;
      X_WP.q = (X_WP.q * bodies[i].q_BP).normalized();
      set_pose(bodies[i], bt(X_WP));
    }
  }

  static void set_pose(Body& b, const btTransform& X) {
    b.rigid->setWorldTransform(X);
    b.rigid->setInterpolationWorldTransform(X);
    b.rigid->updateInertiaTensor();
  }

  void build_joints() {
    joints.resize(spec.joints.size());
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const JointSpec& s = spec.joints[i];
      Joint& j = joints[i];
      j.a = &bodies[s.parent];
      j.b = &bodies[s.child];
      // Bullet's hinge turns about z of its frames, the 6-dof joint slides along x.
      const Mat3 R_VJ = axis_frame(s.axis_V, s.type == JointSpec::Type::revolute ? 2 : 0);
      auto frame_in = [&](int link, const Body& b) {
        const Quat q_PV = (spec.links[link].X_VB.q * b.q_BP).conjugate();
        Pose X;
        X.p = q_PV * (s.anchor_V - spec.links[link].X_VB.p);
        X.q = q_PV * Quat(R_VJ);
        return X;
      };
      const Pose A = frame_in(s.parent, *j.a), B = frame_in(s.child, *j.b);
      j.anchor_a = bt(A.p);
      j.anchor_b = bt(B.p);
      const Vec3 axis_J = R_VJ.transpose() * s.axis_V, u_J = R_VJ.transpose() * across(s.axis_V);
      j.axis_a = bt(Vec3(A.q * axis_J));
      j.across_a = bt(Vec3(A.q * u_J));
      j.across_b = bt(Vec3(B.q * u_J));
      if (s.type == JointSpec::Type::revolute) {
        j.constraint = std::make_unique<btHingeConstraint>(*j.a->rigid, *j.b->rigid, bt(A), bt(B));
      } else {
        auto c = std::make_unique<btGeneric6DofSpring2Constraint>(*j.a->rigid, *j.b->rigid, bt(A), bt(B));
        c->setLinearLowerLimit(btVector3(1, 0, 0));  // x free: lower above upper
        c->setLinearUpperLimit(btVector3(-1, 0, 0));
        c->setAngularLowerLimit(btVector3(0, 0, 0));
        c->setAngularUpperLimit(btVector3(0, 0, 0));
        j.constraint = std::move(c);
      }
      j.constraint->setJointFeedback(&j.feedback);
      world->addConstraint(j.constraint.get(), true);
    }
  }

  void read_joint(Joint& j, bool revolute) const {
    const btTransform &A = j.a->rigid->getWorldTransform(), &B = j.b->rigid->getWorldTransform();
    j.axis = A.getBasis() * j.axis_a;
    if (revolute) {
      const btVector3 u = A.getBasis() * j.across_a, x = B.getBasis() * j.across_b;
      j.q = std::atan2(x.dot(j.axis.cross(u)), x.dot(u));
      j.rate = j.axis.dot(j.b->w - j.a->w);
    } else {
      const btVector3 p = B * j.anchor_b;
      j.r_a = p - A.getOrigin();
      j.r_b = p - B.getOrigin();
      j.q = j.axis.dot(p - A * j.anchor_a);
      j.rate = j.axis.dot(j.b->v + j.b->w.cross(j.r_b) - j.a->v - j.a->w.cross(j.r_a));
    }
  }

  void apply(Joint& j, bool revolute, double force) {
    if (force == 0) return;
    const btVector3 f = j.axis * force;
    if (revolute) {
      j.b->rigid->applyTorque(f);
      j.a->rigid->applyTorque(-f);
    } else {
      j.b->rigid->applyForce(f, j.r_b);
      j.a->rigid->applyForce(-f, j.r_a);
    }
  }

  static double stop_force(const StopSpec& s, double q, double rate, double* elastic, double* stored) {
    const double depth = q < s.lower ? q - s.lower : q > s.upper ? q - s.upper : 0.0;
    if (stored) *stored += 0.5 * s.stiffness * depth * depth;
    if (depth == 0) return 0;
    const double spring = -s.stiffness * depth, all = spring - s.damping * rate;
    *elastic += spring;
    return all * spring > 0 ? all : 0.0;  // a stop pushes, it never pulls
  }

  double stored(const JointSpec& s, double q) const {
    double e = 0.5 * s.stiffness * (q - s.rest) * (q - s.rest), unused = 0;
    if (s.stops) stop_force(*s.stops, q, 0, &unused, &e);
    return e;
  }

  double total_spring() const {
    double e = 0;
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (spec.joints[i].stiffness > 0 || spec.joints[i].stops) e += stored(spec.joints[i], joints[i].q);
    if (spec.differential) e += 0.5 * spec.differential->stiffness * differential_e * differential_e;
    return e;
  }

  void read_joints() {
    for (std::size_t i = 0; i < joints.size(); ++i)
      read_joint(joints[i], spec.joints[i].type == JointSpec::Type::revolute);
    if (spec.differential) {
      const Joint &a = joints[spec.differential->joint_a], &b = joints[spec.differential->joint_b];
      differential_e = a.q + spec.differential->sign * b.q;
      differential_rate = a.rate + spec.differential->sign * b.rate;
    }
  }

  /// Springs, dampers, stops, motors and steering as external forces on the two bodies of the joint.
  void apply_joint_forces(const Command& c) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const JointSpec& s = spec.joints[i];
      Joint& j = joints[i];
      j.spring = s.stiffness > 0 ? -s.stiffness * (j.q - s.rest) : 0.0;
      j.damper = -s.damping * j.rate;
      j.drive = 0;
      if (s.stops) {
        double elastic = 0;
        const double all = stop_force(*s.stops, j.q, j.rate, &elastic, nullptr);
        j.spring += elastic;
        j.damper += all - elastic;
      }
    }
    if (spec.differential) {
      const DifferentialSpec& d = *spec.differential;
      differential_spring = -d.stiffness * differential_e;
      differential_damper = -d.damping * differential_rate;
      joints[d.joint_a].spring += differential_spring;
      joints[d.joint_b].spring += d.sign * differential_spring;
      joints[d.joint_a].damper += differential_damper;
      joints[d.joint_b].damper += d.sign * differential_damper;
    }
    const bool powered = spec.battery_capacity <= 0 || energy.battery < spec.battery_capacity;
    for (std::size_t i = 0; i < spec.wheels.size(); ++i) {
      const WheelSpec& w = spec.wheels[i];
      motor_torque[i] = 0;
      if (w.motor < 0 || !powered) continue;
      const MotorSpec& m = spec.motors[w.motor];
      Joint& j = joints[w.joint];
      double want = c.wheels[i].value;
      double error = 0;
      if (c.wheels[i].mode == WheelCommand::Mode::speed) {
        error = c.wheels[i].value - j.rate;
        want = m.speed_gain * error + m.angle_gain * (angle_error[i] + dt * error);
      }
      const double limit = m.limit(j.rate, want >= 0 ? 1.0 : -1.0);
      const double torque = std::clamp(want, -limit, limit);
      // No wind-up: the integral waits while the motor gives all it has, unless the error takes it back.
      if (torque == want || error * want < 0) angle_error[i] += dt * error;
      motor_torque[i] = torque;
      j.drive += torque;
    }
    for (std::size_t i = 0; i < spec.steering.size(); ++i) {
      const SteerSpec& s = spec.steering[i];
      Joint& j = joints[s.joint];
      const double target = std::clamp(c.steer[i], -s.max_angle, s.max_angle);
      j.drive += std::clamp(s.gain * (target - j.q) - s.damping * j.rate, -s.max_torque, s.max_torque);
    }
    for (std::size_t i = 0; i < joints.size(); ++i)
      apply(joints[i], spec.joints[i].type == JointSpec::Type::revolute,
            joints[i].spring + joints[i].damper + joints[i].drive);
  }

  /// An impulse of the soil acts in the step after the one it was computed for. The first step after a trim would have
  /// none and the vehicle would start by falling for one step: give it the impulse of the equilibrium.
  void apply_first_load() {
    for (std::size_t i = 0; i < first_load.size(); ++i) {
      btRigidBody& b = *bodies[spec.wheels[i].link].rigid;
      soil_applied[i] = soil_model[i] = {first_load[i].f * dt, first_load[i].t * dt};
      soil_twist[i] = {};
      b.applyCentralImpulse(bt(soil_applied[i].f));
      b.applyTorqueImpulse(bt(soil_applied[i].t));
    }
    first_load.clear();
  }

  static double rotational_energy(const Body& b, const btMatrix3x3& R) {
    const btVector3 wl = b.w * R;  // R^T w
    return 0.5 * (b.inertia.x() * wl.x() * wl.x() + b.inertia.y() * wl.y() * wl.y() + b.inertia.z() * wl.z() * wl.z());
  }

  double kinetic_now() const {
    double e = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      e += 0.5 * spec.links[i].mass * bodies[i].v.length2() +
           rotational_energy(bodies[i], bodies[i].rigid->getWorldTransform().getBasis());
    return e;
  }

  double height_energy() const {
    double e = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      e += spec.links[i].mass * options.gravity * bodies[i].rigid->getWorldTransform().getOrigin().z();
    return e;
  }

  std::vector<btVector3> v_mid, w_mid;
  std::vector<btMatrix3x3> basis_before;
  double height_before = 0, spring_before = 0;

  void before_step() {
    basis_before.resize(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      basis_before[i] = bodies[i].rigid->getWorldTransform().getBasis();
      gyro[i] = bodies[i].rigid->computeGyroscopicImpulseImplicit_Body(dt);
    }
    height_before = height_energy();
    spring_before = total_spring();
  }

  /// The energy account of the step that Bullet has just solved and integrated.
  void account() {
    v_mid.resize(bodies.size());
    w_mid.resize(bodies.size());
    double gravity_work = 0, turning = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      Body& b = bodies[i];
      const btVector3 v = b.rigid->getLinearVelocity(), w = b.rigid->getAngularVelocity();
      v_mid[i] = 0.5 * (b.v + v);
      w_mid[i] = 0.5 * (b.w + w);
      if (i == 0) acceleration = from(v - b.v) / dt;
      b.v = v;
      b.w = w;
      gravity_work -= spec.links[i].mass * options.gravity * v_mid[i].z() * dt;
      // Gyroscopic impulse I dw, in body axes; then the inertia tensor turns at constant angular velocity.
      const btVector3 g = gyro[i] * basis_before[i], m = w_mid[i] * basis_before[i];
      turning += g.x() * b.inertia.x() * m.x() + g.y() * b.inertia.y() * m.y() + g.z() * b.inertia.z() * m.z();
      turning += rotational_energy(b, b.rigid->getWorldTransform().getBasis()) - rotational_energy(b, basis_before[i]);
    }
    energy.integration += turning;

    double joint_work = 0, spring_work = 0, motor = 0;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Joint& j = joints[i];
      const auto a = static_cast<std::size_t>(j.a - bodies.data()), b = static_cast<std::size_t>(j.b - bodies.data());
      joint_work += dt * (j.feedback.m_appliedForceBodyA.dot(v_mid[a]) + j.feedback.m_appliedTorqueBodyA.dot(w_mid[a]) +
                          j.feedback.m_appliedForceBodyB.dot(v_mid[b]) + j.feedback.m_appliedTorqueBodyB.dot(w_mid[b]));
      const double rate = spec.joints[i].type == JointSpec::Type::revolute
                              ? j.axis.dot(w_mid[b] - w_mid[a])
                              : j.axis.dot(v_mid[b] + w_mid[b].cross(j.r_b) - v_mid[a] - w_mid[a].cross(j.r_a));
      spring_work += j.spring * rate * dt;
      energy.damper -= j.damper * rate * dt;
      motor += j.drive * rate * dt;
    }
    energy.joints += joint_work;
    energy.motor += motor;
    energy.motor_positive += std::max(0.0, motor);
    energy.motor_gross += std::abs(motor);
    motor_power = motor / dt;
    for (std::size_t i = 0; i < spec.wheels.size(); ++i) {
      if (spec.wheels[i].motor < 0) continue;
      const MotorSpec& m = spec.motors[spec.wheels[i].motor];
      const Joint& j = joints[spec.wheels[i].joint];
      const auto a = static_cast<std::size_t>(j.a - bodies.data()), b = static_cast<std::size_t>(j.b - bodies.data());
      const double work = motor_torque[i] * j.axis.dot(w_mid[b] - w_mid[a]) * dt;
      energy.battery += work > 0 ? work / m.efficiency : work * m.regeneration;
    }

    for (std::size_t i = 0; i < spec.wheels.size(); ++i) {
      const std::size_t b = spec.wheels[i].link;
      const Twist mean{from(v_mid[b]), from(w_mid[b])};
      const double model = soil_model[i].power(soil_twist[i]), applied_end = soil_applied[i].power(soil_twist[i]);
      energy.soil_work += model;
      energy.implicit += applied_end - model;
      energy.integration += soil_applied[i].power(mean) - applied_end;
    }

    // Potentials: what the step's impulse did against what the potential says.
    read_joints();
    const double height = height_energy(), spring = total_spring();
    energy.integration += gravity_work + (height - height_before) + spring_work + (spring - spring_before);
    energy.potential += height - height_before;
    energy.spring = spring;
    energy.kinetic = kinetic_now();
  }

  void after_step() {
    for (std::size_t i = 0; i < spec.wheels.size(); ++i) {
      const BodyResult& r = action->result(soil_body[i]);
      soil_model[i] = {r.impulse, r.angular_impulse};
      soil_applied[i] = action->applied(soil_body[i]);
      const Body& b = bodies[spec.wheels[i].link];
      soil_twist[i] = {from(b.v), from(b.w)};
    }
  }
};

VehicleWorld::VehicleWorld(const VehicleSpec& spec, std::shared_ptr<Terrain> terrain, const WorldOptions& options)
    : impl_(std::make_unique<Impl>(spec, std::move(terrain), options)) {}
VehicleWorld::~VehicleWorld() = default;

void VehicleWorld::place(const Pose& X_WV) {
  Impl& m = *impl_;
  m.set_design_pose(X_WV);
  m.first_load.clear();
  for (Body& b : m.bodies) {
    b.v = b.w = btVector3(0, 0, 0);
    b.rigid->setLinearVelocity(b.v);
    b.rigid->setAngularVelocity(b.w);
  }
  m.read_joints();
}

TrimResult VehicleWorld::trim(const Pose& X_WV) {
  Impl& m = *impl_;
  m.set_design_pose({});
  const Pose X_VB0 = m.spec.links[0].X_VB;
  std::vector<Pose> wheels;
  double clear = -1e30;
  for (const WheelSpec& w : m.spec.wheels) {
    // The terrain's bodies are Bullet's, with principal axes.
    Pose X_VP = m.spec.links[w.link].X_VB;
    X_VP.q = X_VP.q * m.bodies[w.link].q_BP;
    wheels.push_back(X_VB0.inverse() * X_VP);
    const Vec3 p = X_WV * X_VP.p;
    clear = std::max(clear, m.terrain->ground().height(p.x(), p.y()) - (X_VP.p.z() - w.gear.outer_radius()));
  }
  Pose guess = X_WV;
  guess.p.z() = clear;
  const Pose X_WB0 = guess * X_VB0;
  if (!m.terrain->capabilities().continuous) {
    place(guess);
    TrimResult down;
    down.z = guess.p.z();
    down.why = "terrain '" + m.terrain->id() +
               "' has no static equilibrium to ask for: the vehicle is set down where its wheels touch the ground, and sinks in";
    return down;
  }
  const Vec3 cog = X_VB0.inverse() * m.spec.centre_of_mass_V();
  TrimResult r = trim_vehicle(*m.terrain, wheels, m.spec.total_mass(), cog, m.options.gravity, X_WB0);
  if (r.ok) {
    const Quat y = X_WB0.q;
    const double yaw = std::atan2(2 * (y.w() * y.z() + y.x() * y.y()), 1 - 2 * (y.y() * y.y() + y.z() * y.z()));
    const Pose trimmed{Vec3(X_WB0.p.x(), X_WB0.p.y(), r.z), chassis_orientation(yaw, r.pitch, r.roll)};
    place(trimmed * X_VB0.inverse());
    m.first_load = r.wheels;
  } else {
    place(guess);
  }
  return r;
}

void VehicleWorld::step(double dt, const Command& command) {
  Impl& m = *impl_;
  m.dt = dt;
  m.apply_first_load();
  m.apply_joint_forces(command);
  m.before_step();
  m.world->stepSimulation(dt, 0);
  m.after_step();
  m.time += dt;
}

double VehicleWorld::time() const { return impl_->time; }
const VehicleSpec& VehicleWorld::spec() const { return impl_->spec; }
Terrain& VehicleWorld::terrain() { return *impl_->terrain; }

Pose VehicleWorld::pose(int link) const {
  const Body& b = impl_->bodies[link];
  const btTransform& X = b.rigid->getWorldTransform();
  const btQuaternion q = X.getRotation();
  Pose p{from(X.getOrigin()), Quat(q.w(), q.x(), q.y(), q.z()) * b.q_BP.conjugate()};
  p.q.normalize();
  return p;
}
Twist VehicleWorld::twist(int link) const { return {from(impl_->bodies[link].v), from(impl_->bodies[link].w)}; }
double VehicleWorld::joint_position(int j) const { return impl_->joints[j].q; }
double VehicleWorld::joint_speed(int j) const { return impl_->joints[j].rate; }
double VehicleWorld::motor_torque(int w) const { return impl_->motor_torque[w]; }
double VehicleWorld::motor_power() const { return impl_->motor_power; }
const ContactReport& VehicleWorld::contact(int w) const { return impl_->action->result(impl_->soil_body[w]).report; }
double VehicleWorld::contact_rate(int w) const { return impl_->action->contact_rate(impl_->soil_body[w]); }
Vec3 VehicleWorld::soil_force(int w) const {
  return impl_->dt > 0 ? Vec3(impl_->soil_applied[w].f / impl_->dt) : Vec3(Vec3::Zero());
}
Vec3 VehicleWorld::chassis_acceleration() const { return impl_->acceleration; }
const VehicleEnergy& VehicleWorld::energy() const { return impl_->energy; }
double VehicleWorld::terrain_seconds() const { return impl_->action->terrain_seconds(); }

double VehicleWorld::joint_drift() const {
  double worst = 0;
  for (std::size_t i = 0; i < impl_->joints.size(); ++i) {
    const Joint& j = impl_->joints[i];
    btVector3 d = j.b->rigid->getWorldTransform() * j.anchor_b - j.a->rigid->getWorldTransform() * j.anchor_a;
    if (impl_->spec.joints[i].type == JointSpec::Type::prismatic) {
      const btVector3 axis = j.a->rigid->getWorldTransform().getBasis() * j.axis_a;
      d -= axis * axis.dot(d);
    }
    worst = std::max(worst, static_cast<double>(d.length()));
  }
  return worst;
}

void VehicleWorld::reset_energy() {
  VehicleEnergy e;
  e.kinetic = e.kinetic_0 = impl_->kinetic_now();
  e.spring = e.spring_0 = impl_->total_spring();
  impl_->energy = e;
}

int VehicleWorld::first_not_finite() const {
  for (std::size_t i = 0; i < impl_->bodies.size(); ++i) {
    const Body& b = impl_->bodies[i];
    const btTransform& X = b.rigid->getWorldTransform();
    double sum = b.v.length2() + b.w.length2() + X.getOrigin().length2();
    for (int k = 0; k < 3; ++k) sum += X.getBasis()[k].length2();
    if (!std::isfinite(sum)) return static_cast<int>(i);
  }
  return -1;
}

void VehicleWorld::traverse(State& s) {
  Impl& m = *impl_;
  s.field("time", m.time);
  s.field("dt", m.dt);
  auto vector = [&s](const char* name, btVector3& v) {
    double x[3] = {v.x(), v.y(), v.z()};
    s.reals(name, x, 3);
    if (s.loading()) v.setValue(x[0], x[1], x[2]);
  };
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    Body& b = m.bodies[i];
    auto g = s.group(m.spec.links[i].name);
    btTransform X = b.rigid->getWorldTransform();
    // The matrix itself: through a quaternion and back would change its last bits.
    double r[9];
    for (int k = 0; k < 9; ++k) r[k] = X.getBasis()[k / 3][k % 3];
    s.reals("rotation", r, 9);
    btVector3 p = X.getOrigin(), v = b.rigid->getLinearVelocity(), w = b.rigid->getAngularVelocity();
    vector("position", p);
    vector("velocity", v);
    vector("angular_velocity", w);
    vector("solved_velocity", b.v);
    vector("solved_angular_velocity", b.w);
    if (s.loading()) {
      X.setBasis(btMatrix3x3(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]));
      X.setOrigin(p);
      m.set_pose(b, X);
      b.rigid->setLinearVelocity(v);
      b.rigid->setAngularVelocity(w);
    }
  }
  for (std::size_t i = 0; i < m.spec.wheels.size(); ++i) {
    auto g = s.group("motor/" + m.spec.wheels[i].name);
    s.field("angle_error", m.angle_error[i]);
    s.field("applied_force", m.soil_applied[i].f);
    s.field("applied_torque", m.soil_applied[i].t);
    s.field("model_force", m.soil_model[i].f);
    s.field("model_torque", m.soil_model[i].t);
    s.field("twist", m.soil_twist[i]);
  }
  VehicleEnergy& e = m.energy;
  double* account[] = {&e.kinetic,        &e.potential, &e.spring,   &e.motor,       &e.damper,
                       &e.soil_work,      &e.implicit,  &e.joints,   &e.integration, &e.battery,
                       &e.motor_positive, &e.kinetic_0, &e.spring_0, &e.motor_gross};
  double values[14];
  for (int k = 0; k < 14; ++k) values[k] = *account[k];
  s.reals("energy", values, 14);
  for (int k = 0; k < 14; ++k) *account[k] = values[k];
  m.action->traverse(s);
  if (s.loading()) m.read_joints();
}

}  // namespace grouser::vehicle
