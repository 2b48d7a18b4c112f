#pragma once
// The parts of a fit file. Each notes its errors in the node's document and returns what it found.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "grouser/diagnosis/data_table.h"
#include "grouser/diagnosis/fit_file.h"
#include "grouser/diagnosis/least_squares.h"
#include "grouser/terrain/soil.h"

namespace grouser::diagnosis {

/// The soil as far as it is known, each value with where it is from.
struct SoilDraft {
  struct Origin {
    std::string text;
    bool assumed = false;
  };
  BekkerSoil soil;
  double bulk_density = 0;
  std::map<std::string, Origin> origin;  ///< by key: "pressure.k", "shear.K", "contact_angles.a0", "bulk_density"
  void put(const std::string& key, const std::string& text) { origin[key] = {text, false}; }
  bool has_pressure() const { return origin.count("pressure.n") > 0; }
  bool has_shear() const { return origin.count("shear.friction_angle") > 0; }
};

/// Values of a soil file with their source; its errors go to the node's document.
SoilDraft draft_of_file(const ConfigNode& node, const std::string& key);
/// The soil file, or nothing and why.
std::pair<std::string, std::string> soil_file_text(const std::string& name, const std::string& source,
                                                   const SoilDraft& draft);

FitSection direct_shear_section(const ConfigNode& node, SoilDraft& draft);
FitSection plates_section(const ConfigNode& node, SoilDraft& draft);
FitSection wheel_section(const ConfigNode& node, SoilDraft& draft, FitTable& compare);

/// `number` with the digits that mean something.
std::string shown(double x, int digits = 4);
ShownParameter shown_parameter(const Estimate& e, const std::string& name, const std::string& unit, double scale);
/// Remarks that every fit has: not converged, weak directions, bounds, starts.
std::vector<std::string> general_remarks(const LeastSquaresResult& fit);
/// Rows of each label, in the order of first appearance.
std::vector<std::pair<std::string, std::vector<std::size_t>>> grouped(const std::vector<std::string>& labels);
ErrorModel error_model(const ConfigNode& node, const std::string& fallback);

}  // namespace grouser::diagnosis
