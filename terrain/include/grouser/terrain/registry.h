#pragma once
// Models by id. One explicit line per model in app/models/models.cpp.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "grouser/terrain/config.h"
#include "grouser/terrain/soil.h"
#include "grouser/terrain/terrain.h"

namespace grouser {

/// What a model is made from.
struct TerrainArgs {
  const Soil& soil;
  GroundPtr ground;
  ConfigNode options;     ///< the model's own options; may be an absent node: every option has a default
  double gravity = 9.81;  ///< [m/s^2]
};

struct ModelInfo {
  std::string id;                  ///< e.g. "bekker.steady"
  std::string summary;             ///< one line
  std::string can, cannot;         ///< one line each, for the README's table and `grouser list models`
  std::string annotated_defaults;  ///< YAML text with comments: every option with meaning, unit, range, default
  /// Reads options (reporting errors to their diagnostics) and builds the model. May throw ConfigError.
  std::function<std::unique_ptr<Terrain>(const TerrainArgs&)> make;
};

class Registry {
 public:
  void add(ModelInfo m);  ///< @throws std::logic_error for an id that is taken
  const std::vector<ModelInfo>& models() const { return models_; }
  /// @throws std::out_of_range with the nearest id for an unknown one.
  const ModelInfo& get(const std::string& id) const;
  bool has(const std::string& id) const;

 private:
  std::vector<ModelInfo> models_;
};

}  // namespace grouser
