#pragma once
// Whether a recommended experiment tells two effects apart: simulated with this folder's own wheel.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace blind {

constexpr int kDecidingRuns = 4;         ///< replicates of the recommended condition
constexpr double kDecidingLength = 3.3;  ///< noise sd between the two predictions; right in 95 of 100

/// Distance in noise sd, with `runs` repeats, between what the truth gives at `condition` and what the rival gives that was fitted
/// (soil under priors and amplitude) to the noise-free data of the set. Nothing when the condition names something other than
/// slip, load_N, omega_rad_s, pass, wheel_width_m, or the rival has no wheel there.
std::optional<double> separation(const nlohmann::json& answer, const std::string& csv, const std::string& rival,
                                 const nlohmann::json& condition, int runs = kDecidingRuns);

/// The same for a bench check of the sensor effect `checked`, which is the truth or the rival: the amplitude that is there (true, or of
/// the fitted rival) over the error of that many readings at 225 N, 0.9 rad/s, 100 N of pull, 15 N m; balance and rolled way to
/// 0.2 %, level to 0.1 deg. Nothing when `checked` is neither, or no sensor effect.
std::optional<double> bench_separation(const nlohmann::json& answer, const std::string& csv, const std::string& rival,
                                       const std::string& checked, int readings = 4);

}  // namespace blind
