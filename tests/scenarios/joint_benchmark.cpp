// Which coordinates and which solver hold the joints, and what a step costs. Prints the table of vehicle/README.md; not
// a test.
//   joint_benchmark [seconds]: each shipped vehicle over ISO 8608 class E on hard ground at 1 ms with each solver of
//   VehicleWorld, and the robot as a btMultiBody (reduced coordinates: no drift by construction) in the air, for its
//   cost.
#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "grouser/models.h"
#include "grouser/terrain/loaders.h"
#include "grouser/vehicle/vehicle_loader.h"
#include "grouser/vehicle/vehicle_world.h"

namespace {

using namespace grouser;
using namespace grouser::vehicle;
using Clock = std::chrono::steady_clock;

void maximal(const char* file, double speed, double seconds, WorldOptions o, const char* name) {
  InputLog log;
  const VehicleSpec v = load_vehicle(std::filesystem::path(GROUSER_SOURCE_DIR) / "examples/vehicles" / file, {}, log);
  log.check();
  const ConfigDocument d = ConfigDocument::from_text(
      "ground: {shape: iso8608, class: E, track_width: 1 m, start: 2 m, run_in: 2 m}\n", "ground");
  const GroundPtr ground = load_ground(d.root().map("ground"), 1);
  d.check();
  Soil soil;
  soil.rigid = RigidSoil{};
  VehicleWorld w(v, all_models().get("rigid").make({soil, ground, {}, 9.81}), o);
  w.trim(Pose{});
  Command c{std::vector<WheelCommand>(v.wheels.size()), std::vector<double>(v.steering.size(), 0.0)};
  for (std::size_t i = 0; i < v.wheels.size(); ++i) c.wheels[i].value = speed / v.wheels[i].gear.radius();
  double drift = 0, wall = 0;
  const long n = std::lround(seconds / 1e-3);
  try {
    for (long i = 0; i < n; ++i) {
      const auto begin = Clock::now();
      w.step(1e-3, c);
      wall += std::chrono::duration<double>(Clock::now() - begin).count();
      drift = std::max(drift, w.joint_drift());
    }
    std::printf("| %-15s | %-22s | %10.3g | %6.1f | %6.1f |\n", file, name, 1e3 * drift,
                1e6 * (wall - w.terrain_seconds()) / static_cast<double>(n),
                1e6 * w.terrain_seconds() / static_cast<double>(n));
  } catch (const std::exception& e) {
    std::printf("| %-15s | %-22s | fails at %.3f s: %s |\n", file, name, w.time(), e.what());
  }
}

/// Chassis of 22 kg, four wheels of 2 kg, axles turned by torques.
void reduced(double seconds) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btSimpleBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, 0, -9.81));
  btMultiBody robot(4, 22, btVector3(0.19, 0.71, 0.80), false, false);
  for (int i = 0; i < 4; ++i)
    robot.setupRevolute(i, 2, btVector3(0.0074, 0.0121, 0.0074), -1, btQuaternion::getIdentity(), btVector3(0, 1, 0),
                        btVector3(i < 2 ? 0.225 : -0.225, i % 2 ? 0.2 : -0.2, -0.05), btVector3(0, 0, 0), true);
  robot.finalizeMultiDof();
  robot.setLinearDamping(0);
  robot.setAngularDamping(0);
  robot.setCanSleep(false);
  world.addMultiBody(&robot);
  const long n = std::lround(seconds / 1e-3);
  const auto begin = Clock::now();
  for (long i = 0; i < n; ++i) {
    for (int k = 0; k < 4; ++k) robot.addJointTorque(k, 0.01);
    world.stepSimulation(1e-3, 0);
  }
  const double wall = std::chrono::duration<double>(Clock::now() - begin).count();
  std::printf("| %-15s | %-22s | %10s | %6.1f | %6s |\n", "robot, in the air", "btMultiBody", "0",
              1e6 * wall / static_cast<double>(n), "-");
  world.removeMultiBody(&robot);
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  std::printf("| vehicle | joints | drift [mm] | Bullet [us/step] | terrain [us/step] |\n|---|---|---|---|---|\n");
  using S = WorldOptions::Solver;
  for (const auto& [file, speed] : {std::pair{"skid_robot.yaml", 0.5}, {"rover.yaml", 0.15}, {"offroad.yaml", 5.0}}) {
    maximal(file, speed, seconds, {9.81, S::sequential, 10, 0.2}, "sequential 10, erp 0.2");
    maximal(file, speed, seconds, {9.81, S::sequential, 50, 0.5}, "sequential 50, erp 0.5");
    maximal(file, speed, seconds, {9.81, S::sequential, 200, 0.5}, "sequential 200, erp 0.5");
    maximal(file, speed, seconds, {9.81, S::direct, 50, 0.2}, "direct, erp 0.2");
    maximal(file, speed, seconds, {9.81, S::direct, 50, 0.5}, "direct, erp 0.5");
  }
  reduced(seconds);
}
