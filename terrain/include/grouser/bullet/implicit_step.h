#pragma once
// The algebra of the adapter, free of Bullet and compiled once (terrain/src/implicit_step.cpp), whatever precision the host has.
//
// The linearly implicit impulse: soil forces at the end of the coming step instead of at its beginning.
#include <vector>

#include "grouser/terrain/types.h"

namespace grouser::bullet {

/// One wheel of a group that shares bodies through joints. 6-vectors: (x, y, z, rx, ry, rz) in W about the body's origin.
struct WheelStep {
  Vec6 raw = Vec6::Zero();  ///< dt * F(x, v): the model's impulse over the step just done [N s, N m s]
  bool linearised = false;
  Mat6 K = Mat6::Zero();        ///< dF/dx [N/m, ...], negative = restoring
  Mat6 D = Mat6::Zero();        ///< dF/dv [N s/m, ...]
  Vec6 v = Vec6::Zero();        ///< twist now
  Vec6 dv = Vec6::Zero();       ///< change of twist over the coming step by everything but soil
  Vec6 impulse = Vec6::Zero();  ///< answer
  bool released = false;        ///< answer: contact ends within the coming step
};

/// Impulses J that solve, for all wheels of the group at once,
///
///   J_i = dt F_i + dt^2 K_i V_i + dt D_i (V_i - v_i),    V_i = v_i + dv_i + sum_j W_ij J_j                               (1)
///
/// i.e. the force linearised about the motion now, at the pose x + dt V and twist V that Bullet will reach with J applied (implicit
/// Euler with one Newton step). W (6n x 6n) [1/kg, ...] is what a unit impulse on wheel j does to the twist of wheel i once the joints
/// have been solved. At rest v = V = 0, so J = dt F(x) exactly: the static sinkage is exact for any constant dt.
///
/// Ground does not pull: when (1) asks for a pull (J_z <= 0) from a contact that pushes (raw_z > 0), the wheel leaves the ground within
/// the coming step and its impulse is zero (`released`).
///
/// Returns false when the system is singular or past it (det <= 0: the contact is anti-restoring faster than dt can follow) or not
/// finite. Cost: one block LU of 6 x (wheels with a linearisation in contact), about 3 us for four.
bool implicit_impulses(std::vector<WheelStep>& wheels, const Eigen::MatrixXd& W, double dt);

/// dt * omega of a contact treated explicitly: the larger of sqrt|eig(dt^2 K W)| and |eig(dt D W)|, W the 6 x 6 block of that wheel.
double explicit_step_ratio(const Mat6& K, const Mat6& D, const Mat6& W, double dt);

/// Eq 2 of mobility.h. inverse_mass: 6 x 6 per body; G: held joint rows (n x 6 bodies); cfm: softness of each row relative to its own
/// response; wheels: the body of each wheel. Returns W, 6n x 6n. Dependent rows (loops, doubled joints) are allowed.
Eigen::MatrixXd joint_mobility(const std::vector<Mat6>& inverse_mass, const Eigen::MatrixXd& G,
                               const Eigen::VectorXd& cfm, const std::vector<Eigen::Index>& wheels);

/// R block diagonal times W times its transpose: from Bullet's axes to W.
Eigen::MatrixXd rotate_blocks(const Eigen::MatrixXd& W, const Mat3& R);

}  // namespace grouser::bullet
