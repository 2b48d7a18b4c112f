// The impulses against the equation that defines them, put in again.
#include "grouser/bullet/implicit_step.h"

#include <gtest/gtest.h>

#include <random>

using namespace grouser;
using namespace grouser::bullet;

namespace {

using Full = Eigen::Matrix<double, 6, 6>;

struct Random {
  std::mt19937_64 bits{20261122};
  double operator()(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(bits); }
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return (*this)(-1.0, 1.0); });
  }
};

/// Largest distance from eq 1 over all wheels, relative to the largest impulse.
double defect(const std::vector<WheelStep>& wheels, const Eigen::MatrixXd& W, double dt) {
  const auto n = static_cast<Eigen::Index>(wheels.size());
  Eigen::VectorXd J(6 * n);
  for (Eigen::Index i = 0; i < n; ++i) J.segment(6 * i, 6) = wheels[static_cast<std::size_t>(i)].impulse;
  const Eigen::VectorXd change = W * J;
  double worst = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const WheelStep& w = wheels[static_cast<std::size_t>(i)];
    if (w.released) continue;
    const Vec6 V = w.v + w.dv + change.segment(6 * i, 6);
    const Vec6 want = w.linearised ? Vec6(w.raw + dt * dt * (w.K * V) + dt * (w.D * (V - w.v))) : w.raw;
    worst = std::max(worst, (w.impulse - want).norm());
  }
  return worst / J.norm();
}

TEST(ImplicitImpulses, SolveTheirEquationForOneToSixWheelsSoftAndStiff) {
  Random random;
  int solved = 0;
  for (int k = 0; k < 3000; ++k) {
    const auto n = static_cast<Eigen::Index>(1 + k % 6);
    const Eigen::MatrixXd R = random.matrix(6 * n, 6 * n);
    // Bodies of 0.1 to 1000 kg that others hold; soil from 1e2 to 1e7 N/m with friction that is not symmetric.
    const Eigen::MatrixXd W = std::pow(10.0, random(-3, 1)) * (R * R.transpose()) / static_cast<double>(6 * n);
    std::vector<WheelStep> wheels(static_cast<std::size_t>(n));
    for (WheelStep& w : wheels) {
      const Full S = random.matrix(6, 6);
      const double stiffness = std::pow(10.0, random(2, 7));
      w.linearised = random(0, 1) < 0.8;
      w.K = -stiffness * (S * S.transpose() + 0.2 * random.matrix(6, 6));
      w.D = -std::pow(10.0, random(0, 4)) * (S * S.transpose());
      w.raw = random.matrix(6, 1);
      w.raw[2] = -std::abs(w.raw[2]);  // a contact that does not push is never released
      w.v = 0.1 * random.matrix(6, 1);
      w.dv = 0.01 * random.matrix(6, 1);
    }
    if (!implicit_impulses(wheels, W, 1e-3)) continue;
    ++solved;
    // The matrix of eq 1 reaches condition numbers of 1e8 here.
    ASSERT_LT(defect(wheels, W, 1e-3), 1e-7) << "case " << k;
  }
  EXPECT_GT(solved, 2000);
}

TEST(ImplicitImpulses, AWheelThatWouldBePulledIsLetGoAndTheOthersAreSolvedWithoutIt) {
  std::vector<WheelStep> wheels(2);
  for (WheelStep& w : wheels) {
    w.linearised = true;
    w.K(2, 2) = -1e5;
    w.raw[2] = 0.01;
  }
  wheels[0].v[2] = 1.0;  // leaves at 1 m/s: 10 N less than nothing within a millisecond
  Eigen::MatrixXd W = Eigen::MatrixXd::Identity(12, 12);
  W(2, 8) = W(8, 2) = 0.5;
  ASSERT_TRUE(implicit_impulses(wheels, W, 1e-3));
  EXPECT_TRUE(wheels[0].released);
  EXPECT_TRUE(wheels[0].impulse.isZero(0));
  // J = raw + dt^2 K W J with the other one's impulse zero.
  EXPECT_NEAR(wheels[1].impulse[2], 0.01 / (1 + 0.1), 1e-15);
}

}  // namespace
