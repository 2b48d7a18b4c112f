#pragma once
// Response of one run over time and its sensitivities. The integrator is SUNDIALS CVODES.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "grouser/diagnosis/runs.h"

namespace grouser::diagnosis {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// What drives a run, at knots; between them everything runs straight.
struct TimeTrack {
  std::vector<double> t;      ///< of the knots [s], rising
  std::vector<double> rows;   ///< when the answer is wanted [s], rising, within t
  std::vector<double> speed;  ///< q of T1 [m/s]
  std::vector<double> turn;   ///< [rad]
  double spacing = 1;         ///< [s], longest step of the integrator
  /// Knot by knot: u of each channel, then du/dx of each channel for each of `parameters` inputs.
  RowMatrix target;
  int channels = 0, parameters = 0;
};

/// Which dynamics are on, and how large. 0: off.
struct TimeDynamics {
  double sigma = 0, tau = 0, delay = 0;
  int lugs = 0;
  std::vector<double> ripple;  ///< sin and cos amplitude of each channel
  std::vector<double>
      shape_scales;  ///< [s] or [m]: fixed lags of a response of free shape, a + sum_k h_k (L_k - a), L_k lags a
  std::vector<double> shape;  ///< h_k
  bool shape_over_travel = false;
  bool has_states() const { return sigma > 0 || tau > 0 || !shape_scales.empty(); }
};

/// Columns of the slopes: the track's parameters; the start of each channel where `start` is given; then those that are on of
/// ln sigma, ln tau, ln delay, ripple, h.
struct TimeResponse {
  RowMatrix y;             ///< rows by channels
  Eigen::MatrixXd slopes;  ///< (row * channels + channel) by columns
};

/// start: state of each channel at the first row; empty: steady. Before the first row the run is taken to have been as at it.
/// False: CVODES gave up. Error: 1e-6 of the largest value of each channel (tested against exact answers).
/// Cost: one to three steps for each row; about 0.3 ms for 200 rows of three channels, with 12 slopes 1.5 ms.
bool respond(const TimeTrack& track, const TimeDynamics& d, const std::vector<double>& start, bool slopes,
             TimeResponse& out);
int dynamic_columns(const TimeDynamics& d, int channels);

}  // namespace grouser::diagnosis
