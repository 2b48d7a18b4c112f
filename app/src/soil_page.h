#pragma once
#include "figure_page.h"
#include "soil_run.h"

namespace grouser::app {

/// Curves of a group over its packings: at every sample the mean, the standard deviation and the number of packings.
struct SoilGroup {
  std::string name, variant, curve;
  const SoilCase* first = nullptr;
  std::string first_column;
  std::vector<double> x;
  std::vector<std::string> columns;           ///< without the first
  std::vector<std::vector<double>> mean, sd;  ///< per column
  std::size_t packings = 0;
};
/// Value at q of a piecewise linear curve with rising x; NaN outside.
double value_at(const std::vector<double>& x, const std::vector<double>& y, double q);
std::vector<SoilGroup> group_curves(const std::vector<SoilCaseResult>& results);

/// Figures with mean and spread next to the reference, and a table of the end values.
report::FigurePage soil_page(const SoilFile& file, const std::vector<SoilCaseResult>& results);
/// mean.csv: every group, long form.
std::string mean_csv(const std::vector<SoilGroup>& groups);

}  // namespace grouser::app
