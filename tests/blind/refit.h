#pragma once
// Refit of the nominal soil under priors, and of the soil with an effect: what a refit can absorb and what it cannot.
#include <Eigen/Dense>
#include <optional>

#include "wheel.h"

namespace blind {

constexpr int kSoilParameters = 7;
using SoilVector = Eigen::Matrix<double, kSoilParameters, 1>;

/// Priors of the case file: k and K by their logarithm, the others plain; u = (value - prior)/sd.
struct Priors {
  Soil centre;
  SoilVector sd =
      (SoilVector() << 0.30, 0.14, 415.0, 0.0502, 1.0, 0.2, 0.2).finished();  // ln k, n, c, phi, ln K, a0, a1
};

SoilVector scaled(const Priors& priors, const Soil& soil);
Soil soil_of(const Priors& priors, const SoilVector& u);

/// A run, what it gave and the inverse covariance of the three channels (drawbar, torque, sinkage).
struct Observation {
  Condition run;
  Eigen::Vector3d y;
  Eigen::Matrix3d weight;
};

Eigen::Vector3d vector_of(const Channels& y);

/// Runs that agree in all that the effects switched on use become one with the mean and the sum of the weights. The
/// chi squared that
/// this leaves out does not depend on the parameters. The order of the rows does not matter.
std::vector<Observation> grouped(const std::vector<Observation>& rows, unsigned uses);

/// Derivatives of the channels by the scaled soil and, with `extra`, by its amplitude: implicit differentiation of the
/// balance,
/// forward differences of the sums at a fixed entry angle.
struct Slopes {
  Eigen::Vector3d y;
  Eigen::Matrix<double, 3, Eigen::Dynamic> by;  ///< 7 columns, 8 with an effect
  double entry;
};
Slopes slopes(const Wheel& wheel, const Priors& priors, const SoilVector& u, const Amplitudes& x, const Condition& run,
              std::optional<Id> extra, double guess);

struct Refit {
  SoilVector u;
  Amplitudes x;
  double chi2 = 0;     ///< of the data given (grouped or not)
  double penalty = 0;  ///< |u|^2
  int iterations = 0;
};

/// Minimum of chi2 + |u|^2 by Levenberg-Marquardt from `start`; c >= 0, a0 in [0.01, 0.9], |u| <= 12, amplitude of
/// `extra` within its
/// physical bounds. Throws std::runtime_error where the start has no wheel.
Refit refit(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& rows, const SoilVector& start,
            const Amplitudes& x = {}, std::optional<Id> extra = {});

/// d: root of the chi2 left when the nominal wheel is refitted to noise-free data, the better of the starts truth and
/// prior.
double unabsorbed(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noise_free,
                  const SoilVector& truth);

/// Lowest and highest amplitude that physics allows, zero included.
std::pair<double, double> bounds(Id id);

}  // namespace blind
