#pragma once
// Whether a recommended experiment tells two effects apart: simulated with this folder's own wheel.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace blind {

constexpr int kDecidingRuns = 4;         ///< replicates of the recommended condition
constexpr double kDecidingLength = 3.3;  ///< noise sd between the two predictions; right in 95 of 100

/// Distance in noise sd, with four runs, between what the truth gives at `condition` and what the rival gives that was
/// fitted (soil under
/// priors and amplitude) to the noise-free data of the set. Nothing when the condition names something other than
/// slip, load_N,
/// omega_rad_s, pass (a bench check), or the rival has no wheel there.
std::optional<double> separation(const nlohmann::json& answer, const std::string& csv, const std::string& rival,
                                 const nlohmann::json& condition);

}  // namespace blind
