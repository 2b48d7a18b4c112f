#include "grouser/models.h"

#include "grouser/terrain/loaders.h"
#include "grouser/terrain/rigid.h"
#include "grouser/terrain/terrain_loader.h"
#ifdef GROUSER_BEKKER
#include "grouser/bekker/soil_node.h"
#include "grouser/bekker/steady.h"
#endif
#ifdef GROUSER_DEM
#include "grouser/dem/sphere.h"
#endif
#ifdef GROUSER_SDEM
#include "grouser/sdem/v1.h"
#include "grouser/sdem/v2.h"
#endif

namespace grouser {

const Registry& all_models() {
  static const Registry registry = [] {
    Registry r;
    r.add(rigid_model());
#ifdef GROUSER_BEKKER
    r.add(bekker::steady_model());
    r.add(bekker::soil_node_model());
#endif
#ifdef GROUSER_DEM
    r.add(dem::sphere_model());
#endif
#ifdef GROUSER_SDEM
    r.add(sdem::v1_model());
    r.add(sdem::v2_model());
#endif
    return r;
  }();
  return registry;
}

std::shared_ptr<Terrain> load_terrain(const std::filesystem::path& yaml) {
  const ConfigDocument document = ConfigDocument::from_file(yaml);
  const ConfigNode root = document.root();
  if (!root.present()) document.check();
  const Registry& registry = all_models();
  std::vector<std::string> ids;
  for (const ModelInfo& m : registry.models()) ids.push_back(m.id);

  TerrainNodes nodes{root.choice("terrain", ids), root, root.optional_map("options"), root.optional_map("effects")};
  const double gravity = root.quantity_or("gravity", 9.81, "m/s^2", Range::positive());
  const GroundPtr ground = root.has("ground") ? load_ground(root.node("ground"), 0) : flat_ground();
  std::shared_ptr<Terrain> terrain = make_terrain(registry, nodes, ground, gravity, &document);
  root.finish();
  document.check();
  return terrain;
}

}  // namespace grouser
