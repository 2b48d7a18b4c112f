// Quarter car: sprung and unsprung mass in Bullet, the wheel on terrain `rigid` through bullet::TerrainAction at a fixed step, against
// an ODE integrated to tolerance by CVODE. The reference shares neither Bullet nor the adapter nor the terrain: its contact law is
// evaluated here from the overlap of the wheel circle with the profile, by root finding and Gauss quadrature.
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "grouser/bullet/terrain_action.h"
#include "grouser/terrain/registry.h"
#include "grouser/terrain/rigid.h"
#include "grouser/vehicle/ode.h"

using namespace grouser;

namespace {

// A passenger car's corner (textbook values, e.g. Wong 2008, chapter 7) on a 0.3 m wheel.
constexpr double sprung = 240, unsprung = 36, spring = 16e3, damper = 980;
constexpr double tyre = 160e3, tyre_damper = 300, radius = 0.3, gravity = 9.81, speed = 5;
constexpr double x_start = -5, duration = 5;

/// Profile z = f(x) with the places where it has a kink.
struct Profile {
  std::function<double(double)> f;
  std::vector<double> kinks;
};

/// 20 mm of amplitude, 3 m long, from x = 0; a cosine start so that it has no kink in slope.
Profile sinusoid() {
  return {[](double x) { return x <= 0 ? 0.0 : 0.02 * (1 - std::cos(2 * pi * x / 3)); }, {0.0}};
}
/// 40 mm up over a ramp of 100 mm: the wheel climbs its upper edge.
Profile step() {
  return {[](double x) { return 0.04 * std::clamp(x / 0.1, 0.0, 1.0); }, {0.0, 0.1}};
}

class ProfileGround final : public Ground {
 public:
  explicit ProfileGround(Profile p) : p_(std::move(p)) {}
  double height(double x, double) const override { return p_.f(x); }
  double resolution() const override { return 1e-3; }
  std::string describe() const override { return "profile of the quarter-car test"; }

 private:
  Profile p_;
};

/// Overlap area of the circle at (x, z) with the ground, and its derivatives by x and z.
struct Overlap {
  double area = 0, by_x = 0, by_z = 0;
};

Overlap overlap(const Profile& p, double x, double z) {
  auto depth = [&](double s) { return p.f(s) - z + std::sqrt(std::max(0.0, radius * radius - (s - x) * (s - x))); };
  auto root = [&](double a, double b) {  // depth changes sign in [a, b]
    for (int i = 0; i < 60; ++i) {
      const double m = 0.5 * (a + b);
      ((depth(m) > 0) == (depth(a) > 0) ? a : b) = m;
    }
    return 0.5 * (a + b);
  };
  static constexpr std::array<double, 4> node{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                              0.9602898564975363};
  static constexpr std::array<double, 4> weight{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                0.1012285362903763};
  Overlap o;
  auto add = [&](double a, double b) {
    std::vector<double> cuts{a, b};
    for (double k : p.kinks)
      if (k > a && k < b) cuts.insert(cuts.end() - 1, k);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const double m = 0.5 * (cuts[i] + cuts[i + 1]), h = 0.5 * (cuts[i + 1] - cuts[i]);
      for (std::size_t g = 0; g < node.size(); ++g)
        o.area += h * weight[g] * (depth(m - h * node[g]) + depth(m + h * node[g]));
    }
    const auto up = [&](double s) { return std::sqrt(radius * radius - (s - x) * (s - x)); };
    o.by_z -= b - a;
    o.by_x -= up(b) - up(a);
  };
  constexpr int n = 300;
  double begin = NAN, before = x - 0.999 * radius;
  for (int i = 1; i <= n; ++i) {
    const double at = x - 0.999 * radius + 1.998 * radius * i / n;
    const bool in = depth(at) > 0, was = depth(before) > 0;
    if (in && !was) begin = root(before, at);
    if (!in && was) add(begin, root(before, at));
    before = at;
  }
  return o;
}

/// Vertical force of a spring-damper contact whose spring energy is k h^2/2, h the depth of the circular segment of the same area.
double contact_force(const Profile& p, double x, double z, double vx, double vz) {
  const Overlap o = overlap(p, x, z);
  if (!(o.area > 0)) return 0;
  double low = 0, high = pi / 2;  // half angle of the segment: area = r^2 (a - sin a cos a)
  for (int i = 0; i < 60; ++i) {
    const double a = 0.5 * (low + high);
    (radius * radius * (a - std::sin(a) * std::cos(a)) < o.area ? low : high) = a;
  }
  const double a = 0.5 * (low + high), chord = 2 * radius * std::sin(a), h = radius * (1 - std::cos(a));
  const double h_z = o.by_z / chord, h_x = o.by_x / chord;
  const double elastic = tyre * h;
  const double viscous = std::clamp(tyre_damper * (h_x * vx + h_z * vz), -elastic, elastic);
  return -(elastic + viscous) * h_z;
}

const double z1_rest = radius - (sprung + unsprung) * gravity / tyre;
const double z2_rest = z1_rest + 0.5;
double suspension(double z1, double v1, double z2, double v2) {
  return sprung * gravity + spring * ((z1 - z1_rest) - (z2 - z2_rest)) + damper * (v1 - v2);
}

/// Height of the sprung mass every millisecond.
std::vector<double> reference(const Profile& p) {
  vehicle::OdeOptions o;
  o.relative = 1e-8;
  o.absolute = {1e-9};
  o.max_step = 5e-3;  // 25 mm of travel: the solver must not step over the kerb
  vehicle::Ode ode(
      0, {z1_rest, 0, z2_rest, 0},
      [&](double t, auto y, auto dy) {
        const double s = suspension(y[0], y[1], y[2], y[3]);
        dy[0] = y[1];
        dy[1] = (contact_force(p, x_start + speed * t, y[0], speed, y[1]) - s) / unsprung - gravity;
        dy[2] = y[3];
        dy[3] = s / sprung - gravity;
      },
      o);
  std::vector<double> z;
  for (int i = 1; i <= static_cast<int>(duration * 1000); ++i) {
    while (ode.advance(i * 1e-3) == vehicle::Ode::Stop::root) {
    }
    z.push_back(ode.state()[2]);
  }
  return z;
}

struct Body {
  btSphereShape shape{0.1};
  btRigidBody body;
  Body(btDiscreteDynamicsWorld& w, double m, double x, double z)
      : body(btRigidBody::btRigidBodyConstructionInfo(m, nullptr, &shape, btVector3(1, 1, 1))) {
    body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(x, 0, z)));
    body.setActivationState(DISABLE_DEACTIVATION);
    w.addRigidBody(&body, 0, 0);
    body.setLinearFactor(btVector3(0, 0, 1));
    body.setAngularFactor(btVector3(0, 0, 0));
  }
};

std::vector<double> in_bullet(const Profile& p, int rate) {
  const double dt = 1.0 / rate;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(btVector3(0, 0, -gravity));
  Body wheel(world, unsprung, x_start, z1_rest), body(world, sprung, x_start, z2_rest);

  Soil soil;
  soil.rigid = RigidSoil{tyre, tyre_damper, 0.0, 0.0, 0.0};
  // The ground as a polyline of 1.5 mm: fine enough not to be seen in the error.
  const ConfigDocument options = ConfigDocument::from_text("{strips: 1, samples_per_radius: 200}", "options");
  const std::shared_ptr<Terrain> terrain =
      rigid_model().make({soil, std::make_shared<ProfileGround>(p), options.root(), gravity});
  options.check();
  bullet::TerrainAction action(world, terrain);
  action.add_wheel(wheel.body, {"wheel", SmoothCylinder{radius, 0.2}}, "wheel");
  world.addAction(&action);
  wheel.body.setLinearVelocity(btVector3(speed, 0, (sprung + unsprung) * gravity / unsprung * dt));
  body.body.setLinearVelocity(btVector3(speed, 0, 0));

  std::vector<double> z;
  double v1 = 0;  // after the solve: the body's own velocity already holds the soil's impulse of the coming step
  for (int i = 1; i <= static_cast<int>(duration * rate); ++i) {
    const double s = suspension(wheel.body.getWorldTransform().getOrigin().z(), v1,
                                body.body.getWorldTransform().getOrigin().z(), body.body.getLinearVelocity().z());
    wheel.body.applyCentralForce(btVector3(0, 0, -s));
    body.body.applyCentralForce(btVector3(0, 0, s));
    world.stepSimulation(dt, 0);
    v1 = action.twist(0).v.z();
    if (i % (rate / 1000) == 0) z.push_back(body.body.getWorldTransform().getOrigin().z());
  }
  world.removeAction(&action);
  world.removeRigidBody(&wheel.body);
  world.removeRigidBody(&body.body);
  return z;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double s = 0;
  for (std::size_t i = 0; i < a.size(); ++i) s += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(s / static_cast<double>(a.size()));
}

void compare(const char* name, const Profile& p) {
  const std::vector<double> truth = reference(p);
  const double motion = rms_difference(truth, std::vector<double>(truth.size(), z2_rest));
  ASSERT_GT(motion, 5e-3);
  double error[3];
  std::vector<double> z[3];
  for (int k = 0; k < 3; ++k) {
    z[k] = in_bullet(p, 1000 << k);
    ASSERT_EQ(z[k].size(), truth.size());
    error[k] = rms_difference(z[k], truth) / motion;
  }
  // Order from three steps, without the reference: what the halving of the step still changes.
  const double order = std::log2(rms_difference(z[0], z[1]) / rms_difference(z[1], z[2]));
  std::printf(
      "%s: body motion %.2f mm rms; difference from CVODE %.4f %% at 1 kHz, %.4f %% at 2 kHz, %.4f %% at 4 kHz; order "
      "%.3f\n",
      name, 1e3 * motion, 100 * error[0], 100 * error[1], 100 * error[2], order);
  ::testing::Test::RecordProperty("rms_difference_percent_1kHz", std::to_string(100 * error[0]));
  ::testing::Test::RecordProperty("observed_order", std::to_string(order));
  EXPECT_LE(error[0], 0.01);
  EXPECT_LT(error[1], 0.6 * error[0]);
  // Bullet's step is symplectic Euler with forces of the old state: first order.
  EXPECT_GT(order, 0.9);
  EXPECT_LT(order, 1.3);
}

TEST(QuarterCar, BodyOverASinusoidIsWithinOnePercentOfTheOde) { compare("sinusoid", sinusoid()); }
TEST(QuarterCar, BodyOverAStepIsWithinOnePercentOfTheOde) { compare("step", step()); }

// The independent contact law on level ground: F = k h exactly.
TEST(QuarterCar, ReferenceContactIsALinearSpringOnLevelGround) {
  const Profile flat{[](double) { return 0.0; }, {}};
  for (const double h : {1e-5, 1e-3, 0.02})
    EXPECT_NEAR(contact_force(flat, 0.3, radius - h, speed, 0), tyre * h, 1e-7 * tyre * h + 1e-9);
}

}  // namespace
