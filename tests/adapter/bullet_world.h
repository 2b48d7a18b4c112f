#pragma once
// A Bullet world and its bodies, z up or y up, built with one line each.
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "grouser/bullet/terrain_action.h"
#include "spring_terrain.h"

namespace grouser::bullet {

constexpr bool double_precision = sizeof(btScalar) == sizeof(double);
constexpr double g = 9.81;

inline btScalar bt(double x) { return static_cast<btScalar>(x); }
inline btVector3 bt(double x, double y, double z) { return {bt(x), bt(y), bt(z)}; }

inline RunningGear wheel_gear(double radius = 0.13, double width = 0.16) {
  return {"wheel", SmoothCylinder{radius, width}};
}

struct World {
  explicit World(UpAxis up = UpAxis::z) : axes(up), dispatcher(&configuration) {
    world = std::make_unique<btMultiBodyDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration);
    world->setGravity(axes.from_W({0, 0, -g}));
  }
  ~World() {
    for (auto& c : constraints) world->removeConstraint(c.get());
    for (auto& b : bodies) world->removeRigidBody(b.get());
  }
  /// A body at p_W without collision shape contacts (mask 0) unless `collides`.
  btRigidBody& body(double mass, const Vec3& p_W, double radius = 0.13, bool collides = false) {
    shapes.push_back(std::make_unique<btSphereShape>(bt(radius)));
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shapes.back()->calculateLocalInertia(bt(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(bt(mass), nullptr, shapes.back().get(), inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(axes.from_W(p_W));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world->addRigidBody(bodies.back().get(), 1, collides ? -1 : 0);
    return *bodies.back();
  }
  template <class C, class... A>
  C& joint(A&&... a) {
    auto c = std::make_unique<C>(std::forward<A>(a)...);
    C& ref = *c;
    constraints.push_back(std::move(c));
    world->addConstraint(&ref, true);
    return ref;
  }
  /// n substeps of dt in calls of stepSimulation with `per_call` substeps each.
  void run(double seconds, double dt, int per_call = 1) {
    const auto calls = static_cast<int>(std::lround(seconds / (dt * per_call)));
    // A hair more than the whole number, or rounding makes Bullet drop the last substep of a call and catch up later.
    for (int i = 0; i < calls; ++i)
      world->stepSimulation(bt(dt * per_call * (per_call > 1 ? 1 + 1e-6 : 1)), per_call, bt(dt));
  }
  Vec3 at(const btRigidBody& b) const { return axes.to_W(b.getCenterOfMassPosition()); }

  Axes axes;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  std::unique_ptr<btMultiBodyDynamicsWorld> world;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> constraints;
};

/// Adds an action for the life of the scope.
struct Added {
  Added(World& w, btActionInterface& a) : w_(w), a_(a) { w_.world->addAction(&a_); }
  ~Added() { w_.world->removeAction(&a_); }
  Added(const Added&) = delete;
  World& w_;
  btActionInterface& a_;
};

}  // namespace grouser::bullet
