// The Bullet world of a vehicle: joints hold, nothing damps in secret, the energy account closes, state is complete.
#include "grouser/vehicle/vehicle_world.h"

#include <cmath>

#include "grouser/terrain/rigid.h"
#include "grouser/vehicle/vehicle_loader.h"
#include "support.h"

namespace grouser::vehicle {
namespace {

VehicleSpec shipped(const char* name) {
  InputLog log;
  VehicleSpec v = load_vehicle(test::examples / "vehicles" / name, {}, log);
  log.check();
  return v;
}

std::shared_ptr<Terrain> hard_ground(double z = 0) {
  Soil soil;
  soil.rigid = RigidSoil{};
  return all_models().get("rigid").make({soil, flat_ground(z), {}, 9.81});
}

Command standing(const VehicleSpec& v) {
  return {std::vector<WheelCommand>(v.wheels.size()), std::vector<double>(v.steering.size(), 0.0)};
}

Vec3 centre_of_mass(const VehicleWorld& w) {
  Vec3 c = Vec3::Zero();
  for (std::size_t i = 0; i < w.spec().links.size(); ++i) c += w.spec().links[i].mass * w.pose(static_cast<int>(i)).p;
  return c / w.spec().total_mass();
}

TEST(VehicleWorld, FallsFreely) {
  // Semi-implicit Euler falls by g dt^2 n (n + 1)/2 exactly, whatever the joints do inside: no damping, no sleeping, no
  // external force.
  const VehicleSpec v = shipped("rover.yaml");
  VehicleWorld w(v, hard_ground(-1000), {});
  w.place(Pose{});
  const double before = centre_of_mass(w).z();
  const double dt = 1e-3;
  const int n = 1000;
  for (int i = 0; i < n; ++i) w.step(dt, standing(v));
  EXPECT_NEAR(before - centre_of_mass(w).z(), 9.81 * dt * dt * n * (n + 1) / 2, 1e-9);
}

TEST(VehicleWorld, AngularMomentumIsKeptInTheAir) {
  // Motors spin the wheels up against the chassis: the whole keeps its angular momentum, so the chassis turns backwards
  // by the ratio of the inertias (robot: wheels' spin inertia against everything about the y axis).
  const VehicleSpec v = shipped("skid_robot.yaml");
  VehicleWorld w(v, hard_ground(-1000), {0.0});
  w.place(Pose{});
  Command c = standing(v);
  for (WheelCommand& k : c.wheels) k.value = 5;
  for (int i = 0; i < 500; ++i) w.step(1e-3, c);
  const Vec3 c0 = centre_of_mass(w);
  Vec3 L = Vec3::Zero(), gross = Vec3::Zero();
  for (std::size_t i = 0; i < v.links.size(); ++i) {
    const Pose X = w.pose(static_cast<int>(i));
    const Twist V = w.twist(static_cast<int>(i));
    const Mat3 R = X.q.toRotationMatrix();
    const Vec3 part = R * v.links[i].inertia * R.transpose() * V.w + v.links[i].mass * (X.p - c0).cross(V.v);
    L += part;
    gross += part.cwiseAbs();
  }
  EXPECT_GT(gross.norm(), 0.1);
  // Constraint impulses act in pairs; what remains is the position correction's share.
  EXPECT_LT(L.norm(), 1e-3 * gross.norm());
}

TEST(VehicleWorld, DifferentialAveragesTheRockers) {
  // The left front wheel stands 60 mm higher than the other five.
  const VehicleSpec v = shipped("rover.yaml");
  struct FrontKerb : Ground {
    double height(double x, double y) const override { return y > 0 && x > 0.35 ? 0.06 : 0.0; }
    double resolution() const override { return 0.1; }
    std::string describe() const override { return "left front wheel 60 mm higher"; }
  };
  Soil soil;
  soil.rigid = RigidSoil{};
  VehicleWorld w(v, all_models().get("rigid").make({soil, std::make_shared<FrontKerb>(), {}, 9.81}), {});
  w.trim(Pose{});
  for (int i = 0; i < 4000; ++i) w.step(1e-3, standing(v));
  const double a = w.joint_position(v.differential->joint_a), b = w.joint_position(v.differential->joint_b);
  EXPECT_GT(std::abs(a), 0.01);  // the rockers really turned
  // The coupling is a spring of 1e5 N m/rad: its wind-up under the rover's own weight stays below a tenth of a degree.
  EXPECT_NEAR(a + b, 0.0, 2e-3);
  // Chassis pitch = mean of the two rockers' pitch in the world (rocker pitch = chassis pitch + joint angle).
  const auto pitch = [&](int link) {
    const Mat3 R = w.pose(link).q.toRotationMatrix();
    return std::asin(-R(2, 0));
  };
  const double left = pitch(v.joints[v.differential->joint_a].child),
               right = pitch(v.joints[v.differential->joint_b].child);
  EXPECT_NEAR(pitch(0), 0.5 * (left + right), 1e-3);
}

TEST(VehicleWorld, RestoredWorldGoesOnBitByBit) {
  const VehicleSpec v = shipped("offroad.yaml");
  Command c = standing(v);
  for (WheelCommand& k : c.wheels) k.value = 2;
  c.steer.assign(v.steering.size(), 0.1);
  auto fresh = [&] { return std::make_unique<VehicleWorld>(v, hard_ground(), WorldOptions{}); };
  auto a = fresh();
  a->trim(Pose{});
  for (int i = 0; i < 300; ++i) a->step(1e-3, c);
  State saved;
  a->traverse(saved);
  auto load = [&](VehicleWorld& w) {
    State s = saved;
    s.rewind(State::Mode::load);
    w.traverse(s);
    s.finish();
  };
  auto b = fresh(), d = fresh();
  load(*b);
  load(*d);
  State again;
  b->traverse(again);
  const auto same = State::first_difference(saved, again);
  EXPECT_FALSE(same) << same->field << " " << same->left << " " << same->right;
  for (int i = 0; i < 300; ++i) b->step(1e-3, c), d->step(1e-3, c);
  State sb, sd;
  b->traverse(sb);
  d->traverse(sd);
  const auto difference = State::first_difference(sb, sd);
  EXPECT_FALSE(difference) << difference->field << " " << difference->left << " " << difference->right;
}

TEST(VehicleWorld, EnergyClosesWhileBouncing) {
  // Dropped from 50 mm with the suspension locked in no way: springs, dampers, stops and the ground all work.
  const VehicleSpec v = shipped("offroad.yaml");
  VehicleWorld w(v, hard_ground(), {});
  w.place(Pose{Vec3(0, 0, 0.05), Quat::Identity()});
  w.reset_energy();
  for (int i = 0; i < 2000; ++i) w.step(1e-3, standing(v));
  const VehicleEnergy& e = w.energy();
  // The account follows Bullet's own arithmetic: what is left is rounding.
  EXPECT_LT(std::abs(e.residual()), 1e-6 * e.damper);
  EXPECT_GT(e.damper, 100);  // [J] it really bounced: 1200 kg from 50 mm is 590 J
}

}  // namespace
}  // namespace grouser::vehicle
