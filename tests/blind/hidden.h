#pragma once
// Drawing what is hidden: soil, effects, amplitudes for a wanted d, variants of the data.
#include <optional>
#include <string>
#include <vector>

#include "plan.h"
#include "refit.h"

namespace blind {

struct NoiseModel {
  Eigen::Vector3d sd{2.0, 0.2, 0.0015};
  double stated_factor = 1.0;                ///< stated sd over true sd
  double ln_k_scatter = 0, phi_scatter = 0;  ///< per preparation
  double autocorrelation = 0;                ///< lag one along order
  double outlier_share = 0;
  bool quantised = false;  ///< 0.5 N, 0.05 N m, 0.5 mm
};

/// d of an amplitude in a set: chi of what the nominal refit leaves of the training rows, free of noise.
class Fingerprint {
 public:
  Fingerprint(const Wheel& wheel, const Priors& priors, const SoilVector& truth, const std::vector<PlannedRun>& runs,
              const NoiseModel& noise);

  /// Noise-free observations of the training rows with the noise covariance (sensors and preparation) as weight.
  std::vector<Observation> observe(const Amplitudes& x) const;
  double d(const Amplitudes& x) const;

 private:
  const Wheel& wheel_;
  const Priors& priors_;
  SoilVector truth_;
  std::vector<Condition> runs_;
  std::vector<Eigen::Matrix3d> weights_;
};

struct HiddenEffect {
  Id id;
  double x = 0, d = 0;
  bool at_bound = false;
};

/// Amplitude whose d is within 15 % of the wanted; the bound if it gives less but at least 3; nothing if it gives less
/// than 3.
std::optional<HiddenEffect> tune(const Fingerprint& fingerprint, Id id, double sign, double wanted);

/// Soil with half the prior sd, c >= 0; redrawn until the ratio theta_m/theta_f stays inside the arc and every run has
/// a wheel.
SoilVector draw_soil(const Priors& priors, Dice& dice);

/// 3 to 40, uniform in the logarithm.
double draw_d(Dice& dice);

}  // namespace blind
