#pragma once
// FIT.yaml: what to fit to which data; the result as numbers, curves and a soil file. Schema: diagnosis/README.md.
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace grouser::diagnosis {

/// A fitted value as it is shown, in the unit of the soil file.
struct ShownParameter {
  std::string name, unit;
  double value = 0, standard_error = 0, lower = 0, upper = 0;  ///< 95 % interval; NaN = cannot be said
  std::string note;                                            ///< "at its bound", "not identifiable", prior and its z
};

struct FitTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// Measured points of one test and channel and the fitted curve through them; curves of one figure share its axes.
struct FitCurve {
  std::string figure, x_label, y_label, name;
  std::vector<double> x, measured, fitted, error;  ///< error may be empty
  std::vector<double> line_x, line_y;              ///< the law between and beyond the points
};

struct FitSection {
  std::string kind;  ///< direct_shear, pressure_sinkage, wheel
  std::string data;  ///< file, number of tests and rows
  std::vector<ShownParameter> parameters;
  Eigen::MatrixXd correlation;
  std::vector<std::string>
      remarks;  ///< what a reader must know: not identifiable, at a bound, does not fit within the errors, ...
  std::vector<FitTable> tables;
  std::vector<FitCurve> curves;
};

struct FitReport {
  std::string title, source;
  std::vector<FitSection> sections;
  FitTable compare;       ///< empty without `compare:`
  std::string soil_text;  ///< the soil file; empty when values are missing
  std::string soil_note;  ///< why there is none
};

/// Reads the file and the data it names and fits. @throws ConfigError with every error of the file and its tables.
FitReport run_fit(const std::filesystem::path& yaml);

/// parameters.csv, correlation.csv, fit.csv (measured and fitted), compare.csv, soil.yaml in `folder`, which is made.
/// @throws ResultsError: cannot be written.
void write_fit(const FitReport& report, const std::filesystem::path& folder);

}  // namespace grouser::diagnosis
