// Contact begins and ends as it should, and the report says what happened.
#include "conformance/conformance.h"

namespace grouser::test {
namespace {

class Contact : public Conformance {};

TEST_P(Contact, NothingHappensClearOfTheSoil) {
  GROUSER_NOT_FOR_GRAINS("the highest grains stand above the mean surface, so that a micrometre above it is not clear");
  const auto t = make();
  for (int i = 0; i < 20; ++i) {
    WheelState s = Rolling{}.at(0.001 * i);
    s.hub.z() = radius() + 1e-6;
    s.velocity.z() = i % 2 ? 1 : -1;
    const BodyResult r = step_one(*t, 0.001 * i, 0.001, arriving(s, 0.001));
    // Exactly zero: there is nothing to round.
    EXPECT_EQ(r.impulse, Vec3(Vec3::Zero()));
    EXPECT_EQ(r.angular_impulse, Vec3(Vec3::Zero()));
    EXPECT_FALSE(r.report.in_contact);
    EXPECT_EQ(r.report.sinkage, 0);
  }
  EXPECT_EQ(t->energy().gross, 0);
  EXPECT_EQ(t->energy().stored, 0);
  EXPECT_EQ(t->energy().dissipated, 0);
}

TEST_P(Contact, ForceGrowsFromZeroAtTouchDown) {
  GROUSER_NOT_FOR_GRAINS("a wheel that begins inside the soil takes the place of grains and meets no force before it moves");
  // Down, resting and up, rolling with slip: the force at depth d must vanish with d. Any law that grows at least like
  // d^0.65 falls by a factor of 20 from 100 to 1 um; a step at contact (a damper that pushes at once) does not.
  for (const double vz : {0.0, -0.5, 0.5}) {
    double force[3];
    const double depth[3] = {1e-6, 1e-5, 1e-4};
    for (int k = 0; k < 3; ++k) {
      const auto t = make();
      WheelState s = Rolling{depth[k]}.at(0);
      s.velocity.z() = vz;
      force[k] = step_one(*t, 0, 1e-3, arriving(s, 1e-3)).impulse.norm() / 1e-3;
      EXPECT_TRUE(std::isfinite(force[k]));
    }
    EXPECT_LE(force[0], force[1]) << vz;
    EXPECT_LE(force[1], force[2]) << vz;
    EXPECT_LE(force[0], 0.05 * force[2]) << vz;
    // 1 um is a thousandth of the static sinkage; a thousandth of any sensible wheel load is below 1 N.
    EXPECT_LT(force[0], 1.0) << vz;
  }
}

TEST_P(Contact, SoilPushesAndNeverPulls) {
  GROUSER_NOT_FOR_GRAINS("grains rub on the sides of a wheel that is drawn out, and a contact that opens pulls for a moment");
  for (const double vz : {0.0, -0.2, 0.2, 2.0})
    for (const double sinkage : {1e-4, 1e-3, 0.01}) {
      const auto t = make();
      WheelState s = Rolling{sinkage}.at(0);
      s.velocity.z() = vz;
      EXPECT_GE(step_one(*t, 0, 1e-3, arriving(s, 1e-3)).impulse.z(), 0) << vz << ' ' << sinkage;
    }
}

TEST_P(Contact, DeeperIsHarder) {
  GROUSER_NOT_FOR_GRAINS("a wheel that begins inside the soil takes the place of grains");
  double last = 0;
  for (const double sinkage : {0.001, 0.002, 0.005, 0.01, 0.02}) {
    const auto t = make();
    BodyResult r;
    for (int i = 0; i < 50; ++i)
      r = step_one(*t, 0.001 * i, 0.001, arriving(Rolling{sinkage, 0.05, 0, 0}.at(0.001 * (i + 1)), 0.001));
    EXPECT_GT(r.report.normal_force, last);
    last = r.report.normal_force;
  }
}

TEST_P(Contact, ReportAgreesWithTheImpulse) {
  const double dt = 1e-3;
  for (const double slope : {0.0, 0.1})
    for (const double slip : {-0.3, 0.0, 0.4}) {
      const auto t = make(std::make_shared<Plane>(0, Vec2(slope, -slope)));
      BodyResult r;
      WheelState s;
      for (int i = 1; i <= 200; ++i) {
        s = Rolling{0.008, 0.05, slip, 0.15, 0.4}.at(dt * i);
        s.hub.z() += t->ground().height(s.hub.x(), s.hub.y());
        s.camber = 0.05;
        r = step_one(*t, dt * (i - 1), dt, arriving(s, dt));
      }
      const ContactReport& c = r.report;
      ASSERT_TRUE(c.in_contact);
      for (const double x : {c.sinkage, c.slip, c.slip_angle, c.entry_angle, c.exit_angle, c.normal_force,
                             c.drawbar_pull, c.side_force, c.driving_torque})
        EXPECT_TRUE(std::isfinite(x));
      EXPECT_TRUE(c.point_W.allFinite());
      // The same numbers in other words: rounding only.
      const double round = 1e-12 * c.force_W.norm();
      EXPECT_LE((c.force_W * dt - r.impulse).norm(), round * dt);
      const Mat3 C = carrier_axes(s.axis());
      EXPECT_NEAR(c.drawbar_pull, c.force_W.dot(C.col(0)), round);
      EXPECT_NEAR(c.side_force, c.force_W.dot(C.col(1)), round);
      EXPECT_NEAR(c.normal_force, c.force_W.dot(C.col(2)), round);
      EXPECT_NEAR(c.driving_torque, -r.angular_impulse.dot(C.col(1)) / dt, 1e-12 * (radius() * c.force_W.norm() + 1));
      // Slip is kinematic; slopes and camber of 0.1 rad turn the plane of contact by that much at most.
      EXPECT_NEAR(c.slip, slip, 0.02);
      EXPECT_NEAR(c.slip_angle, 0.15, 0.03);
      // The contact lies on the wheel's lower part and within the contact length of a chord.
      EXPECT_LT(c.point_W.z(), s.hub.z());
      EXPECT_LE((c.point_W - s.hub).norm(), std::hypot(radius(), gear().width() / 2) * (1 + 1e-9));
      EXPECT_GE(c.entry_angle, 0);
      EXPECT_LE(c.exit_angle, c.entry_angle);
    }
}

TEST_P(Contact, SinkageIsMeasuredFromTheSurface) {
  GROUSER_NOT_FOR_GRAINS("entry and exit angles are those of the grains that touch");
  // Vertical press on flat ground at some height: the geometry alone gives the sinkage.
  for (const double z0 : {0.0, 3.5}) {
    const auto t = make(flat_ground(z0));
    WheelState s;
    s.hub = {0, 0, z0 + radius() - 0.007};
    const BodyResult r = step_one(*t, 0, 1e-3, arriving(s, 1e-3));
    // 1e-9 m: rounding of a height of metres.
    EXPECT_NEAR(r.report.sinkage, 0.007, 1e-9);
    EXPECT_NEAR(r.report.entry_angle, std::acos(1 - 0.007 / radius()), 1e-6);
  }
}

TEST_P(Contact, DrivingPullsAndBrakingHolds) {
  // Signs of the field: slip 0.6 pulls forward more than slip 0; braking pulls back; the motor is asked for torque when
  // driving.
  auto steady = [&](double slip) {
    const auto t = make();
    BodyResult r;
    for (int i = 0; i < 2000; ++i)
      r = step_one(*t, 1e-3 * i, 1e-3, arriving(Rolling{0.005, 0.1, slip, 0}.at(1e-3 * (i + 1)), 1e-3));
    return r.report;
  };
  const ContactReport drive = steady(0.6), coast = steady(0), brake = steady(-0.6);
  EXPECT_GT(drive.drawbar_pull, coast.drawbar_pull);
  EXPECT_GT(coast.drawbar_pull, brake.drawbar_pull);
  EXPECT_LT(brake.drawbar_pull, 0);
  EXPECT_GT(drive.driving_torque, 0);
  EXPECT_LT(brake.driving_torque, 0);
  // Sliding to the left is resisted to the right.
  const auto t = make();
  BodyResult r;
  for (int i = 0; i < 500; ++i)
    r = step_one(*t, 1e-3 * i, 1e-3, arriving(Rolling{0.005, 0.1, 0, 0.3}.at(1e-3 * (i + 1)), 1e-3));
  EXPECT_LT(r.report.side_force, 0);
}

GROUSER_EVERY_MODEL(Contact);

}  // namespace
}  // namespace grouser::test
