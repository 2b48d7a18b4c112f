#include "../../vehicle/src/joint_solver.h"

#include <gtest/gtest.h>

#include <random>

namespace grouser::vehicle {
namespace {

struct Rows {
  btMatrixXu A;
  btVectorXu b, x, lo, hi;
  btAlignedObjectArray<int> dependency;

  explicit Rows(int n) : A(n, n), b(n), x(n), lo(n), hi(n) {
    std::mt19937_64 bits(7);
    std::uniform_real_distribution<double> u(-1, 1);
    Eigen::MatrixXd G = Eigen::MatrixXd::NullaryExpr(n, n + 10, [&] { return u(bits); });
    const Eigen::MatrixXd S = G * G.transpose();
    dependency.resize(n, -1);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A.setElem(i, j, S(i, j));
      b[i] = u(bits);
      x[i] = 0;
      lo[i] = -SIMD_INFINITY;
      hi[i] = SIMD_INFINITY;
    }
  }
  double residual(int i) const {  // A x - b of one row
    double r = -b[i];
    for (int j = 0; j < b.rows(); ++j) r += A(i, j) * x[j];
    return r;
  }
  bool solve() { return JointSolver().solveMLCP(A, b, x, lo, hi, dependency, 50, true); }
};

TEST(JointSolver, EquationsHold) {
  Rows r(20);
  ASSERT_TRUE(r.solve());
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(r.residual(i), 0, 1e-12);
}

TEST(JointSolver, ARowWithALimitStopsThereAndTheOthersStillHold) {
  Rows free(20), r(20);
  ASSERT_TRUE(free.solve());
  r.hi[3] = free.x[3] - 0.1;
  ASSERT_TRUE(r.solve());
  for (int i = 0; i < 20; ++i) {
    if (i == 3) continue;
    EXPECT_NEAR(r.residual(i), 0, 1e-11);
  }
  EXPECT_NEAR(r.x[3], r.hi[3], 1e-12);
  EXPECT_LT(r.residual(3), 0) << "the row pushes against its limit";
}

TEST(JointSolver, ARowThatIsThereTwiceIsLeftToTheSolverThatPivots) {
  Rows r(6);
  for (int j = 0; j < 6; ++j) r.A.setElem(5, j, r.A(4, j));
  for (int i = 0; i < 6; ++i) r.A.setElem(i, 5, r.A(i, 4));
  r.b[5] = r.b[4];
  btDantzigSolver dantzig;
  Rows d = r;
  EXPECT_EQ(r.solve(), dantzig.solveMLCP(d.A, d.b, d.x, d.lo, d.hi, d.dependency, 50, true));
  for (int i = 0; i < 6; ++i) EXPECT_EQ(r.x[i], d.x[i]);
}

}  // namespace
}  // namespace grouser::vehicle
