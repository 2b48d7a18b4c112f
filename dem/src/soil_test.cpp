#include "grouser/dem/soil_test.h"

#include <algorithm>

namespace grouser::dem {

std::vector<double> Table::column(const std::string& name) const {
  const auto at = std::find(columns.begin(), columns.end(), name);
  if (at == columns.end()) throw DemError("table without a column '" + name + "'");
  std::vector<double> out;
  for (const auto& r : rows) out.push_back(r[static_cast<std::size_t>(at - columns.begin())]);
  return out;
}

void Table::traverse(State& s, const char* name) {
  std::vector<double> values;
  for (const auto& r : rows) values.insert(values.end(), r.begin(), r.end());
  s.field(name, values);
  if (!s.loading()) return;
  const std::size_t n = columns.size();
  rows.clear();
  for (std::size_t k = 0; n > 0 && k + n <= values.size(); k += n)
    rows.emplace_back(values.begin() + static_cast<std::ptrdiff_t>(k),
                      values.begin() + static_cast<std::ptrdiff_t>(k + n));
}

void SoilTest::traverse(State& s) {
  // What the test knows comes first: it may add bodies before the solver's state is read.
  own_state(s);
  table_.traverse(s, "table");
  const auto g = s.group("solver");
  solver_->traverse(s);
}

}  // namespace grouser::dem
