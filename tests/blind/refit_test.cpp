// Derivatives, the refit, d and the oracle.
#include <gtest/gtest.h>

#include <cmath>

#include "hidden.h"
#include "oracle.h"

namespace blind {
namespace {

const Wheel wheel;
const Priors priors;

std::vector<PlannedRun> plan(Plan which = Plan::full) {
  Dice dice(7);
  return plan_runs(which, {}, dice);
}

Fingerprint fingerprint(const SoilVector& truth = SoilVector::Zero(), const NoiseModel& noise = {},
                        Plan which = Plan::full) {
  return Fingerprint(wheel, priors, truth, plan(which), noise);
}

Amplitudes only(Id id, double x) {
  Amplitudes out;
  out[id] = x;
  return out;
}

TEST(BlindRefit, DerivativesAreThoseOfTheWholeRun) {
  // Central differences of runs that find their own balance. A step of 1e-4 sd leaves 1e-6 of curvature.
  SoilVector u;
  u << 0.3, -0.2, 0.4, 0.1, 0.2, -0.3, 0.2;
  for (const double slip : {-0.3, 0.0, 0.4}) {
    const Condition run{slip, 170, 0.3, 2};
    const Amplitudes x = only(Id::exit_angle, 0.2);
    const Slopes s = slopes(wheel, priors, u, x, run, Id::exit_angle, 0.5);
    for (int p = 0; p <= kSoilParameters; ++p) {
      const double h = 1e-4;
      Eigen::Vector3d sides[2];
      for (int side = 0; side < 2; ++side) {
        SoilVector v = u;
        Amplitudes more = x;
        (p < kSoilParameters ? v[p] : more[Id::exit_angle]) += side == 0 ? -h : h;
        sides[side] = vector_of(simulate(wheel, soil_of(priors, v), more, run));
      }
      const Eigen::Vector3d expected = (sides[1] - sides[0]) / (2 * h);
      EXPECT_LT((s.by.col(p) - expected).norm(), 3e-3 * expected.norm() + 1e-4)
          << "slip " << slip << " parameter " << p;
    }
  }
}

TEST(BlindRefit, FindsTheSoilThatMadeTheData) {
  SoilVector truth;
  truth << 0.4, -0.3, 0.5, 0.2, 0.3, -0.4, 0.3;
  const std::vector<Observation> rows = grouped(fingerprint(truth).observe({}), uses_none);
  EXPECT_EQ(rows.size(), 36u);
  const Refit found = refit(wheel, priors, rows, SoilVector::Zero());
  // The prior pulls by its own sd over the data's: the misfit stays far below one noise sd in all.
  EXPECT_LT(found.chi2, 0.3);
  EXPECT_LT(found.chi2 + found.penalty, truth.squaredNorm() + 1e-6);
}

TEST(BlindRefit, RecoversAnAmplitudeBesideTheSoil) {
  const std::vector<Observation> rows = fingerprint().observe(only(Id::torque_offset, 0.4));
  const Refit found = refit(wheel, priors, grouped(rows, uses_none), SoilVector::Zero(), {}, Id::torque_offset);
  EXPECT_NEAR(found.x[Id::torque_offset], 0.4, 0.01);
}

TEST(BlindD, DoesNotDependOnTheOrderOfTheRows) {
  std::vector<Observation> rows = fingerprint().observe(only(Id::slip_sinkage_exponent, 0.3));
  const double d = unabsorbed(wheel, priors, rows, SoilVector::Zero());
  Dice dice(3);
  dice.shuffle(rows);
  EXPECT_NEAR(unabsorbed(wheel, priors, rows, SoilVector::Zero()), d, 1e-6 * d);
}

TEST(BlindD, IsAlmostNothingForAParameterShift) {
  // 10 % less friction is one prior sd of phi: 0.4 noise sd over 648 numbers is all that the prior holds back.
  EXPECT_LT(fingerprint().d(only(Id::interface_friction, -0.1)), 0.4);
}

TEST(BlindD, IsTheWholeLengthOfWhatNoNominalParameterCanMove) {
  // A thrust that alternates with the pass has the same mean for each nominal condition: nothing is absorbed.
  std::vector<Observation> rows = fingerprint().observe({});
  for (Observation& o : rows) o.y[0] += o.run.pass == 1 ? 0.5 : -0.5;
  EXPECT_NEAR(unabsorbed(wheel, priors, rows, SoilVector::Zero()), std::sqrt(216.0) * 0.5 / 2.0, 1e-3);
}

TEST(BlindD, NeverExceedsTheLengthBeforeTheRefit) {
  for (const Id id : {Id::exit_angle, Id::lugs, Id::rig_compliance, Id::shear_rate}) {
    const Amplitudes x = only(id, 0.3 * effect(id).typical);
    const std::vector<Observation> with = fingerprint().observe(x), bare = fingerprint().observe({});
    double length = 0;
    for (std::size_t i = 0; i < with.size(); ++i)
      length += (with[i].y - bare[i].y).dot(with[i].weight * (with[i].y - bare[i].y));
    EXPECT_LE(fingerprint().d(x), std::sqrt(length) + 1e-6) << effect(id).name;
  }
}

TEST(BlindD, ScatterOfThePreparationHidesWhatLooksLikeIt) {
  NoiseModel scatter;
  scatter.ln_k_scatter = 0.06;
  scatter.phi_scatter = 0.014;
  const Amplitudes x = only(Id::repetitive_loading, 0.1);
  EXPECT_LT(fingerprint(SoilVector::Zero(), scatter).d(x), 0.7 * fingerprint().d(x));
}

TEST(BlindD, TuningHitsTheWantedLength) {
  const Fingerprint f = fingerprint();
  for (const Id id : {Id::drawbar_gain, Id::bulldozing, Id::pass_strength}) {
    const auto found = tune(f, id, 1.0, 8.0);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(std::log(found->d / 8.0), 0.0, 0.3);
    EXPECT_NEAR(f.d(only(id, found->x)), found->d, 1e-9);
  }
  EXPECT_FALSE(tune(f, Id::interface_friction, -1.0, 8.0).has_value());
}

std::vector<Observation> noisy(const Fingerprint& f, const Amplitudes& x, std::uint64_t seed) {
  std::vector<Observation> rows = f.observe(x);
  Dice dice(seed);
  for (Observation& o : rows)
    for (Eigen::Index c = 0; c < 3; ++c) o.y[c] += dice.normal() / std::sqrt(o.weight(c, c));
  return rows;
}

TEST(BlindOracle, NamesWhatIsThereAndNothingWhereNothingIs) {
  const Fingerprint f = fingerprint();
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Amplitudes x = only(Id::torque_gain, 0.04);
    const OracleAnswer yes = oracle(wheel, priors, noisy(f, x, seed), SoilVector::Zero(), x);
    EXPECT_EQ(yes.top, "torque_gain");
    EXPECT_TRUE(yes.would_name);
    alarms += oracle(wheel, priors, noisy(f, {}, seed), SoilVector::Zero(), {}).would_name ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
}

TEST(BlindOracle, ExactClassesFollowFromThePlan) {
  const auto members = [&](Plan which, Id id, double x) {
    std::vector<std::string> out;
    for (const Id m : exact_class(wheel, fingerprint(SoilVector::Zero(), {}, which).observe({}), Soil{}, id, x))
      out.emplace_back(effect(m).name);
    return out;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(members(Plan::full, Id::torque_offset, 0.3), (Names{"torque_offset"}));
  EXPECT_EQ(members(Plan::constant_speed, Id::torque_offset, 0.3), (Names{"torque_offset", "torque_viscous"}));
  // Friction of a bearing does not push: below zero only the offset is left.
  EXPECT_EQ(members(Plan::constant_speed, Id::torque_offset, -0.3), (Names{"torque_offset"}));
  EXPECT_EQ(members(Plan::constant_load, Id::drawbar_bias, -2), (Names{"drawbar_bias", "bed_slope"}));
  EXPECT_EQ(members(Plan::slip, Id::torque_viscous, 1.0), (Names{"torque_viscous", "torque_offset", "torque_bearing"}));
}

}  // namespace
}  // namespace blind
