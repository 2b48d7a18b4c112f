#pragma once
// Single-wheel rig: one wheel on a carriage over any terrain; sweeps of slip or torque, wheel digging.
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/terrain/registry.h"
#include "grouser/vehicle/rig_spec.h"
#include "grouser/vehicle/rig_statistics.h"

namespace grouser::vehicle {

/// A case that cannot go on (not finite, wheel lost): names the case, the time and what was last good. What was recorded stays.
struct RigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RigOptions {
  std::filesystem::path out;           ///< folder; made when absent
  int threads = 1;                     ///< cases in parallel; results do not depend on it
  std::optional<std::string> terrain;  ///< other model id than the file's
  std::string integrator = "fixed";    ///< "fixed" (Bullet) or "cvode"
  std::vector<double> slips;           ///< other slips than the file's, in the file's definition(s)
  std::function<void(double done, double total, double wall_s)>
      progress;  ///< simulated seconds over all cases; any thread, one at a time
};

inline constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();

/// One case: what was asked and what came out over the averaging window.
struct RigRow {
  RigCase spec;
  double slip_symmetric = 0;  ///< [-] mean of (r w - v)/max(|r w|, |v|), r = the wheel's own radius
  double slip_rim = 0;        ///< [-] (r w - v)/(r w) of the same means; NaN where w = 0
  double angular_speed = 0;   ///< [rad/s] mean
  double travel_speed = 0;    ///< [m/s] mean along x
  Series drawbar_pull;        ///< [N]
  Series driving_torque;      ///< [N m] that the soil asks
  Series side_force;          ///< [N]
  Series normal_force;        ///< [N] that reached the wheel (what the integrator applied)
  Series sinkage;             ///< [m] from the local surface
  Series sinkage_profile;     ///< [m] eq 3.7: undisturbed profile(x) - (z - r)
  bool stationary = false;    ///< all of the six are
  std::string note;           ///< which are not, and by how much
  double simulated_s = 0, wall_s = 0, terrain_s = 0;
  /// 90 % half widths of a model that was fitted to data [N], [N m], [m], and share of its steps outside of that data; NaN: it does not say.
  std::array<double, 3> model_error{kUnsaid, kUnsaid, kUnsaid};
  double outside = kUnsaid;
  std::string warning;              ///< what a reader of the row must know; empty: nothing
  double touch_down_overshoot = 0;  ///< [-] greatest normal force over the load before the ramp, minus one
  std::string end_state_hash;
};

/// Simulated against measured: one channel of one group of cases (load and slip definition).
struct RigErrorRow {
  std::string group, channel, unit;
  int points = 0;
  double rmse = 0, bias = 0;  ///< [unit] bias = mean(simulated - measured)
  double measured_range = 0;  ///< [unit] max - min of the measured values
  double reading_error = 0;   ///< [unit] mean stated error of the measured values; NaN = not stated
};

struct RigSummary {
  std::filesystem::path folder;
  std::vector<RigRow> rows;
  std::vector<RigErrorRow> errors;
  double wall_s = 0, simulated_s = 0;
  std::vector<std::string> notices;  ///< how the terrain simplifies the wheel
};

/// Run every case of the file. Writes <out>/case_000/run.h5 ..., sweep.csv, and with `measured:` errors.csv and measured.csv; the
/// columns are documented in examples/03_single_wheel_rig/README.md.
///
/// integrator "fixed": the wheel is a Bullet rigid body whose carrier is held (x, y, yaw prescribed, z free) and the soil acts through
/// bullet::TerrainAction at the file's time_step, exactly the path of a vehicle's wheel.
/// integrator "cvode": the same equations of motion, force law by Terrain::preview, integrated to tolerance by CVODE with root finding
/// at touch-down; what the terrain remembers (stick, soil memory) is committed by Terrain::step every time_step.
/// @throws ConfigError (bad file; also a terrain that is not continuous with "cvode"), RigError, ResultsError
RigSummary run_rig(const std::filesystem::path& yaml, const Registry& registry, const RigOptions& options);

/// @throws ConfigError with every error of the file, the files it names and what replaces parts of it (RigOptions).
void check_rig(const std::filesystem::path& yaml, const Registry& registry,
               const std::optional<std::string>& terrain = {}, const std::vector<double>& slips = {});

}  // namespace grouser::vehicle
