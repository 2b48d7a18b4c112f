#pragma once
// Soil tests on grains against measured curves: which contact law, or which cause beside it, made them. The model is
// an emulator of stored runs of the solver, so a diagnosis computes no grains.
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "grouser/diagnosis/diagnose.h"

namespace grouser::diagnosis {

enum class SoilTestKind { shear, plate };

/// Parameters of the nominal law: ln Y, ln friction, ln of the constant rolling coefficient.
constexpr int grain_count = 3;
struct GrainCoordinate {
  const char *key, *symbol, *unit;
};
const std::array<GrainCoordinate, grain_count>& grain_coordinates();

/// What the stored runs can have beside the nominal law.
///   rolling_rate_dependence   mu_eff = min(c |v_t|^2, 1) instead of a constant, ln c even over 1e7..1e10 s^2/m^2
///                             (dissertation, eq 3.20)
///   cohesion                  kc A in every contact, kc even over 0..0.6 MJ/m^3 (eqs 3.7, 3.8)
///   wall_effects              friction of box and plate, even over 0..0.6 (nominal: smooth)
///   grain_size                all diameters by a factor, its ln even over 0.8..1.3 (the sizes are a choice, 4.2.3)
struct SoilTestEffect {
  const char *id, *symbol, *unit;
  double lower, upper;  ///< of the coordinate
  double off, typical;  ///< no effect; a size that matters
  bool logarithmic;
};
const std::vector<SoilTestEffect>& soil_test_effects();

/// CASE.yaml with `model: dem.soil_tests`.
struct SoilTestCase {
  std::filesystem::path file, stored;
  std::array<SoilPrior, grain_count> soil{};  ///< of the logarithms
  std::vector<std::string> effects;
};
/// Whether a case names this model; false for files that cannot be read.
bool is_soil_test_case(const std::filesystem::path& yaml);
/// @throws ConfigError with every error of the file.
SoilTestCase read_soil_test_case(const std::filesystem::path& yaml);

/// One measured curve.
struct SoilTestCurve {
  int line = 0;  ///< of its first row
  std::string repeat;
  std::vector<double> displacement, stress, rise;  ///< [m], [Pa], [m]; rise empty where it was not measured
};
/// Curves of tests made alike.
struct SoilTestCondition {
  SoilTestKind kind = SoilTestKind::shear;
  double normal_stress = 0;  ///< [Pa], 0 for plates
  double speed = 0;          ///< [m/s]
  double rest = 0;           ///< [s] under the load before shearing
  std::vector<SoilTestCurve> curves;
  std::string name() const;  ///< "shear at 5330 Pa, 0.66 mm/s"
};
struct SoilTestData {
  std::filesystem::path file;
  std::vector<SoilTestCondition> conditions;
  bool rise = false;  ///< of the loading plate, in every shear test
  std::vector<std::string> notes;
};
/// Columns: test (shear | plate), normal_stress_Pa, speed_mm_s, rest_s, repeat, displacement_mm, stress_Pa, and rise_mm
/// where it was measured; other units by name (stress_kPa). @throws ConfigError with every error of the file, each with
/// line, column and remedy.
SoilTestData read_soil_test_curves(const std::filesystem::path& csv);

/// What a curve is reduced to: ln of the mean stress in three windows of displacement, and the rise at its end in mm.
struct SoilTestWindows {
  std::array<std::array<double, 2>, 3> shear{{{0.5e-3, 1.5e-3}, {1.5e-3, 3e-3}, {3e-3, 6e-3}}};
  std::array<std::array<double, 2>, 3> plate{{{1.25e-3, 3.75e-3}, {3.75e-3, 6.25e-3}, {6.25e-3, 10e-3}}};
};
const SoilTestWindows& soil_test_windows();

/// How well the stored runs are followed.
struct EmulatorQuality {
  std::string law;
  SoilTestKind kind = SoilTestKind::shear;
  int runs = 0, terms = 0;
  std::vector<double> scatter,
      left_out;  ///< root mean square of single runs about the emulator, and left out of it; of each output
};

/// Condition with what was measured and what the models say, in the outputs of SoilTestWindows.
struct SoilTestFigures {
  SoilTestCondition condition;
  std::vector<Eigen::VectorXd> repeats;
  Eigen::VectorXd mean, sd, nominal, extended;  ///< sd: of one test
};

struct SoilTestDiagnosis {
  std::string verdict, cause, sentence;
  std::vector<std::string> members;
  std::map<std::string, double> posterior;     ///< includes none and unknown
  std::map<std::string, Interval> parameters;  ///< of the effect
  std::string unknown_variable, unknown_through;
  std::map<std::string, FittedValue> nominal, extended;  ///< soil
  double nominal_chi2 = 0, extended_chi2 = 0, nominal_p = 1, extended_p = 1;
  int values = 0;
  double nominal_rmse = 0, extended_rmse = 0;  ///< of the logarithm of stress
  std::vector<Ranked> ranking;
  std::map<std::string, double> visible;  ///< d of each effect at its typical size, after the refit of the soil
  std::optional<Gain> gain;               ///< errors are those of ln stress
  std::vector<NextExperiment> next;       ///< condition: normal_stress_Pa (0: plate), speed_mm_s, rest_s
  std::array<double, 2> noise_scale{1, 1};
  std::vector<SoilTestFigures> figures;
  std::vector<EmulatorQuality> emulators;
  std::vector<std::string> notes;
  std::string law;                                ///< of the extended model: constant | rate
  std::map<std::string, double> extended_values;  ///< of the extended model, SI
  double seconds = 0;
};

/// Deterministic. `withhold`: "test=plate", "normal_stress_Pa=17830" or "speed_mm_s=0.66": curves that are not fitted
/// and on which the gain is measured.
/// @throws ConfigError: stored runs or data that do not fit together.
SoilTestDiagnosis diagnose_soil_tests(const SoilTestCase& c, const SoilTestData& data,
                                      const std::vector<std::string>& withhold);

/// The extended soil as a file of `grouser soil`: keys of `soil:`, with the law and the effect found.
std::string extended_soil_text(const SoilTestDiagnosis& d);

}  // namespace grouser::diagnosis
