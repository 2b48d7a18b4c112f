// Registers ViscousSoil like any model of grouser, and lets a wheel roll to a stop on it in Bullet.
#include <btBulletDynamicsCommon.h>

#include <cstdio>

#include "grouser/bullet/terrain_action.h"
#include "viscous_soil.h"

// The one explicit line per model: id, what it can and cannot do, its options with units, and how to make it.
grouser::ModelInfo viscous_model() {
  return {.id = "example.viscous",
          .summary = "spring soil with viscous drag",
          .can = "rest, roll, stop",
          .cannot = "slip, memory, lateral capacity",
          .annotated_defaults = "stiffness: 2e5 N/m\ndamping: 500 N s/m\ndrag: 4000 N s/m^2\n",
          .make = [](const grouser::TerrainArgs& a) -> std::unique_ptr<grouser::Terrain> {
            const auto positive = grouser::Range::positive();
            return std::make_unique<ViscousSoil>(a.ground, a.options.quantity_or("stiffness", 2e5, "N/m", positive),
                                                 a.options.quantity_or("damping", 500, "N s/m", positive),
                                                 a.options.quantity_or("drag", 4000, "N s/m^2", positive));
          }};
}

int main() {
  grouser::Registry registry;
  registry.add(viscous_model());
  const grouser::Soil soil;  // this model takes all it needs from its options
  const auto options = grouser::ConfigDocument::from_text("stiffness: 100 kN/m", "options");
  std::shared_ptr<grouser::Terrain> terrain =
      registry.get("example.viscous").make({.soil = soil, .ground = grouser::flat_ground(), .options = options.root()});
  options.check();

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -9.81});

  btCylinderShape shape({0.13, 0.08, 0.13});
  btVector3 inertia;
  shape.calculateLocalInertia(10, inertia);
  btRigidBody wheel(btRigidBody::btRigidBodyConstructionInfo(10, nullptr, &shape, inertia));
  wheel.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0, 0, 0.13}));
  wheel.setLinearVelocity({1, 0, 0});
  world.addRigidBody(&wheel);

  grouser::bullet::TerrainAction action(world, terrain);
  action.add_wheel(wheel, {"wheel", grouser::SmoothCylinder{.radius = 0.13, .width = 0.16}}, "wheel");
  world.addAction(&action);
  for (int i = 0; i < 10000; ++i) world.stepSimulation(0.001, 1, 0.001);

  // Static sinkage m g / k = 10 * 9.81 / 1e5 = 0.981 mm; the drag there is 3.92 N s/m, so the wheel runs v m / (drag d) = 2.5 m.
  std::printf("sinkage %.3f mm, stopped after %.2f m\n", 1e3 * action.result(0).report.sinkage,
              wheel.getCenterOfMassPosition().x());
  const grouser::EnergyLedger& e = terrain->energy();
  std::printf("soil took %.2f J, kept %.4f J, turned %.2f J into heat\n", -e.work_on_bodies, e.stored, e.dissipated);
  world.removeAction(&action);
  world.removeRigidBody(&wheel);
}
