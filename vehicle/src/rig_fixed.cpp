// The rig in Bullet: the wheel is a rigid body whose carrier is held, the soil acts through the adapter as on any vehicle.
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cmath>

#include "grouser/bullet/terrain_action.h"
#include "grouser/vehicle/trim.h"
#include "model_error.h"
#include "rig_case.h"

namespace grouser::vehicle {

namespace {

/// A Bullet world with one wheel and nothing that collides.
struct WheelWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btSphereShape shape;
  btRigidBody body;

  WheelWorld(double mass, double inertia, double radius, const Vec3& p)
      : shape(radius),
        body(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, &shape, btVector3(inertia, inertia, inertia))) {
    body.setDamping(0, 0);
    body.setFlags(0);  // no gyroscopic term: the spin axis is held
    body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(p.x(), p.y(), p.z())));
    body.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&body, 0, 0);
  }
  ~WheelWorld() { world.removeRigidBody(&body); }
};

}  // namespace

double start_height(const CaseContext& x) {
  const auto terrain = x.make_terrain();
  terrain->add_body({"wheel", x.spec.wheel, Pose()});
  const Pose start{{x.spec.x, x.spec.y, 0}, Quat::Identity()};
  return trim_wheel(*terrain, 0, start, x.c.load);
}

std::string run_fixed(const CaseContext& x, RigRow& row) {
  const RigSpec& spec = x.spec;
  const RigCase& c = x.c;
  const HeldMotion held(spec, c);
  const double dt = spec.time_step, mass = spec.mass(c);
  const double r = spec.wheel.outer_radius();
  const double inertia = spec.spin_inertia.value_or(0.5 * mass * r * r);
  const bool torque_driven = c.mode == RigCase::Mode::torque;

  bool lowering = spec.lower;
  const double z0 = lowering ? touch_height(*spec.ground, spec.wheel, spec.x, spec.y) + 1e-4 : start_height(x);
  WheelWorld w(mass, inertia, r, {spec.x, spec.y, z0});
  // The whole load pulls on the moving mass, whatever its weight: gravity of this world is load over mass.
  w.world.setGravity(btVector3(0, 0, -c.load / mass));
  w.body.setGravity(w.world.getGravity());
  const std::shared_ptr<Terrain> terrain = x.make_terrain();
  bullet::TerrainAction action(w.world, terrain);
  action.add_wheel(w.body, spec.wheel, "wheel");
  w.world.addAction(&action);
  w.body.setAngularFactor(btVector3(0, torque_driven ? 1 : 0, 0));
  w.body.setLinearFactor(btVector3(0, 0, lowering ? 0 : 1));
  // Bullet applies gravity before the soil has answered for the first time: this takes it back, so that the wheel starts at rest.
  if (!lowering) w.body.setLinearVelocity(btVector3(0, 0, dt * c.load / mass));

  const double give_up = spec.settle + 4 * r / spec.lowering_speed;
  const auto steps = static_cast<long>(std::llround(held.end() / dt));
  double touched = 0, told = 0;  // [s] time at touch-down; progress already told
  for (long i = 0; i < steps;) {
    const double tau = lowering ? -1 : static_cast<double>(i + 1) * dt;
    const double share = lowering ? 0 : held.share(tau);
    const double v_z = lowering ? -spec.lowering_speed : static_cast<double>(w.body.getLinearVelocity().z());
    w.body.setLinearVelocity(btVector3(held.v_x * share, held.v_y * share, v_z));
    if (torque_driven)
      w.body.applyTorque(btVector3(0, held.torque * share, 0));
    else
      w.body.setAngularVelocity(btVector3(0, held.w * share, 0));
    w.world.stepSimulation(dt, 0);
    if (!lowering) ++i;

    RigSample s;
    s.t = action.time();
    s.tau = lowering ? -1 : s.t - touched;
    s.X_WB = action.pose(0);
    s.V_WB = action.twist(0);
    s.report = action.result(0).report;
    s.vertical_force = (lowering ? action.result(0).impulse.z() : action.applied(0).f.z()) / dt;
    s.motor_torque = torque_driven ? held.torque * share : s.report.driving_torque;
    x.record.add(s, terrain->energy());

    if (lowering && s.vertical_force >= c.load) {
      lowering = false;
      touched = s.t;
      w.body.setLinearFactor(btVector3(0, 0, 1));
      w.body.setLinearVelocity(btVector3(0, 0, 0));
      w.body.applyCentralImpulse(btVector3(0, 0, c.load * dt));
      action.reset_wheel(0);
    } else if (lowering && s.t > give_up) {
      throw RigError(case_name(c) + ": lowered for " + std::to_string(s.t) + " s without finding the load of " +
                     std::to_string(c.load) + " N");
    }
    if (i % 256 == 0 || i == steps) {
      x.progress(s.t - told);
      told = s.t;
    }
  }
  w.world.removeAction(&action);
  row.simulated_s = action.time();
  row.terrain_s = action.terrain_seconds();
  const ModelError e = model_error(*terrain);
  row.model_error = {e.drawbar_pull, e.driving_torque, e.sinkage};
  row.outside = e.outside;
  row.warning = outside_warning(*terrain);
  x.record.warn(row.warning);
  State end;
  action.traverse(end);
  return end.hash_text();
}

}  // namespace grouser::vehicle
