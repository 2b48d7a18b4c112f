// Fingerprint of each effect of bekker.steady: the stresses of its formula, written down here once more and summed by the midpoint
// rule over 40000 points. No code of the model takes part in the expected values.
#include <gtest/gtest.h>

#include "effects/roll.h"

namespace grouser::test {
namespace {

/// Driven wheel, smooth, type A, no slip angle.
struct Written {
  double k = 254.1e3, n = 1.387, b = 0.16, c = 139.28, tan_phi = std::tan(0.606), K = 5.151e-4;
  double r = 0.13, width = 0.16, R = 0.13, theta_f = 0, theta_m = 0, theta_r = 0, omega = 0, v = 0;
  std::function<double(double, double)> pressure = [](double, double) { return 1.0; };  // of z, theta
  std::function<double(double, double)> shear = [](double, double) { return 1.0; };     // of j, v_j
  double pushed = 0;                                                                    // against the travel [N]

  Rolled sum() const {
    Rolled out{-pushed, 0, 0, 0};
    const auto add = [&](double theta, double weight) {
      const double te =
          theta > theta_m ? theta : theta_f - (theta - theta_r) / (theta_m - theta_r) * (theta_f - theta_m);
      const double z = r * (std::cos(te) - std::cos(theta_f));
      const double sigma = k * std::pow(z / b, n) * pressure(z, theta);
      const double j = R * (theta_f - theta) - v / omega * (std::sin(theta_f) - std::sin(theta));
      const double v_j = R * omega - v * std::cos(theta);
      const double tau = (c + sigma * tan_phi) * (1 - std::exp(-j / K)) * shear(j, v_j);
      out.drawbar += weight * width * (R * tau * std::cos(theta) - r * sigma * std::sin(theta));
      out.normal += weight * width * (R * tau * std::sin(theta) + r * sigma * std::cos(theta));
      out.torque += weight * width * R * R * tau;
    };
    const int points = 20000;
    for (int i = 0; i < points; ++i) {  // squares put the points towards the ends, where the pressure starts
      const double y = (i + 0.5) / points, x = y * y, weight = 2 * y / points;
      add(theta_f - x * (theta_f - theta_m), weight * (theta_f - theta_m));
      add(theta_r + x * (theta_m - theta_r), weight * (theta_m - theta_r));
    }
    return out;
  }
};

struct Case {
  const char* id;
  double amplitude;
  std::function<void(Written&, double slip)> changes;
};

constexpr double kV0 = 0.01, kLeast = 1e-3, kRho = 1600, kG = 9.81;

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"slip_sinkage_exponent", 0.77, [](Written& l, double s) { l.n += 0.77 * s; }},
      {"slip_sinkage_factor", 0.7,
       [](Written& l, double s) { l.b *= std::pow((1 + s) / (1 - 0.5 * s), 0.7); }},  // z/Kss^k over b
      {"slip_digging", 0.002,
       [](Written& l, double s) { l.theta_f = std::acos(std::cos(l.theta_f) + 0.002 * s / (1 - s) / l.r); }},
      {"pressure_rate", 0.12,
       [](Written& l, double) {
         l.pressure = [v = l.v](double, double t) { return std::pow(std::max(v * std::sin(t), kLeast) / kV0, 0.12); };
       }},
      {"shear_rate", 0.05,
       [](Written& l, double) {
         l.shear = [](double, double v_j) { return 1 + 0.05 * std::log(std::max(v_j, kLeast) / kV0); };
       }},
      {"repetitive_loading", 0.8, [](Written& l, double) { l.k *= 1.8; }},
      {"pass_strength", 0.1, [](Written& l, double) { l.tan_phi *= 1.1; }},
      {"bulldozing", 1.4,
       [](Written& l, double) {
         const double z = l.r * (1 - std::cos(l.theta_f)), Kp = (1 + std::sin(0.606)) / (1 - std::sin(0.606));
         l.pushed = 1.4 * l.width * (0.5 * kRho * kG * z * z * Kp + 2 * l.c * z * std::sqrt(Kp));
       }},
      {"side_wall", 3,
       [](Written& l, double) {
         const double z = l.r * (1 - std::cos(l.theta_f));
         const double segment = l.r * l.r * l.theta_f - (l.r - z) * l.r * std::sin(l.theta_f);
         l.pushed = 3 * segment * (l.c + (1 - std::sin(0.606)) * kRho * kG * z * l.tan_phi);
       }},
      {"lugs", 0.012, [](Written& l, double) { l.R = l.r + 0.006; }},
      {"interface_friction", 0.75, [](Written& l, double) { l.tan_phi *= 0.75; }},
      {"hard_pan", 8, [](Written& l, double) { l.pressure = [](double z, double) { return 1 / (1 - z / 0.125); }; }},
      {"residual_shear", 0.3,
       [](Written& l, double) { l.shear = [](double j, double) { return 1 + 0.3 * std::exp(-j / 0.01); }; }},
      {"contact_angle_curvature", 0.2, [](Written&, double) {}},  // theta_m: below
      {"exit_angle", 0.25, [](Written&, double) {}},              // theta_r: below
      {"plate_size", 0.35, [](Written& l, double) { l.k *= std::pow(l.r * std::sin(l.theta_f) / 0.05, -0.35); }},
      {"preparation_drift", 0.2, [](Written& l, double) { l.k *= 1 + 0.2 * 0.5; }},
  };
  return all;
}

class SteadyEffectFormula : public testing::TestWithParam<std::tuple<int, double>> {};

// Pieces of 20 points across kinks (v_min, the pan's bend is smooth here): 2e-4 of the load; all others 1e-5, which is the midpoint rule's.
TEST_P(SteadyEffectFormula, IsWhatTheModelRollsOn) {
  const Case& c = cases()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  Setting s;
  s.slip = std::get<1>(GetParam());
  s.options = "pass: 2\norder: 0.5\npoints: 24\n";
  s.effects = {{c.id, c.amplitude}};
  Written law;
  law.omega = s.rim_speed / s.radius;
  law.v = travel_speed(s);
  law.theta_f = std::acos(1 - s.sinkage / s.radius);
  const std::string id = c.id;
  c.changes(law, s.slip);
  law.theta_m = (0.18 + 0.32 * s.slip + (id == "contact_angle_curvature" ? 0.2 * s.slip * s.slip : 0)) * law.theta_f;
  law.theta_r = id == "exit_angle" ? -0.25 * law.theta_f : 0;
  const Rolled expected = law.sum(), r = roll(s);
  const double most = (id.ends_with("_rate") ? 2e-4 : 1e-5) * expected.normal;
  EXPECT_NEAR(r.normal, expected.normal, most);
  EXPECT_NEAR(r.drawbar, expected.drawbar, most);
  EXPECT_NEAR(r.torque, expected.torque, most * s.radius);
}

INSTANTIATE_TEST_SUITE_P(Each, SteadyEffectFormula,
                         testing::Combine(testing::Range(0, static_cast<int>(cases().size())),
                                          testing::Values(0.05, 0.3, 0.7)),
                         [](const auto& p) {
                           return std::string(cases()[static_cast<std::size_t>(std::get<0>(p.param))].id) + "_" +
                                  std::to_string(static_cast<int>(100 * std::get<1>(p.param)));
                         });

// Effects by load: the force that the wheel makes is the load in its own formula.
TEST(SteadyEffectsByLoad, ShearModulusGrowsWithTheForceItself) {
  Setting s;
  s.soil.shear.K = 4e-3;
  s.slip = 0.1;
  s.effects = {{"shear_modulus_load", 0.5}};
  const Rolled r = roll(s);
  Setting plain = s;
  plain.effects.clear();
  plain.soil.shear.K = 4e-3 * std::sqrt(r.normal / 100);
  const Rolled expected = roll(plain);
  EXPECT_NEAR(r.normal, expected.normal, 1e-6 * expected.normal);
  EXPECT_NEAR(r.drawbar, expected.drawbar, 1e-6 * expected.normal);
}

TEST(SteadyEffectsByLoad, FlexibleWheelRollsAsALargerOneAtTheSameSpinAndSpeed) {
  Setting s;
  s.effects = {{"flexible_wheel", 0.15}};
  const Rolled r = roll(s);
  Written law;
  law.omega = s.rim_speed / s.radius;
  law.v = travel_speed(s);
  law.r = law.R = 0.13 * (1 + 0.15 * r.normal / 100);
  law.theta_f = std::acos(1 - s.sinkage / law.r);
  law.theta_m = (0.18 + 0.32 * s.slip) * law.theta_f;
  const Rolled expected = law.sum();
  EXPECT_NEAR(r.normal, expected.normal, 1e-5 * expected.normal);
  EXPECT_NEAR(r.drawbar, expected.drawbar, 1e-5 * expected.normal);
  EXPECT_NEAR(r.torque, expected.torque, 1e-5 * expected.normal * 0.13);
}

TEST(SteadyEffectsOfPasses, AreSilentOnTheFirstPassAndOnWheelsThatAreNotNamed) {
  for (const char* id : {"repetitive_loading", "pass_strength"}) {
    Setting plain;
    const Rolled nominal = roll(plain);
    for (const char* options : {"", "pass: 1\n", "pass: {wheel: 1}\n"}) {
      Setting s;
      s.options = options;
      s.effects = {{id, 0.5}};
      EXPECT_NEAR(roll(s).drawbar, nominal.drawbar, 1e-5 * nominal.normal) << id << options;
    }
    Setting second;
    second.options = "pass: {wheel: 2}\n";
    second.effects = {{id, 0.5}};
    EXPECT_GT(std::abs(roll(second).drawbar - nominal.drawbar), 0.01 * nominal.normal) << id;
  }
}

}  // namespace
}  // namespace grouser::test
