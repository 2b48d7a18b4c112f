#pragma once
#include "grouser/terrain/config.h"

namespace grouser::bekker {

/// Option `reference_width` of a model [m]: -1 the soil's, 0 the wheel's own.
inline double read_reference_width(const ConfigNode& options) {
  const ConfigNode n = options.node("reference_width");
  if (!n.present()) return -1;
  const std::string word = n.is_scalar() ? n.as_text() : "";
  if (word == "wheel") return 0;
  return word == "soil" ? -1 : n.as_quantity("m", Range::positive());
}

}  // namespace grouser::bekker
