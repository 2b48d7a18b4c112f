#pragma once
// What a diagnosis reads: the case (model, soil with priors, effects considered) and the runs that were measured.
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "grouser/bekker/effect_wheel.h"

namespace grouser {
class Registry;
}

namespace grouser::diagnosis {

/// Measured channels of a steady run: drawbar [N], torque [N m], sinkage [m].
constexpr int channel_count = 3;
struct ChannelName {
  const char *column, *sd_column, *short_name, *unit;
};
const std::array<ChannelName, channel_count>& channel_names();

/// Soil parameters of the nominal law, in the coordinate that is fitted: ln k, n, c, phi, ln K, a0, a1.
constexpr int soil_count = 7;
struct SoilCoordinate {
  const char *name, *unit;
  bool logarithmic;
  double lower, upper;  ///< of the coordinate
};
const std::array<SoilCoordinate, soil_count>& soil_coordinates();

struct SoilPrior {
  double mean = 0, sd = 0;  ///< of the coordinate; sd 0 = held fixed
};

/// An effect that belongs to the nominal model: its amplitude, and its sd where it is refitted with the soil (0: held).
struct KnownEffect {
  std::string id;
  double value = 0, sd = 0;  ///< as the effect's formula has it (1/H for hard_pan, rad for bed_slope)
};

class RigModel;

/// Key `rig` of a case: how a model is rolled that has no steady law of its own (README, "Through the rig").
class RigOfCase {
 public:
  RigOfCase();
  ~RigOfCase();
  RigOfCase(const RigOfCase& o);  ///< with a copy of the answers known so far
  RigOfCase& operator=(const RigOfCase& o);
  RigOfCase(RigOfCase&&) noexcept;
  RigOfCase& operator=(RigOfCase&&) noexcept;

  std::string options;  ///< of the model, as YAML lines: they belong to the extended model, too
  std::string coarse;   ///< those of the diagnosis alone
  double step = 0, average_over = 0, settle = 0;  ///< [m], [m], contact lengths
  bool sinkage_from_rut = false;

  const RigModel* model() const { return model_.get(); }  ///< nullptr: the steady law answers
  void set(std::unique_ptr<RigModel> m);

 private:
  std::unique_ptr<RigModel> model_;
};

/// CASE.yaml.
struct DiagnosisCase {
  std::filesystem::path file;
  std::string model;
  bekker::EffectWheel wheel;
  double mass = 0;  ///< [kg]
  std::array<SoilPrior, soil_count> soil{};
  std::vector<std::string> effects;  ///< ids considered
  std::vector<KnownEffect> known;
  std::map<std::string, double>
      amplitude_sd;  ///< of amplitudes whose ordinary size is stated: normal about "no effect"
  std::array<std::optional<double>, soil_count>
      judged;  ///< soil to be held against the priors, in the fitted coordinate
  RigOfCase rig;
  std::vector<std::string> notes;  ///< what the model has not, and what changes nothing in it
};
/// registry: models that the case may name beside bekker.steady. @throws ConfigError with every error of the file.
DiagnosisCase read_case(const std::filesystem::path& yaml, const Registry* registry = nullptr);

/// One run. SI; NaN = not measured.
struct Run {
  int line = 0;
  double slip = 0;         ///< by the larger of r w and v, at the wheel's radius
  double stated_slip = 0;  ///< as the file has it
  double load = 0, omega = 0;
  int pass = 1;
  double order = 0;   ///< 0..1 over the series
  double time = 0;    ///< as the file has it, or 0
  double slope = 0;   ///< [rad], uphill positive
  int batch = 0;      ///< runs on the same preparation have the same number
  int condition = 0;  ///< repeats of one condition have the same number
  std::array<double, channel_count> value{}, sd{};
  std::map<std::string, double> cells;  ///< numbers of known columns as the file has them, for --withhold
};

/// DATA.csv.
struct RunTable {
  std::filesystem::path file;
  std::vector<Run> runs;
  std::array<bool, channel_count> measured{}, stated_sd{};
  bool has_order = false, has_omega = false, has_batch = false, has_slope = false, has_time = false;
  std::vector<std::string> notes;  ///< what is missing and what was done about it
};
/// Columns as in README.md. @throws ConfigError with every error of the file, each with line, column and remedy.
RunTable read_runs(const std::filesystem::path& csv, const DiagnosisCase& c);

}  // namespace grouser::diagnosis
