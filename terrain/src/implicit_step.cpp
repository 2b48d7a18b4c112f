#include "grouser/bullet/implicit_step.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace grouser::bullet {

bool implicit_impulses(std::vector<WheelStep>& wheels, const Eigen::MatrixXd& W, double dt) {
  for (WheelStep& w : wheels) {
    w.impulse = w.raw;
    w.released = false;
  }
  for (std::size_t pass = 0; pass <= wheels.size(); ++pass) {
    std::vector<Eigen::Index> active;
    for (std::size_t i = 0; i < wheels.size(); ++i)
      if (wheels[i].linearised && !wheels[i].released) active.push_back(static_cast<Eigen::Index>(i));
    if (active.empty()) return true;
    const auto n = static_cast<Eigen::Index>(active.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Identity(6 * n, 6 * n);
    Eigen::VectorXd b(6 * n);
    for (Eigen::Index r = 0; r < n; ++r) {
      const Eigen::Index i = active[static_cast<std::size_t>(r)];
      const WheelStep& w = wheels[static_cast<std::size_t>(i)];
      const Eigen::MatrixXd B = dt * (dt * w.K + w.D);
      Eigen::VectorXd u = w.dv;  // V - v without the unknown impulses
      for (std::size_t j = 0; j < wheels.size(); ++j)
        if (!wheels[j].linearised) u += W.block(6 * i, 6 * static_cast<Eigen::Index>(j), 6, 6) * wheels[j].raw;
      b.segment(6 * r, 6) = w.raw + B * u + dt * dt * (w.K * w.v);
      const Eigen::MatrixXd BW = B * W.middleRows(6 * i, 6);
      for (Eigen::Index c = 0; c < n; ++c)
        A.block(6 * r, 6 * c, 6, 6) -= BW.middleCols(6 * active[static_cast<std::size_t>(c)], 6);
    }
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(A);
    const Eigen::VectorXd J = lu.solve(b);
    if (!(lu.determinant() > 0) || !J.allFinite()) return false;
    bool again = false;
    for (Eigen::Index r = 0; r < n; ++r) {
      WheelStep& w = wheels[static_cast<std::size_t>(active[static_cast<std::size_t>(r)])];
      w.impulse = J.segment<6>(6 * r);
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
