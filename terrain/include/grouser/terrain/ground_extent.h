#pragma once
// Where a ground has data and where it only continues them.
#include <string>

#include "grouser/terrain/ground.h"

namespace grouser {

/// A ground whose heights come from data of limited extent: a measured profile, a height map, a sum that holds one.
class GroundWithData {
 public:
  virtual ~GroundWithData() = default;
  /// Empty where (x, y) [m] lies on the data, or where the file asks for what comes there (`repeat`, `mirror`, a run-in); else what
  /// the heights are instead: "profile x.csv: left of the outermost line, whose heights continue". No allocation on the data.
  virtual std::string beyond_data(double x, double y) const = 0;
};

/// beyond_data() of a ground that has it, empty for every other.
inline std::string beyond_data(const Ground& g, double x, double y) {
  const auto* data = dynamic_cast<const GroundWithData*>(&g);
  return data ? data->beyond_data(x, y) : std::string();
}

}  // namespace grouser
