// A cart with four driven wheels in an ordinary Bullet world. The ten lines marked (1) to (10) put soil under it.
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include "grouser/bullet/terrain_action.h"  // (1) the adapter, header-only
#include "grouser/models.h"                 // (2) load_terrain

namespace {

// A rigid body of the given shape and mass at p. Nothing here knows of soil.
std::unique_ptr<btRigidBody> make_body(btScalar mass, btCollisionShape& shape, const btVector3& p) {
  btVector3 inertia(0, 0, 0);
  shape.calculateLocalInertia(mass, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
  info.m_startWorldTransform.setIdentity();
  info.m_startWorldTransform.setOrigin(p);
  return std::make_unique<btRigidBody>(info);
}

void drive(const std::filesystem::path& folder) {
  // A Bullet world as in every tutorial: z is up, and there is no ground shape, because the soil is the ground.
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, -9.81});

  // The cart: a 20 kg box, and four 2.5 kg wheels of radius 0.13 m that turn about y.
  btBoxShape box({0.35, 0.15, 0.05});
  btCylinderShape cylinder({0.13, 0.08, 0.13});
  const auto chassis = make_body(20, box, {0, 0, 0.20});
  world.addRigidBody(chassis.get());

  // (3) the soil: model, soil and ground are named in a file, so another soil needs no other program
  const std::shared_ptr<grouser::Terrain> terrain = grouser::load_terrain(folder / "terrain.yaml");
  // (4) the action that Bullet calls after each of its steps
  grouser::bullet::TerrainAction soil(world, terrain);
  // (5) the shape that the soil sees: analytic, so it need not be the collision shape
  const grouser::RunningGear gear{"wheel", grouser::SmoothCylinder{.radius = 0.13, .width = 0.16}};

  std::unique_ptr<btRigidBody> wheels[4];
  std::unique_ptr<btHingeConstraint> hinges[4];
  const char* names[4] = {"front_left", "front_right", "rear_left", "rear_right"};
  for (int i = 0; i < 4; ++i) {
    const btVector3 hub(i < 2 ? 0.30 : -0.30, i % 2 == 0 ? 0.25 : -0.25, -0.07);
    wheels[i] = make_body(2.5, cylinder, chassis->getCenterOfMassPosition() + hub);
    world.addRigidBody(wheels[i].get());
    // A motor that turns the wheel at 2 rad/s with at most 20 N m.
    hinges[i] = std::make_unique<btHingeConstraint>(*chassis, *wheels[i], hub, btVector3(0, 0, 0), btVector3(0, 1, 0),
                                                    btVector3(0, 1, 0));
    hinges[i]->enableAngularMotor(true, -2, 20 * 0.001);
    world.addConstraint(hinges[i].get(), true);
    // (6) the soil carries this body
    soil.add_wheel(*wheels[i], gear, names[i]);
  }

  // (7) from now on every step of the world is a step on soil
  world.addAction(&soil);

  // Five seconds at 1 kHz, drawn at 50 Hz.
  for (int frame = 0; frame < 250; ++frame) world.stepSimulation(0.02, 21, 0.001);

  // (8) what a wheel feels: sinkage, slip, forces and torque come with each step
  for (int i = 0; i < 4; ++i) {
    const grouser::ContactReport& contact = soil.result(i).report;
    std::printf("%-11s sinkage %.1f mm, slip %.2f, load %.0f N, drawbar pull %.1f N\n", names[i], 1e3 * contact.sinkage,
                contact.slip, contact.normal_force, contact.drawbar_pull);
  }
  std::printf("driven %.2f m on %s\n", chassis->getCenterOfMassPosition().x(), terrain->id().c_str());

  // (9) the action leaves the world before it dies; the rest is Bullet's usual clearing up
  world.removeAction(&soil);
  for (auto& hinge : hinges) world.removeConstraint(hinge.get());
  for (auto& wheel : wheels) world.removeRigidBody(wheel.get());
  world.removeRigidBody(chassis.get());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    drive(argc > 1 ? argv[1] : ".");
    return 0;
  } catch (const std::exception& e) {
    // (10) a wrong file is told with its line and column
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}
