// Pieces of the diagnosis against closed forms, published figures and dense algebra.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "../../diagnosis/src/bench_check.h"
#include "../../diagnosis/src/importance.h"
#include "../../diagnosis/src/lack_of_fit.h"
#include "../../diagnosis/src/replicates.h"
#include "grouser/diagnosis/design.h"
#include "grouser/terrain/config.h"

namespace grouser::diagnosis {
namespace {

// Holm (1979): the smallest p times the number of tests, the next times one less, never falling.
TEST(Holm, StepsDownAndNeverFalls) {
  std::vector<FitTest> t(4);
  t[0].p = 0.01, t[1].p = 0.04, t[2].p = 0.03, t[3].p = 0.005;
  adjust_holm(t);
  EXPECT_DOUBLE_EQ(t[3].holm, 0.02);
  EXPECT_DOUBLE_EQ(t[0].holm, 0.03);
  EXPECT_DOUBLE_EQ(t[2].holm, 0.06);
  EXPECT_DOUBLE_EQ(t[1].holm, 0.06);  // 0.04 alone would be less than the step before
}

// + + - - + - + + - -: 5 plus, 5 minus, 6 runs; mean 6, so z = 0. Ten that alternate: 10 runs, variance 20/9, z = 4/sqrt(20/9).
TEST(RunsTest, CountsRunsOfEqualSign) {
  EXPECT_DOUBLE_EQ(runs_z({1, 2, -1, -2, 3, -1, 1, 1, -1, -1}), 0);
  EXPECT_NEAR(runs_z({1, -1, 1, -1, 1, -1, 1, -1, 1, -1}), 4 / std::sqrt(20.0 / 9), 1e-12);
}

// 1, -1, 1, -1: r1 = -3/4, r2 = 2/4; Q = 4 * 6 * (9/16/3 + 1/4/2) = 7.5.
TEST(LjungBox, AgreesWithFourValuesByHand) { EXPECT_NEAR(ljung_box({1, -1, 1, -1}, 2), 7.5, 1e-12); }

Run run_of(double slip, double load, int batch, int condition) {
  Run r;
  r.slip = slip, r.load = load, r.omega = 0.3, r.batch = batch, r.condition = condition;
  r.value.fill(0);
  return r;
}

TEST(Whitener, IsTheInverseRootOfTheDenseCovariance) {
  std::vector<diagnosis::Run> runs;
  for (int i = 0; i < 6; ++i) runs.push_back(run_of(0.1 * i, 100, i / 2, i));  // two runs share a preparation
  const std::vector<std::array<double, channel_count>> sd(6, {2, 0.2, 0.0015});
  const DataLayout layout(runs, sd);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd J(layout.size(), 2), r(layout.size(), 1);
  for (int i = 0; i < layout.size(); ++i)
    J(i, 0) = normal(random) * layout[i].sd * 9, J(i, 1) = normal(random) * layout[i].sd * 20, r(i, 0) = layout[i].sd;
  Noise noise;
  noise.scale = {1.2, 0.8, 1.1}, noise.omega = {0.06, 0.014}, noise.weight = {1, 1, 0.3, 1, 1, 1};
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    for (int j = 0; j < layout.size(); ++j)
      if (layout[i].run / 2 == layout[j].run / 2) C(i, j) = 0.0036 * J(i, 0) * J(j, 0) + 0.000196 * J(i, 1) * J(j, 1);
    const double s = noise.scale[static_cast<std::size_t>(layout[i].channel)] * layout[i].sd;
    C(i, i) += s * s / noise.weight[static_cast<std::size_t>(layout[i].run)];
  }
  const Whitener w(layout, noise, J);
  Eigen::MatrixXd u = r;
  w.apply(u);
  EXPECT_NEAR(u.squaredNorm(), r.col(0).dot(C.inverse() * r.col(0)), 1e-9 * u.squaredNorm());
  EXPECT_NEAR(w.log_determinant(), std::log(C.determinant()), 1e-9 * std::abs(w.log_determinant()));
}

/// 200 runs in a file, order mixed against the rows, with AR(1) errors of unit size along the order in each channel.
struct Remembering {
  std::vector<diagnosis::Run> runs;
  std::vector<std::array<double, channel_count>> sd;
  std::vector<int> place;  ///< of each run in the order
  std::array<std::vector<double>, channel_count> error;
};
Remembering remembering(double rho, unsigned seed) {
  Remembering out;
  const int n = 200;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < n; ++i) out.place.push_back((i * 37) % n);
  for (auto& e : out.error)
    for (int i = 0; i < n; ++i)
      e.push_back(i == 0 ? normal(random) : rho * e.back() + std::sqrt(1 - rho * rho) * normal(random));
  for (int i = 0; i < n; ++i) {
    diagnosis::Run r = run_of(0.1, 100, i, i);
    r.line = i + 2, r.order = out.place[static_cast<std::size_t>(i)] / (n - 1.0);
    out.runs.push_back(r), out.sd.push_back({2, 0.2, 0.0015});
  }
  return out;
}

// Dense covariance sd_i sd_j rho^|places apart| within a channel; nothing scatters between preparations.
TEST(Whitener, KnowsNoiseThatRemembersTheLastRun) {
  const Remembering x = remembering(0, 1);
  const DataLayout layout(x.runs, x.sd);
  Noise noise;
  noise.rho = 0.4, noise.weight.assign(x.runs.size(), 1);
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(layout.size(), layout.size()), r(layout.size(), 1);
  for (int i = 0; i < layout.size(); ++i) {
    r(i, 0) = layout[i].sd * normal(random);
    for (int j = 0; j < layout.size(); ++j)
      if (layout[i].channel == layout[j].channel)
        C(i, j) = layout[i].sd * layout[j].sd *
                  std::pow(0.4, std::abs(x.place[static_cast<std::size_t>(layout[i].run)] -
                                         x.place[static_cast<std::size_t>(layout[j].run)]));
  }
  const Whitener w(layout, noise, Eigen::MatrixXd::Zero(layout.size(), 2));
  Eigen::MatrixXd u = r;
  w.apply(u);
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  const double ln_det = 2 * llt.matrixLLT().diagonal().array().log().sum();
  EXPECT_NEAR(u.squaredNorm(), r.col(0).dot(llt.solve(r.col(0))), 1e-9 * u.squaredNorm());
  EXPECT_NEAR(w.log_determinant(), ln_det, 1e-9 * std::abs(ln_det));
}

// 594 differences: the standard error of rho is 2 sqrt(1/(2 594)) = 0.06; four of them. White noise is left white.
TEST(Memory, IsFoundFromFirstDifferencesWhateverChangesSlowly) {
  for (const double rho : {0.0, 0.4}) {
    const Remembering x = remembering(rho, 5);
    const DataLayout layout(x.runs, x.sd);
    Eigen::VectorXd u(layout.size());
    for (int i = 0; i < layout.size(); ++i) {
      const int at = x.place[static_cast<std::size_t>(layout[i].run)];
      u[i] = x.error[static_cast<std::size_t>(layout[i].channel)][static_cast<std::size_t>(at)] + std::sin(0.03 * at);
    }
    if (rho == 0)
      EXPECT_EQ(run_to_run(layout, u), 0);
    else
      EXPECT_NEAR(run_to_run(layout, u), rho, 0.24);
  }
}

// Int x^a exp(-x) dx = Gamma(a + 1): exactly 1 at a = 1, where the normal at the mode says exp(-1) sqrt(2 pi) = 0.922. Proposals of unit
// sd around 1 with heavy tails: the weights vary by about their mean, so 4000 draws know the mean to 2 %.
TEST(Importance, AgreesWithTheGammaFunction) {
  Eigen::VectorXd mode(1);
  mode << 1;
  const Integral z = importance_integral(
      mode, Eigen::MatrixXd::Identity(1, 1),
      [](const Eigen::VectorXd& x) { return x[0] > 0 ? std::log(x[0]) - x[0] : -INFINITY; }, 4000);
  EXPECT_NEAR(std::exp(z.ln), 1, 0.06);
  EXPECT_NEAR(std::exp(z.ln_normal), 0.9221, 1e-4);
  EXPECT_GT(z.effective, 1000);
}

// Two parameters on a bent ridge that a bound cuts: 400 by 400 points of a grid against 4000 draws; the normal at the mode is off by half.
TEST(Importance, AgreesWithDenseQuadratureOfABentRidge) {
  const auto ln_density = [](const Eigen::VectorXd& x) {
    const double b = x[1] - 0.4 * x[0] * x[0];
    return x[0] < -0.5 ? -static_cast<double>(INFINITY) : -0.5 * (x[0] * x[0] / 1.5 + b * b / 0.3);
  };
  double sum = 0;
  const double h = 0.02;
  Eigen::VectorXd x(2);
  for (x[0] = -0.5 + 0.5 * h; x[0] < 8; x[0] += h)
    for (x[1] = -4; x[1] < 16; x[1] += h) sum += h * h * std::exp(ln_density(x));
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(2, 2);
  V(0, 0) = 1.5, V(1, 1) = 0.3;
  const Integral z = importance_integral(Eigen::VectorXd::Zero(2), V, ln_density, 4000);
  EXPECT_NEAR(z.ln, std::log(sum), 0.08);
  EXPECT_GT(std::abs(z.ln_normal - std::log(sum)), 0.3);
}

// 60 conditions, three repeats, ln k scattering by 8 % and phi by 0.015: sd of an estimate from 120 contrasts is 6.5 %; 25 % is four of them.
// The misfit of 50 sd that all repeats share must not enter.
TEST(Replicates, FindTheScatterWhateverTheModelMisses) {
  std::vector<diagnosis::Run> runs;
  std::vector<std::array<double, channel_count>> sd;
  for (int c = 0; c < 60; ++c)
    for (int k = 0; k < 3; ++k) runs.push_back(run_of(0.01 * c, 100, 3 * c + k, c)), sd.push_back({2, 0.2, 0.0015});
  const DataLayout layout(runs, sd);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd J(layout.size(), 2);
  Eigen::VectorXd r(layout.size());
  std::array<double, 2> shift{};
  for (int i = 0; i < layout.size(); ++i) {
    const int condition = layout[i].run / 3;
    if (i % 3 == 0) shift = {0.08 * normal(random), 0.015 * normal(random)};
    J(i, 0) = layout[i].sd * 40 * std::cos(condition + layout[i].channel);
    J(i, 1) = layout[i].sd * 200 * std::sin(condition + 2.0 * layout[i].channel);
    r[i] = layout[i].sd * (normal(random) + 50) + J(i, 0) * shift[0] + J(i, 1) * shift[1];
  }
  const auto found = replicates(runs, layout, J, r, 30);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->layout.size(), 60 * 2 * 3);
  const Noise n = fit_noise(found->layout, found->contrast, found->slopes, {}, {true, true, true}, true, 0);
  EXPECT_NEAR(n.omega[0], 0.08, 0.25 * 0.08);
  EXPECT_NEAR(n.omega[1], 0.015, 0.25 * 0.015);
  for (const double s : n.scale) EXPECT_NEAR(s, 1, 0.2);
}

// Amplitude 10 errors away and known well: always settled. No larger than the error: odds of 10 for nothing need more than is there.
TEST(BenchCheck, SettlesWhatIsLargeAgainstItsError) {
  EXPECT_GT(bench_chance(10, 0.1, 1), 0.99);
  EXPECT_LT(bench_chance(1, 0.1, 1), 0.3);
}

// 3 speeds and 2 passes are one wheel to the plain law: worked out once or six times, the same bits.
TEST(ManyRuns, GiveTheBitsOfEachRunAlone) {
  const bekker::EffectWheel wheel{0.13, 0.16, 0.16, {}};
  std::vector<diagnosis::Run> runs;
  for (const double slip : {-0.5, 0.0, 0.3})
    for (const double omega : {0.1, 0.9})
      for (const int pass : {1, 2}) {
        runs.push_back(run_of(slip, 115, 0, 0));
        runs.back().omega = omega, runs.back().pass = pass, runs.back().order = 0.2;
      }
  Inputs in = plain_inputs({std::log(254.1e3), 1.387, 139.28, 0.606, std::log(0.5151e-3), 0.18, 0.32});
  for (const auto effect :
       {bekker::Effect::bulldozing, bekker::Effect::shear_rate, bekker::Effect::repetitive_loading}) {
    Inputs with = in;
    with[static_cast<std::size_t>(input_of(effect))] = 0.03;
    std::vector<double> theta;
    std::vector<Outputs> y;
    std::vector<Slopes> d;
    ASSERT_TRUE(model_runs(wheel, runs, std::vector<Inputs>(runs.size(), with), Wanted::all, {}, theta, y, &d));
    for (std::size_t r = 0; r < runs.size(); ++r) {
      double t = 0;
      Outputs alone;
      Slopes slopes;
      ASSERT_TRUE(model_run(wheel, runs[r], with, Wanted::all, {}, t, alone, &slopes));
      EXPECT_EQ(alone, y[r]);
      EXPECT_EQ(slopes, d[r]);
    }
  }
}

DiagnosisCase reference() {
  DiagnosisCase c;
  c.model = "bekker.steady";
  c.wheel = {0.13, 0.16, 0.16, {}};
  const double mean[] = {std::log(254.1e3), 1.387, 139.28, 0.606, std::log(0.5151e-3), 0.18, 0.32},
               sd[] = {0.3, 0.14, 415, 0.0502, 1, 0.2, 0.2};
  for (std::size_t i = 0; i < soil_count; ++i) c.soil[i] = {mean[i], sd[i]};
  c.effects = {"torque_offset", "torque_viscous", "torque_bearing", "drawbar_bias"};
  return c;
}

double likeness(const Design& d, const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  for (std::size_t k = 0; k < d.effects.size(); ++k) {
    if (d.effects[k].id == a) i = k;
    if (d.effects[k].id == b) j = k;
  }
  return d.likeness[i][j];
}

constexpr const char* errors = " drawbar_sd_N=2 torque_sd_Nm=0.2 sinkage_sd_m=0.0015";

// At one load and one speed an offset, a friction by speed and one by load add the same torque to every run.
TEST(DesignOfAnExperiment, OneLoadAndOneSpeedCannotTellTorqueErrorsApart) {
  const Design d = judge_design(reference(), grid_plan(std::string("slip=-0.3,0,0.3,0.6 load_N=115") + errors));
  EXPECT_NEAR(likeness(d, "torque_offset", "torque_viscous"), 1, 1e-9);
  EXPECT_NEAR(likeness(d, "torque_offset", "torque_bearing"), 1, 1e-9);
  ASSERT_EQ(d.clusters.size(), 1U);
  EXPECT_EQ(d.clusters[0].size(), 3U);
  EXPECT_EQ(d.alike_pairs, 3U);
  ASSERT_FALSE(d.add.empty());
  EXPECT_LT(d.add[0].alike_pairs, 3U);
}

// No soil value depends on speed, so only w - mean(w) tells friction from an offset: two speeds 0.1 and 0.9 leave |cos| = 0.5/sqrt(0.41).
TEST(DesignOfAnExperiment, TwoSpeedsTellFrictionFromAnOffset) {
  DiagnosisCase c = reference();
  for (SoilPrior& p : c.soil) p.sd = 0;  // held: the cosine is that of the columns themselves
  const Design d = judge_design(c, grid_plan(std::string("slip=0,0.3 load_N=115 omega_rad_s=0.1,0.9") + errors));
  EXPECT_NEAR(likeness(d, "torque_offset", "torque_viscous"), 0.5 / std::sqrt(0.41), 1e-9);
}

// With the soil held, four repeats of four runs see a bias of 2 N at d = 2/2 sqrt(16), and d = 6 at 3 N.
TEST(DesignOfAnExperiment, TheSmallestSizeFollowsTheNoise) {
  DiagnosisCase c = reference();
  for (SoilPrior& p : c.soil) p.sd = 0;
  const Design d = judge_design(c, grid_plan(std::string("slip=-0.3,0,0.3,0.6 load_N=115 repeats=4") + errors));
  for (const DesignEffect& e : d.effects)
    if (e.id == "drawbar_bias") {
      EXPECT_NEAR(e.distance, 4, 1e-6);
      EXPECT_NEAR(e.smallest, 3, 1e-6);
    }
}

TEST(DesignOfAnExperiment, AGridWithAMistakeIsExplained) {
  for (const char* text :
       {"slpi=0 load_N=1", "slip=a load_N=1", "slip=0", "slip=0 load_N=100", "slip=2 load_N=1 drawbar_sd_N=1"})
    EXPECT_THROW(grid_plan(text), ConfigError) << text;
}

}  // namespace
}  // namespace grouser::diagnosis
