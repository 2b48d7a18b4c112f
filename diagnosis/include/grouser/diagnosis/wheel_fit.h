#pragma once
// Bekker-Wong parameters from steady single-wheel results, measured or simulated (dissertation section 4.3.4).
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "grouser/bekker/forces.h"
#include "grouser/diagnosis/least_squares.h"
#include "grouser/terrain/soil.h"

namespace grouser::diagnosis {

enum class WheelChannel { drawbar_pull, driving_torque, sinkage, side_force };
constexpr std::size_t wheel_channels = 4;
struct WheelChannelName {
  const char *name, *unit, *shown_unit;
  double shown;  ///< shown value = SI value * shown
};
const std::array<WheelChannelName, wheel_channels>& wheel_channel_names();

/// One steady condition. SI; NaN = not measured.
struct WheelPoint {
  double slip = 0;         ///< s = (r_s w - v)/max(|r_s w|, |v|) by the wheel's outer radius r_s
  double stated_slip = 0;  ///< as the data give it, for plots
  double load = 0, slip_angle = 0;
  double sinkage_datum = 0;  ///< [m] the data's sinkage is this much less than that of the lowest point (lug tips)
  std::string condition;     ///< rows with the same text are repeats
  std::array<double, wheel_channels> value{}, error{};
};

/// Slip by another radius or definition at the same motion. `rim`: s = (R w - v)/(R w) for both signs; else s = (R w - v)/max(|R w|, |v|).
double slip_at_radius(double slip, bool rim, double radius, double outer_radius);

/// Value of each channel, or the solver's reason.
struct WheelPrediction {
  bekker::ForceStatus status = bekker::ForceStatus::ok;
  std::array<double, wheel_channels> value{};
};
WheelPrediction predict(const bekker::WheelSize& wheel, const BekkerSoil& soil, const WheelPoint& point,
                        bekker::Method method);

/// Root mean square and bias of model - measured over the points that have this channel.
struct ChannelError {
  WheelChannel channel = WheelChannel::drawbar_pull;
  int points = 0;
  double rmse = 0, bias = 0, range = 0;  ///< SI; range of the measured values
  double scatter = 0;                    ///< SI sd between repeats, pooled; NaN without repeats
  int scatter_dof = 0;
  double stated_error = 0;  ///< SI root mean square of the stated errors; NaN = none
};
std::vector<ChannelError> channel_errors(const std::vector<WheelPoint>& points,
                                         const std::vector<std::array<double, wheel_channels>>& model);

/// A soil parameter that may be fitted: k, kc, kphi, n, cohesion, friction_angle, K, Kw, Kr, a0, a1, b0, b1.
struct WheelVariable {
  std::string name;
  double lower = 0, upper = 0;  ///< SI
  std::optional<Prior> prior;   ///< of ln value for k, K, Kw; of the value otherwise
};
struct WheelParameter {
  const char *name, *unit, *shown_unit;
  double shown, lower, upper, scale;
  bool logarithmic;
};
const std::vector<WheelParameter>& wheel_parameters();
double get_parameter(const BekkerSoil& soil, const std::string& name);
void set_parameter(BekkerSoil& soil, const std::string& name, double value);

struct WheelFit {
  BekkerSoil soil;
  LeastSquaresResult fit;
  std::vector<std::array<double, wheel_channels>> model;  ///< of each point, fitted
};

/// Residuals (model - measured)/error over every measured channel; `start` gives the start values and what is not fitted.
/// kc, kphi depend on n in their unit: they are fitted as they stand in the soil.
/// @throws std::invalid_argument: a point without error; a start outside its bounds; a point that the solver cannot carry at the start
/// (named).
WheelFit fit_wheel(const bekker::WheelSize& wheel, const BekkerSoil& start, const std::vector<WheelPoint>& points,
                   const std::vector<WheelVariable>& variables, bekker::Method method, ErrorModel errors,
                   int starts = 12);

}  // namespace grouser::diagnosis
