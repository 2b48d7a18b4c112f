#pragma once
// The evidence oracle: what a reader who knows the true soil and this very model could say of the noisy data.
#include "refit.h"

namespace blind {

/// ln Bayes factor of each library effect over the nominal wheel, linearised at the true soil u*:
///   r = y - f(u*),  r = J v + g a + noise,  v ~ N(-u*, I),  a ~ N(0, A^2)  ->
///   ln B = -ln(1 + A^2 q)/2 + A^2 s^2/(2 (1 + A^2 q)),  s = g' P (r + J u*),  q = g' P g,  P = (1 + J J')^-1 after
///   whitening
/// g is the secant of the effect: at the true amplitude for the true one, at the estimated amplitude (one refinement)
/// for the rivals.
/// An engine can beat it where the data bend: it is a yardstick, not a bound. Cost: 36 to 216 wheels per effect.
struct OracleAnswer {
  std::vector<double> ln_bayes;  ///< per library effect; -infinity where the effect has no wheel there
  std::string top;
  double ln_over_next = 0;
  bool would_name = false;  ///< factor over 10 against the nominal wheel and every rival
};

OracleAnswer oracle(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy,
                    const SoilVector& truth, const Amplitudes& hidden);

/// The same for two effects at once: every pair of the library by the slopes of its effects alone, the best 16 and the true one again with
/// the fingerprints that the two have beside each other (at the true amplitudes, at the estimated ones for rivals).
struct PairAnswer {
  std::string top;          ///< "a+b"
  bool first = false;       ///< the true pair is the best
  double ln_over_next = 0;  ///< over the next pair and the best single effect
  bool would_name = false;  ///< by 10:1
};
PairAnswer pair_oracle(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy,
                       const SoilVector& truth, const Amplitudes& hidden);

/// Library effects whose fingerprint over these runs is proportional to the hidden one to 1e-7, with an amplitude that
/// physics allows;
/// the hidden one included. More than one: no data of this plan can tell them apart.
std::vector<Id> exact_class(const Wheel& wheel, const std::vector<Observation>& rows, const Soil& soil, Id hidden,
                            double x);

/// Noise-free channels of all runs; runs that differ in nothing that matters are computed once.
std::vector<Eigen::Vector3d> simulate_all(const Wheel& wheel, const Soil& soil, const Amplitudes& x,
                                          const std::vector<Condition>& runs, Numerics numerics = {});

}  // namespace blind
