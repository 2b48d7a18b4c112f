#pragma once
// What the model says of one run, and how that depends on everything a candidate cause may change.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "wheel_answer.h"

namespace grouser::diagnosis {

/// A run's inputs: soil coordinates, then the amplitudes of effect_entries().
constexpr int input_count = soil_count + model_effects + map_count;
using Inputs = std::array<double, input_count>;
constexpr int input_of_effect(int entry) { return soil_count + entry; }
constexpr int input_of(bekker::Effect e) { return soil_count + static_cast<int>(e); }
constexpr int input_of(Map m) { return soil_count + model_effects + static_cast<int>(m); }

using Slopes = Eigen::Matrix<double, channel_count, input_count>;

/// Inputs without any effect at these soil coordinates.
Inputs plain_inputs(const std::array<double, soil_count>& soil);

class RigModel;

/// Who answers for the wheel: the steady law, or a model in the rig.
struct AskedWheel {
  AskedWheel(const bekker::EffectWheel& w) : shape(w) {}
  AskedWheel(const DiagnosisCase& c) : shape(c.wheel), rig(c.rig.model()) {}
  AskedWheel(const bekker::EffectWheel& w, const DiagnosisCase& c) : shape(w), rig(c.rig.model()) {}
  const bekker::EffectWheel& shape;
  const RigModel* rig = nullptr;
};

/// Which columns of Slopes are wanted; soil columns always come.
enum class Wanted { value, soil_and_touched, all };

/// touched: entries whose slopes are wanted beside the soil's.
/// theta_f: in: near the answer or 0, out: the answer. False: the model has no answer there.
bool model_run(const AskedWheel& wheel, const Run& run, const Inputs& in, Wanted wanted,
               const std::vector<int>& touched, double& theta_f, Outputs& out, Slopes* slopes);

/// Many runs at once. Runs that are the same to the wheel (soil, active effects, slip, load, and speed, pass or order where an active
/// effect looks at them) are worked out once: with no effect on, 216 runs of a plan with 3 speeds and 2 passes are 36.
/// slopes: empty (values only), or one for each run.
bool model_runs(const AskedWheel& wheel, const std::vector<Run>& runs, const std::vector<Inputs>& in, Wanted wanted,
                const std::vector<int>& touched, std::vector<double>& theta_f, std::vector<Outputs>& out,
                std::vector<Slopes>* slopes);

/// What is said of these runs from here on was rolled there, not foretold from elsewhere (RigModel::settle). False: no wheel there.
bool settle_runs(const AskedWheel& wheel, const std::vector<Run>& runs, const std::vector<Inputs>& in);

}  // namespace grouser::diagnosis
