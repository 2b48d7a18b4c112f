#pragma once
// Stored soil tests as a model with parameters: constant rolling with three effects beside it, and rolling by speed.
#include <array>

#include "emulator.h"
#include "grouser/diagnosis/soil_test_diagnosis.h"

namespace grouser::diagnosis {

enum class RollingLaw { constant, rate };

/// Outputs of a curve, see SoilTestWindows. @throws std::invalid_argument with what is missing.
Eigen::VectorXd soil_test_outputs(SoilTestKind kind, const SoilTestCurve& curve, bool rise);

/// Where a coordinate of an account comes from and what is known of it before the data.
struct SoilTestCoordinate {
  std::string name, unit;
  bool logarithmic = true;
  double lower = 0, upper = 0;
  double mean = 0, sd = 0;  ///< normal prior; sd 0: even between the bounds
  double ln_prior(double x) const;
};

class SoilTestModel {
 public:
  /// @throws ConfigError with every error of the file of stored runs.
  SoilTestModel(const std::filesystem::path& stored, bool rise);

  int outputs(SoilTestKind k) const { return emulator(RollingLaw::constant, k).outputs(); }
  /// Features of a condition at coordinates x: ln Y, ln friction, ln rolling coefficient (constant, or c in s^2/m^2),
  /// amounts of the nested effects
  /// (constant law). Empty: outside the stored runs.
  Eigen::VectorXd features(RollingLaw law, const SoilTestCondition& c, const Eigen::VectorXd& x) const;
  const Emulator& emulator(RollingLaw law, SoilTestKind kind) const {
    return emulators_[static_cast<std::size_t>(law)][static_cast<std::size_t>(kind)];
  }
  /// Scatter of single tests, pooled over the laws.
  const Eigen::MatrixXd& scatter(SoilTestKind k) const { return scatter_[static_cast<std::size_t>(k)]; }
  /// Bounds of coordinate i of the law: those of the stored runs.
  std::array<double, 2> range(RollingLaw law, int coordinate) const;
  std::vector<EmulatorQuality> quality() const;

 private:
  std::array<std::array<Emulator, 2>, 2> emulators_;
  std::array<Eigen::MatrixXd, 2> scatter_;
};

/// Number of effects that are amounts beside the constant law; they follow rolling_rate_dependence in
/// soil_test_effects().
constexpr int nested_effects = 3;

}  // namespace grouser::diagnosis
