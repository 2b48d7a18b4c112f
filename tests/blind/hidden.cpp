#include "hidden.h"

#include <cmath>
#include <map>
#include <stdexcept>

#include "oracle.h"

namespace blind {

Fingerprint::Fingerprint(const Wheel& wheel, const Priors& priors, const SoilVector& truth,
                         const std::vector<PlannedRun>& runs, const NoiseModel& noise)
    : wheel_(wheel), priors_(priors), truth_(truth) {
  std::map<std::pair<double, double>, Eigen::Matrix3d> known;
  for (const PlannedRun& p : runs) {
    if (p.withheld) continue;
    Condition run = p.run;
    run.ln_k_shift = run.phi_shift = 0;
    runs_.push_back(run);
    auto found = known.find({run.slip, run.load});
    if (found == known.end()) {
      Eigen::Matrix3d covariance = noise.sd.cwiseAbs2().asDiagonal();
      if (noise.ln_k_scatter > 0 || noise.phi_scatter > 0) {
        const Slopes s = slopes(wheel, priors, truth, {}, run, {}, 0.5);
        const Eigen::Vector3d by_k = s.by.col(0) * (noise.ln_k_scatter / priors.sd[0]);
        const Eigen::Vector3d by_phi = s.by.col(3) * (noise.phi_scatter / priors.sd[3]);
        covariance += by_k * by_k.transpose() + by_phi * by_phi.transpose();
      }
      found = known.emplace(std::pair{run.slip, run.load}, covariance.inverse()).first;
    }
    weights_.push_back(found->second);
  }
}

std::vector<Observation> Fingerprint::observe(const Amplitudes& x) const {
  const std::vector<Eigen::Vector3d> y = simulate_all(wheel_, soil_of(priors_, truth_), x, runs_);
  std::vector<Observation> out;
  for (std::size_t i = 0; i < runs_.size(); ++i) out.push_back({runs_[i], y[i], weights_[i]});
  return out;
}

double Fingerprint::d(const Amplitudes& x) const { return unabsorbed(wheel_, priors_, observe(x), truth_); }

std::optional<HiddenEffect> tune(const Fingerprint& fingerprint, Id id, double sign, double wanted) {
  const Effect& e = effect(id);
  const auto at = [&](double size) {
    Amplitudes x;
    x[id] = sign * size;
    try {
      return fingerprint.d(x);
    } catch (const std::runtime_error&) {
      return -1.0;  // no wheel: too much
    }
  };
  double size = 0.3 * e.typical, most = e.high, value = at(size);
  for (int attempt = 0; attempt < 12; ++attempt) {
    if (value < 0) {
      most = std::min(most, 0.9 * size);
      size *= 0.5;
    } else if (std::abs(std::log(value / wanted)) < 0.15) {
      break;
    } else {
      if (size >= most && value < wanted) break;
      size = std::min(size * std::clamp(wanted / std::max(value, 1e-3), 0.02, 4.0), most);
    }
    value = at(size);
  }
  if (value < 3.0 * 0.95) return {};
  const bool at_bound = size >= most;
  if (!at_bound && std::abs(std::log(value / wanted)) > 0.3) return {};
  return HiddenEffect{id, sign * size, value, at_bound};
}

SoilVector draw_soil(const Priors& priors, Dice& dice) {
  const Wheel wheel;
  for (int attempt = 0; attempt < 200; ++attempt) {
    SoilVector u;
    for (Eigen::Index i = 0; i < kSoilParameters; ++i) u[i] = 0.5 * dice.normal();
    const Soil& m = priors.centre;
    const double c = m.c + u[2] * priors.sd[2], a0 = m.a0 + u[5] * priors.sd[5], a1 = m.a1 + u[6] * priors.sd[6];
    if (c < 0 || a0 < 0.03 || a0 + 0.7 * a1 < 0.03 || a0 + 0.7 * a1 > 0.8) continue;
    try {
      for (const double slip : {-0.7, 0.7}) simulate(wheel, soil_of(priors, u), {}, {slip, kWithheldLoad});
    } catch (const std::runtime_error&) {
      continue;
    }
    return u;
  }
  throw std::runtime_error("no soil of the priors carries the wheel");
}

double draw_d(Dice& dice) { return std::exp(dice.uniform(std::log(3.0), std::log(40.0))); }

}  // namespace blind
