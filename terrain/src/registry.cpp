#include "grouser/terrain/registry.h"

#include <stdexcept>

namespace grouser {

void Registry::add(ModelInfo m) {
  if (has(m.id)) throw std::logic_error("terrain model '" + m.id + "' is registered twice");
  models_.push_back(std::move(m));
}

bool Registry::has(const std::string& id) const {
  for (const ModelInfo& m : models_)
    if (m.id == id) return true;
  return false;
}

const ModelInfo& Registry::get(const std::string& id) const {
  std::vector<std::string> ids;
  std::string all;
  for (const ModelInfo& m : models_) {
    if (m.id == id) return m;
    ids.push_back(m.id);
    all += (all.empty() ? "" : ", ") + m.id;
  }
  const auto near = did_you_mean(id, ids);
  throw std::out_of_range("unknown terrain model '" + id + "'" + (near ? "; did you mean '" + *near + "'?" : ".") +
                          " Known: " + all);
}

}  // namespace grouser
