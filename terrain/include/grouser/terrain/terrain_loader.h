#pragma once
// A terrain from its YAML map: one place for scenarios, the rig and load_terrain().
#include <memory>
#include <optional>
#include <string>

#include "grouser/terrain/registry.h"

namespace grouser {

/// Parts of a terrain in a file, wherever they stand.
struct TerrainNodes {
  std::string model;   ///< id
  ConfigNode owner;    ///< the map that holds `soil:`, for messages
  ConfigNode options;  ///< the model's own options; may be absent
  ConfigNode effects;  ///< effect id -> amplitude with its unit; may be absent
};

/// Build from parts. Errors are noted in the nodes' document; nullptr is returned when there was one, so call the document's
/// check() before use. `document`, when given, takes over the diagnostics and assumptions of the soil file; without it a bad
/// soil file throws.
/// @throws ConfigError for a bad soil file when document is null.
std::unique_ptr<Terrain> make_terrain(const Registry& registry, const TerrainNodes& nodes, GroundPtr ground,
                                      double gravity, const ConfigDocument* document = nullptr);

/// Build from a scenario's map
///
///   terrain: {model: bekker.steady, soil: sand.yaml, options: {bekker.steady: {strips: 3}}, effects: {bekker.steady: {id: 1}}}
///
/// `effects:` may also name a file with the same map under `amplitudes` (`effects: title`, `source:` text). Options and effects are keyed by model id, so that `model_override` (the command line's --terrain) swaps the model and nothing else.
/// Calls finish() on the map. Unknown ids get a "did you mean" at their line and column.
/// @throws ConfigError for an unknown `model_override`, and as above.
std::unique_ptr<Terrain> make_terrain(const Registry& registry, const ConfigNode& terrain_map, GroundPtr ground,
                                      double gravity, std::optional<std::string> model_override,
                                      const ConfigDocument* document = nullptr);

}  // namespace grouser
