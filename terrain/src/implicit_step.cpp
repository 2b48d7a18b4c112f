#include "grouser/bullet/implicit_step.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace grouser::bullet {

namespace {

/// A x = b by elimination of whole 6 x 6 blocks, A row by row, x in b. Half the time of one dense LU of unknown size. Returns det A.
/// Pivots are sought inside the blocks only: each is the identity plus a contact that others hold, never small when the step is sound.
double solve_blocks(std::vector<Mat6>& A, std::vector<Vec6>& b) {
  const std::size_t n = b.size();
  double determinant = 1;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::PartialPivLU<Mat6> lu(A[k * n + k]);
    determinant *= lu.determinant();
    const Mat6 inverse = lu.inverse();
    for (std::size_t j = k + 1; j < n; ++j) A[k * n + j] = Mat6(inverse * A[k * n + j]);
    b[k] = Vec6(inverse * b[k]);
    for (std::size_t i = k + 1; i < n; ++i) {
      for (std::size_t j = k + 1; j < n; ++j) A[i * n + j].noalias() -= A[i * n + k] * A[k * n + j];
      b[i].noalias() -= A[i * n + k] * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;)
    for (std::size_t j = k + 1; j < n; ++j) b[k].noalias() -= A[k * n + j] * b[j];
  return determinant;
}

}  // namespace

bool implicit_impulses(std::vector<WheelStep>& wheels, const Eigen::MatrixXd& W, double dt) {
  for (WheelStep& w : wheels) {
    w.impulse = w.raw;
    w.released = false;
  }
  std::vector<Mat6> A;
  std::vector<Vec6> J;
  std::vector<std::size_t> active;
  const auto mobility = [&W](std::size_t i, std::size_t j) {
    return W.block<6, 6>(6 * static_cast<Eigen::Index>(i), 6 * static_cast<Eigen::Index>(j));
  };
  for (std::size_t pass = 0; pass <= wheels.size(); ++pass) {
    active.clear();
    for (std::size_t i = 0; i < wheels.size(); ++i)
      if (wheels[i].linearised && !wheels[i].released) active.push_back(i);
    if (active.empty()) return true;
    const std::size_t n = active.size();
    A.resize(n * n);
    J.resize(n);
    for (std::size_t r = 0; r < n; ++r) {
      const WheelStep& w = wheels[active[r]];
      const Mat6 B = dt * (dt * w.K + w.D);
      Vec6 u = w.dv;  // V - v without the unknown impulses
      for (std::size_t j = 0; j < wheels.size(); ++j)
        if (!wheels[j].linearised) u += mobility(active[r], j) * wheels[j].raw;
      J[r] = w.raw + B * u + dt * dt * (w.K * w.v);
      for (std::size_t c = 0; c < n; ++c) A[r * n + c].noalias() = -(B * mobility(active[r], active[c]));
      A[r * n + r].diagonal().array() += 1.0;
    }
    if (!(solve_blocks(A, J) > 0)) return false;
    bool again = false;
    for (std::size_t r = 0; r < n; ++r) {
      if (!J[r].allFinite()) return false;
      WheelStep& w = wheels[active[r]];
      w.impulse = J[r];
      if (w.raw[2] > 0 && w.impulse[2] <= 0) {
        w.impulse.setZero();
        w.released = again = true;
      }
    }
    if (!again) return true;
  }
  return true;
}

double explicit_step_ratio(const Mat6& K, const Mat6& D, const Mat6& W, double dt) {
  const auto radius = [](const Eigen::MatrixXd& M) {
    return Eigen::EigenSolver<Eigen::MatrixXd>(M, false).eigenvalues().cwiseAbs().maxCoeff();
  };
  return std::max(std::sqrt(radius(dt * dt * K * W)), radius(dt * D * W));
}

Eigen::MatrixXd joint_mobility(const std::vector<Mat6>& inverse_mass, const Eigen::MatrixXd& G,
                               const Eigen::VectorXd& cfm, const std::vector<Eigen::Index>& wheels) {
  const auto nw = static_cast<Eigen::Index>(wheels.size());
  const auto nb = static_cast<Eigen::Index>(inverse_mass.size());
  const Eigen::Index nr = G.rows();
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(6 * nw, 6 * nw);
  for (Eigen::Index w = 0; w < nw; ++w)
    W.block(6 * w, 6 * w, 6, 6) = inverse_mass[static_cast<std::size_t>(wheels[static_cast<std::size_t>(w)])];
  if (nr == 0) return W;

  Eigen::MatrixXd GM(nr, 6 * nb), P(nr, 6 * nw);
  for (Eigen::Index i = 0; i < nb; ++i)
    GM.middleCols(6 * i, 6).noalias() = G.middleCols(6 * i, 6) * inverse_mass[static_cast<std::size_t>(i)];
  Eigen::MatrixXd S = GM * G.transpose();
  // A relative 1e-9 keeps the factor regular when rows are dependent and changes nothing that can be seen.
  const double floor = 1e-9 * S.diagonal().maxCoeff();
  for (Eigen::Index r = 0; r < nr; ++r) S(r, r) += cfm[r] * S(r, r) + floor;
  for (Eigen::Index w = 0; w < nw; ++w)
    P.middleCols(6 * w, 6) = GM.middleCols(6 * wheels[static_cast<std::size_t>(w)], 6);
  W.noalias() -= P.transpose() * S.ldlt().solve(P);
  return W;
}

Eigen::MatrixXd rotate_blocks(const Eigen::MatrixXd& W, const Mat3& R) {
  Eigen::MatrixXd out(W.rows(), W.cols());
  const Eigen::Matrix3d r = R;
  for (Eigen::Index i = 0; i < W.rows(); i += 3)
    for (Eigen::Index j = 0; j < W.cols(); j += 3) out.block<3, 3>(i, j) = r * W.block<3, 3>(i, j) * r.transpose();
  return out;
}

}  // namespace grouser::bullet
