#pragma once
// A single wheel over time: slip steps with a hidden delay, filter, relaxation length or ripple. `grouser diagnose` with a case that
// has the key `series`.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "grouser/diagnosis/diagnose.h"

namespace grouser::diagnosis {

/// Dynamics that a series may hide. y: drawbar [N], torque [N m], sinkage [m], each alike; u(t): the steady wheel (Bekker-Wong) at the
/// load and slip of that moment.
///   relaxation_length  da/dt = q (u - a)/sigma         sigma [m], q the speed of `relaxation_over` [m/s]     (T1)
///   ripple             a + A_c sin(n phi + phase_c)    n lugs, phi angle turned [rad]; one A_c for each channel    (T2)
///   filter             db/dt = (a - b)/tau             tau [s]                                              (T3)
///   delay              y(t) = b(t - theta)             theta [s]                                            (T4)
/// Sources: relaxation length: Irani et al. 2011, after the tyre's; ripple: Shikanai et al. 2000. A filter and a delay are of the rig's
/// sensors or of its drive; they never reach a vehicle. One sigma, one tau, one theta for all channels.
enum class TimeEffect { relaxation_length, filter, delay, ripple };
constexpr int time_effect_count = 4;
struct TimeEffectInfo {
  const char *id, *unit, *says;
};
const std::array<TimeEffectInfo, time_effect_count>& time_effects();

/// Key `series` of the case.
struct TimeOptions {
  std::array<bool, time_effect_count> considered{true, true, true, true};
  int lugs = 0;  ///< 0: not stated; ripple is then left out
  enum class Over { travel, rim, larger } over = Over::travel;
  bool free_start = false;              ///< `start: free`: the states at a run's first row are fitted
  std::array<double, 2> scatter{0, 0};  ///< sd of ln k and of phi [rad] from run to run; 0: the same soil in every run
  std::string relaxation_over() const;
};

struct TimeCase {
  DiagnosisCase steady;  ///< wheel and soil with priors
  TimeOptions options;
};

/// Whether the case has the key `series`.
bool is_time_case(const std::filesystem::path& yaml);
/// @throws ConfigError with every error of the file.
TimeCase read_time_case(const std::filesystem::path& yaml);

/// One run: rows by rising time.
struct TimeRun {
  std::vector<Run> rows;
  std::vector<double> travel, rim, turn;  ///< [m/s], [m/s], angle since the first row [rad]; at each row
  double spacing = 0;                     ///< median of the time between rows [s]
};
struct TimeTable {
  RunTable rows;  ///< as the file has them
  std::vector<TimeRun> runs;
};
/// Columns of `read_runs`, with time_s and omega_rad_s required; `batch` tells the runs apart; slip, or travel_speed_m_s in its place.
/// @throws ConfigError with every error of the file: time that does not rise, fewer than 12 rows in a run.
TimeTable read_time_table(const std::filesystem::path& csv, const TimeCase& c);

/// Correlated noise of a channel: residual e_i with sd scale * sd_i and correlation rho over the spacing of the rows.
struct TimeNoise {
  double scale = 1, rho = 0;
};

struct TimeDiagnosis {
  Diagnosis d;  ///< `runs`: the rows that were fitted, run by run
  std::array<TimeNoise, channel_count> nominal_noise{}, extended_noise{};
  struct Test {
    std::string about;
    double p = 1;
  };
  std::vector<Test> gate;  ///< what is left over by the best account, against each account without a name
  std::string physics;     ///< what a model can take over, in words; empty when nothing was found
};

/// Method (T5 to T9): README.md. `withhold`: texts as "slip=0.7..0.95", "batch=3": runs whose last row fits are not fitted, and the gain is
/// measured on them. Deterministic, one thread. @throws ConfigError for the options and where the steady wheel has no answer.
TimeDiagnosis diagnose_time(const TimeCase& c, const TimeTable& data, const std::vector<std::string>& withhold);

}  // namespace grouser::diagnosis
