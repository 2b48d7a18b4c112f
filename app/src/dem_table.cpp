#include "dem_table.h"

#include <fmt/core.h>

namespace grouser::app {

std::string csv_text(const dem::Table& t) {
  std::string out;
  for (std::size_t c = 0; c < t.columns.size(); ++c) out += (c ? "," : "") + t.columns[c];
  out += '\n';
  for (const auto& r : t.rows) {
    for (std::size_t c = 0; c < r.size(); ++c) out += fmt::format("{}{:.9g}", c ? "," : "", r[c]);
    out += '\n';
  }
  return out;
}

}  // namespace grouser::app
