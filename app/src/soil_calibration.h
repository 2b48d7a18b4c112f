#pragma once
// Young's modulus, friction and rolling coefficient of grains by direct-shear and pressure-sinkage curves together.
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "soil_page.h"
#include "soil_run.h"
#include "soil_search.h"

namespace grouser::app {

/// A parameter that is searched for between two bounds, on a logarithmic scale.
struct CalibrationParameter {
  std::string name, unit;  ///< "young_modulus", "Pa"
  double lower = 0, upper = 0;
  std::function<void(dem::SoilSettings&, double)> set;
};

/// A curve to meet: of the file's reference, or points from CSV.
struct CalibrationTarget {
  double pressure = 0;       ///< of a shear test [Pa]
  std::string source;        ///< for a person
  std::vector<double> x, y;  ///< empty: the reference
};

struct CalibrationTest {
  std::string kind;            ///< "direct-shear" or "pressure-sinkage"
  std::filesystem::path file;  ///< of the soil test
  double weight = 1;
  std::string column;  ///< of the test's table that is compared
  std::vector<CalibrationTarget> targets;
  SoilFile plan;  ///< with the file's own parameters
};

struct Calibration {
  std::string title;
  std::filesystem::path file;
  std::vector<CalibrationParameter> parameters;
  std::array<CalibrationTest, 2> tests;  ///< shear, sinkage
  SearchSettings search;
};

/// calibration: TITLE
/// direct_shear: {file: shear.yaml, weight: 1, column: shear_total_Pa | shear_box_Pa, target: [{pressure: 5 kPa, file: a.csv}]}
/// pressure_sinkage: {file: sinkage.yaml, weight: 1, target: {file: b.csv}}      target: optional, else the file's `reference`
/// parameters: {young_modulus: [5 MPa, 100 MPa], friction: [0.2, 1], rolling_coefficient: [0.03, 0.6]}      one at least
/// search: {sets: 8, evaluations: 24, method: bobyqa | sbplx | nelder-mead, seed: 1, tolerance: 0.01}       optional
/// CSV: columns as the command's own curves have them, displacement_m and the column compared, sinkage_m and pressure_Pa.
/// @throws ConfigError with every error of the file.
Calibration read_calibration(const std::filesystem::path& file);

/// The target of a curve as a function of displacement or sinkage; NaN where it has none.
class Target {
 public:
  Target(const CalibrationTest& test, const SoilGroup& curve);
  double operator()(double x) const;
  const std::string& source() const { return points_->source; }

 private:
  const SoilReference* reference_;
  const CalibrationTarget* points_;
  double pressure_ = 0;
};

/// How far the curves of a test are from their targets, both over the rms of the target:
/// error^2 = mean over curves of mean (y - y*)^2 / mean y*^2, y the mean over packings, at the samples that the target covers;
/// noise^2 the same of the standard error of that mean, sd/sqrt(packings). NaN: one packing.
struct Misfit {
  double error = 0, noise = 0;
  double level = 0;  ///< mean of y/rms(y*) over samples and curves: what rises when the soil is stronger
};
/// @throws ConfigError: a target covers fewer than three samples of its curve.
Misfit misfit(const CalibrationTest& test, const std::vector<SoilGroup>& groups);

/// Parameters that were tried, and what came out.
struct CalibrationSet {
  std::vector<double> values;  ///< of the parameters, five digits
  std::array<Misfit, 2> misfit{};
  double total = 0, noise = 0;  ///< sqrt of the weighted mean of the squares
  std::array<std::vector<SoilGroup>, 2> curves;
  std::string failure;  ///< why a case of it stopped; then there are no numbers
};

/// What all sets together say. Sets whose total error is no larger than that of the best with its noise added in squares are
/// not told apart from it.
struct CalibrationSummary {
  std::size_t best = 0;                               ///< of the total error
  std::array<std::size_t, 2> best_of{};               ///< of one test alone
  std::vector<bool> front;                            ///< Pareto: no other set is better in both tests
  std::vector<bool> like_best;                        ///< not told apart from the best
  std::vector<std::pair<double, double>> range_like;  ///< smallest and largest of each parameter among these
  std::array<std::vector<Slope>, 2> elasticity;       ///< d ln level/d ln parameter over all sets
};
CalibrationSummary summarize(const Calibration& c, const std::vector<CalibrationSet>& sets);

/// Runs the search; every case is stored in <out>/direct-shear and <out>/pressure-sinkage under a name with its hash, and is
/// found there when the same set is asked for again. `finished` is called after every batch of sets.
/// A set of which a case stops is listed with its reason and avoided. @throws ConfigError; dem::DemError: no set came to its end.
std::vector<CalibrationSet> calibrate(const Calibration& c, const std::filesystem::path& out, const SoilRunOptions& o,
                                      const std::function<void(const std::vector<CalibrationSet>&)>& finished);

report::FigurePage calibration_page(const Calibration& c, const std::vector<CalibrationSet>& sets);
/// sets.csv: every set in the order tried.
std::string sets_csv(const Calibration& c, const std::vector<CalibrationSet>& sets);
/// "5.0000e+07 Pa"-like text of a value, for files and people.
std::string value_text(const CalibrationParameter& p, double value);

}  // namespace grouser::app
