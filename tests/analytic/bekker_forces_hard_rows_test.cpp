// Rows of 1,000,000 random ones on which the quadrature once broke its tolerance, with what went wrong and by how much.
#include <gtest/gtest.h>

#include "bekker_random_rows.h"

namespace grouser::bekker {
namespace {

using test_rows::gap_of;
using test_rows::WrittenOut;
using Type = ShearLaw::Type;

struct Row {
  Type type;
  bool anisotropic;
  WheelSize wheel;
  double modulus, n, cohesion, tan_phi, K, Kr;
  ArcAngles arc;
  double slip, slip_angle, unloading_sinkage, ko, Au;
};
const std::vector<Row>& hard_rows() {
  // clang-format off
  static const std::vector<Row> rows{
      // type B dies out within 1/800 of the arc: 3.0e-6 at 1e-6
      {Type::B, false, {0.1372451, 0.3770374, 0, 0}, 1233824, 0.3914493, 0, 0.3951447, 0.000159563, 0.7759631,
       {1.241495, 0, 0}, 0.70513950536, 0, 0, 0, 0},
      // the same with cohesion: 1.3e-6 at 1e-6
      {Type::B, false, {0.06991327, 0.1357298, 0, 0}, 138905.1, 0.5223105, 3944.45, 0.4639206, 8.384393e-05,
       0.3559475, {1.205297, 0, 0}, 0.66483875631, -0.226047, 0, 0, 0},
      // the same in a batch, whose moment is the layer's alone: 3.8e-6 at 1e-6
      {Type::B, false, {0.1765275, 0.3020774, 0, 0}, 433122.9, 1.98834, 0, 0.1959325, 0.0004181327, 0.5831284,
       {1.083744, 0.2920973, -0.65003}, 0.017228689499, 0.1943324, 0, 0, 0},
      // the same, cut at the turn of the shear: 3.2e-6 in a batch
      {Type::B, false, {0.3561592, 0.290362, 0, 0}, 704702.1, 1.896692, 0, 0.3236744, 0.001735918, 0.3959273,
       {1.334961, 0.2186447, 0}, 0.2332093831, 0.06841218, 0, 0, 0},
      // nearly locked: all shear within 1e-8 rad, missed by two rules in a row: moment off by 100 %
      {Type::B, false, {0.4933513, 0.07768911, 0, 0}, 182434.4, 1.268725, 2677.68, 0.5044647, 0.0006805449,
       0.7499717, {1.023892, 0.3079989, 0}, -0.99998833416, 0, 0, 0, 0},
      // the same, anisotropic
      {Type::B, true, {0.09712663, 0.1687976, 0, 0}, 421255.6, 1.240935, 2188.08, 0.576479, 0.0001140704, 0.5342791,
       {0.1786842, 0.05741915, -0.0360979}, -0.99999548229, -0.550745, 0, 0, 0},
      // eight points on a rear branch of 1.7 rad with a low exponent: 3.1e-6 at 1e-6
      {Type::A, false, {0.2364623, 0.2581807, 0, 0}, 1083813, 0.6128725, 779.3597, 0.614411, 0.0008945019, 0.4664651,
       {1.267622, 0.8042102, -0.9121426}, 0.56527275928, -0.3080226, 0, 0, 0},
      // the same: 1.5e-6
      {Type::A, false, {0.5471645, 0.1809349, 0, 0}, 609411.2, 0.6257725, 4528.428, 0.2301364, 0.0005997919,
       0.3686078, {1.234646, 0.8402497, -0.7523715}, 0.58667090398, 0.4504327, 0, 0, 0},
      // the same: 1.6e-6
      {Type::A, false, {0.4870941, 0.1582108, 0, 0}, 2227.652, 0.348273, 2597.321, 0.3990172, 0.000877261, 0.5256527,
       {1.147367, 0.7706035, -0.6984501}, 0.32614240861, 0.8515795, 0, 0, 0},
      // virgin soil begins 0.006 rad behind the entry, whose root is felt there: 3.1e-6 at 1e-6
      {Type::A, true, {0.5048163, 0.398551, 0, 0}, 234353.7, 0.4949492, 1983.275, 0.5430792, 0.1282141, 0.9854707,
       {0.1811873, 0, 0}, 0.010325784114, 0, 0.0005567923, 1.658361e+07, 2.277074e+10},
      // two rules agree by chance: 1.3e-8 at 1e-8
      {Type::B, false, {0.227652, 0.1210853, 0.02277872, 0}, 3140.93, 1.168432, 0, 0.4214815, 0.0005867682,
       0.5726967, {1.350742, 0.2992208, -0.1676324}, -0.43898747003, 0.001738128, 0, 0, 0},
      // the same: 1.2e-8
      {Type::A, false, {0.4137634, 0.1081297, 0.004886399, 0.6684818}, 8862236, 1.081903, 271.1109, 0.3731006,
       0.00114471, 0.9460858, {1.466828, 0, 0}, 6.955781822e-05, 0, 0, 0, 0},
      // the same: 1.6e-9 at 1e-10
      {Type::C, false, {0.5835557, 0.2396917, 0, 0}, 208113, 0.7971463, 0, 0.7834678, 0.05241518, 0.3139285,
       {1.400954, 0.5138771, -1.147197}, -0.24474898002, 5.016454e-05, 0.3169419, 0, 249109},
      // touches over 1e-4 rad, whose ends were known to 6e-15 rad only: 1.3e-10 at 1e-10
      {Type::B, true, {0.06524129, 0.1668607, 0.01086224, 0.4435568}, 556895.3, 1.023264, 3962.194, 0.401188,
       0.001432288, 0.6705224, {0.03295167, 0.01933628, -0.02749395}, -0.94145062822, 0, 3.604636e-05, 0,
       4.877914e+10},
      // theta_m close to theta_f: shear builds up behind it, where too few points stood: 5.3e-6 at 1e-6
      {Type::A, false, {0.5993770509, 0.5993770509, 0, 0}, 1588068.357, 0.6334768442, 1048.492915, 0.8246428168, 0.001606364207, 0.6,
       {0.1772866561, 0.159378349, -0.06925235916}, 0.6127168985, -0.147142911, 0, 0, 0},
      // the same: 3.5e-5
      {Type::A, false, {0.1425159567, 0.1425159567, 0, 0}, 608112.0232, 0.4958205056, 749.7655131, 0.1285681312, 0.002071665795, 0.6,
       {0.923826372, 0.8744432302, -0.2623206166}, 0.5542846715, 0.184270327, 0, 0, 0},
      // the same: 4.6e-4
      {Type::A, false, {0.453253036, 0.453253036, 0, 0}, 171149.3627, 0.7980558153, 233.9431232, 0.5503528611, 0.002120464514, 0.6,
       {1.005141482, 0.9939863684, -0.3313200203}, 0.5412044285, 0.2874165829, 0, 0, 0},
      // the same: 4.7e-4
      {Type::A, false, {0.4526495398, 0.4526495398, 0, 0}, 735130.0581, 0.7370332438, 533.7993538, 0.3090042833, 0.001154446752, 0.6,
       {0.6717370462, 0.6644770225, -0.1996728958}, 0.3890131226, 0.3879202751, 0, 0, 0},
      // the same, nothing behind the bottom: 3.3e-4
      {Type::A, false, {0.4623499062, 0.4623499062, 0, 0}, 528121.819, 0.6355965816, 122.0915478, 0.4858345178, 0.001824028563, 0.6,
       {0.9385881971, 0.9288474882, 0}, 0.6998859072, -0.3158973869, 0, 0, 0},
      // the same, braking: 2.7e-6
      {Type::A, false, {0.4556628909, 0.4556628909, 0, 0}, 1595655.245, 0.7693717887, 1952.345556, 0.4270588253, 0.002282144402, 0.6,
       {0.8886150776, 0.8784932166, -0.2745619603}, -0.8201659734, -0.355025199, 0, 0, 0},
  };
  // clang-format on
  return rows;
}
ForceCase case_of(const Row& r) {
  ForceCase c;
  c.wheel = r.wheel;
  c.soil.modulus = r.modulus;
  c.soil.n = r.n;
  c.soil.shear = {r.type, r.cohesion, std::atan(r.tan_phi), r.K, r.K, r.Kr};
  c.soil.tan_phi = r.tan_phi;
  c.soil.lateral = r.anisotropic ? Lateral::anisotropic : Lateral::isotropic;
  c.soil.ko = r.ko;
  c.soil.Au = r.Au;
  c.arc = r.arc;
  c.slip = r.slip;
  c.slip_angle = r.slip_angle;
  c.unloading_sinkage = r.unloading_sinkage;
  return c;
}

TEST(HardRows, MeetTheToleranceAloneAndInABatch) {
  std::vector<ForceCase> cases;
  for (const Row& r : hard_rows()) cases.push_back(case_of(r));
  std::vector<ForceResult> together(cases.size());
  std::vector<std::array<double, 6>> truth;
  for (const ForceCase& c : cases) truth.push_back(WrittenOut(c).integral());
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10}) {
    forces(cases, Method::nonlinear, tolerance, together);
    for (std::size_t i = 0; i < cases.size(); ++i)
      for (const ForceResult& r : {forces(cases[i], Method::nonlinear, tolerance), together[i]}) {
        const auto gap = gap_of(r.wrench, truth[i], cases[i].wheel.outer_radius());
        EXPECT_EQ(r.status, ForceStatus::ok) << "row " << i << " at " << tolerance;
        EXPECT_LE(gap.force, tolerance) << "row " << i;
        EXPECT_LE(gap.moment, tolerance) << "row " << i;
      }
  }
}

TEST(TurnOverNextToTheEntry, IsFoundByQuadratureAndReferenceAlike) {
  // Braking on 76 degrees of contact turns the sliding over 0.002 rad behind the entry and j_t changes sign after as
  // much again. The moment is that of the layer near the entry alone: behind it shear of type B has died out. A
  // reference that takes no heed of the change of sign is off by 2.9e-10. Moment in quadruple precision: 30 Gauss points
  // on each of nine parts of panels that halve towards every kink.
  ForceCase c;
  c.wheel = {0.12895252929137757, 0.27253596824676862};
  c.soil.modulus = 43191.178082600032;
  c.soil.n = 0.54163873577798971;
  c.soil.shear = {Type::B, 0, 0.5, 0.00023424213501194272, 0.00023424213501194272, 1};
  c.soil.tan_phi = 0.57069198071269445;
  c.arc = {1.3235664986609297, 0.44945292786817959, 0};
  c.slip = -0.7533557548244596;
  const double moment = 0.21562026977655985;
  EXPECT_NEAR(WrittenOut(c).integral()[4], moment, 1e-13 * moment);
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const ForceResult r = forces(c, Method::nonlinear, tolerance);
    EXPECT_EQ(r.status, ForceStatus::ok) << tolerance;
    EXPECT_NEAR(r.wrench.My, moment, tolerance * moment);
  }
}

TEST(NearPureRolling, SaysSoWhereRoundingLeavesMoreThanTheTolerance) {
  // 1.2 degrees of contact at slip -4e-6: j is 1e-8 K, the difference of two paths a million times as long, and the
  // moment is that of the cohesion alone. 1e-8 is met, 1e-10 cannot be in double, with any rule.
  ForceCase c;
  c.wheel = {0.3, 0.1};
  c.soil.modulus = 1e5;
  c.soil.n = 1.8;
  c.soil.shear = {Type::A, 1000, 0.5, 0.2, 0.2, 1};
  c.soil.tan_phi = std::tan(0.5);
  c.arc = {0.02, 0.002, -0.016};
  c.slip = -4e-6;
  const std::array<double, 6> truth = WrittenOut(c).integral();
  for (const double tolerance : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const ForceResult r = forces(c, Method::nonlinear, tolerance);
    const auto gap = gap_of(r.wrench, truth, c.wheel.radius);
    const bool met = gap.force <= tolerance && gap.moment <= tolerance;
    EXPECT_TRUE(met || r.status == ForceStatus::tolerance_not_met) << tolerance << ": " << gap.moment;
    EXPECT_TRUE(tolerance < 1e-8 || r.status == ForceStatus::ok) << tolerance;
  }
  EXPECT_EQ(forces(c, Method::nonlinear, 1e-12).status, ForceStatus::tolerance_not_met);
}

}  // namespace
}  // namespace grouser::bekker
