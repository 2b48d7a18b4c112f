#pragma once
// What the model says of one run, and how that depends on everything a candidate cause may change.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "effect_list.h"
#include "grouser/diagnosis/runs.h"

namespace grouser::diagnosis {

/// A run's inputs: soil coordinates, then the amplitudes of effect_entries().
constexpr int input_count = soil_count + static_cast<int>(bekker::effect_count) + map_count;
using Inputs = std::array<double, input_count>;
constexpr int input_of_effect(int entry) { return soil_count + entry; }

using Outputs = std::array<double, channel_count>;
using Slopes = Eigen::Matrix<double, channel_count, input_count>;

/// Inputs without any effect at these soil coordinates.
Inputs plain_inputs(const std::array<double, soil_count>& soil);

/// Which columns of Slopes are wanted; soil columns always come.
enum class Wanted { value, soil_and_touched, all };

/// touched: entries whose slopes are wanted beside the soil's (at most three model effects).
/// theta_f: in: near the answer or 0, out: the answer. False: the model has no answer there.
bool model_run(const bekker::EffectWheel& wheel, const Run& run, const Inputs& in, Wanted wanted,
               const std::vector<int>& touched, double& theta_f, Outputs& out, Slopes* slopes);

}  // namespace grouser::diagnosis
