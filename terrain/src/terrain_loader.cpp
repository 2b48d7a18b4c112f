#include "grouser/terrain/terrain_loader.h"

#include <optional>
#include <sstream>
#include <stdexcept>

#include "grouser/terrain/loaders.h"

namespace grouser {

namespace {
std::vector<std::string> ids_of(const Registry& registry) {
  std::vector<std::string> ids;
  for (const ModelInfo& m : registry.models()) ids.push_back(m.id);
  return ids;
}

/// The section of one model inside a map keyed by model id. Keys of other registered models are accepted.
ConfigNode section_of(const Registry& registry, const ConfigNode& by_model, const std::string& model) {
  if (!by_model.present()) return {};
  for (const ModelInfo& m : registry.models()) by_model.has(m.id);
  by_model.finish();
  return by_model.optional_map(model);
}

/// Amplitudes by effect id, each in the effect's own unit and bounds.
void set_effects(Terrain& terrain, const ConfigNode& node) {
  if (!node.present()) return;
  const std::vector<Effect> declared = terrain.effects();
  for (const Effect& e : declared)
    if (const auto a = node.optional_quantity(e.id, e.unit, Range::between(e.lower, e.upper)))
      if (*a >= e.lower && *a <= e.upper) {
        try {
          terrain.set_effect(e.id, *a);
        } catch (const TerrainError& refused) {  // the model or its soil cannot
          node.error_at(e.id, refused.what());
        }
      }
  if (declared.empty() && !node.keys().empty()) node.error(terrain.id() + " has no effects");
  node.finish();
}

/// `effects:` of a terrain map: amplitudes by model, or the name of a file that has them under `amplitudes`.
class EffectsSection {
 public:
  explicit EffectsSection(const ConfigNode& terrain_map) {
    const ConfigNode written = terrain_map.node("effects");
    if (!written.present() || !written.is_scalar()) {
      by_model_ = terrain_map.optional_map("effects");
      return;
    }
    const std::filesystem::path path = terrain_map.existing_file("effects");
    if (!std::filesystem::is_regular_file(path)) return;
    file_ = ConfigDocument::from_file(path);
    const ConfigNode root = file_->root();
    root.text("effects");
    root.text_or("source", "");
    by_model_ = root.map("amplitudes");
    root.finish();
  }
  const ConfigNode& by_model() const { return by_model_; }
  /// Of the file, when there is one.
  std::vector<Diagnostic> diagnostics() const { return file_ ? file_->diagnostics() : std::vector<Diagnostic>{}; }
  void tell(const ConfigNode& terrain_map, const ConfigDocument* document) const {
    if (!file_) return;
    if (document)
      document->absorb(*file_);
    else
      for (const Diagnostic& d : file_->diagnostics()) terrain_map.report(d);
  }

 private:
  std::optional<ConfigDocument> file_;
  ConfigNode by_model_;
};

/// Options and effects of the models that are not in use: each model reads its own, on a second reading of the file, so
/// that it assumes nothing in this one.
void check_other_sections(const Registry& registry, const ConfigNode& terrain_map, const std::string& used,
                          const Soil& soil, const GroundPtr& ground, double gravity, const ConfigDocument& document) {
  const ConfigDocument again =
      ConfigDocument::from_text(document.text(), document.file(), std::filesystem::path(document.file()).parent_path());
  ConfigNode map = again.root();
  std::istringstream path(terrain_map.path());
  for (std::string key; std::getline(path, key, '.');) map = map.node(key);
  if (!map.present()) return;
  const EffectsSection written(map);
  const std::size_t told = written.diagnostics().size();
  for (const ModelInfo& m : registry.models()) {
    if (m.id == used) continue;
    const ConfigNode options = map.optional_map("options").optional_map(m.id);
    const ConfigNode effects = written.by_model().optional_map(m.id);
    if (!options.present() && !effects.present()) continue;
    try {
      set_effects(*m.make({soil, ground, options, gravity}), effects);
    } catch (const std::invalid_argument&) {
      // A model that this soil does not serve: it would say so if it were in use.
    }
  }
  for (const Diagnostic& d : again.diagnostics()) terrain_map.report(d);
  const std::vector<Diagnostic> of_file = written.diagnostics();
  for (std::size_t i = told; i < of_file.size(); ++i) terrain_map.report(of_file[i]);
}
}  // namespace

std::unique_ptr<Terrain> make_terrain(const Registry& registry, const TerrainNodes& nodes, GroundPtr ground,
                                      double gravity, const ConfigDocument* document) {
  const std::filesystem::path file = nodes.owner.existing_file("soil");
  if (!std::filesystem::is_regular_file(file) || !registry.has(nodes.model) || !ground) return nullptr;
  const ConfigDocument soil_document = ConfigDocument::from_file(file);
  const Soil soil = load_soil(soil_document.root());
  /// False when the soil file has errors, which are handed on.
  const auto sound = [&] {
    if (!document) soil_document.check();
    if (document) document->absorb(soil_document);
    return soil_document.diagnostics().empty();
  };
  if (!sound()) return nullptr;
  // Options that the file leaves out are an empty section, so that the model can still say which of its defaults it assumes.
  const ConfigDocument left_out = ConfigDocument::from_text("options: {" + nodes.model + ": {}}", nodes.owner.file());
  const bool given = nodes.options.present();
  const ConfigNode options = given ? nodes.options : left_out.root().map("options").map(nodes.model);
  try {
    auto terrain = registry.get(nodes.model).make({soil, std::move(ground), options, gravity});
    if (!sound()) return nullptr;  // sections that only the model reads
    for (const Diagnostic& d : left_out.diagnostics()) nodes.owner.error(d.message);
    for (const Assumption& a : left_out.assumptions()) nodes.owner.assume(a.key, a.value, a.why);
    set_effects(*terrain, nodes.effects);
    return terrain;
  } catch (const std::invalid_argument& e) {  // the soil lacks what the model needs
    nodes.owner.error_at("soil", file.string() + ": " + e.what());
    return nullptr;
  }
}

std::unique_ptr<Terrain> make_terrain(const Registry& registry, const ConfigNode& terrain_map, GroundPtr ground,
                                      double gravity, std::optional<std::string> model_override,
                                      const ConfigDocument* document) {
  const std::vector<std::string> ids = ids_of(registry);
  std::string model = terrain_map.choice("model", ids);
  if (model_override) {
    if (!registry.has(*model_override)) {
      try {
        registry.get(*model_override);
      } catch (const std::out_of_range& e) {
        throw ConfigError("--terrain", 0, 0, e.what());
      }
    }
    model = *model_override;
  }
  TerrainNodes nodes{model, terrain_map, {}, {}};
  nodes.options = section_of(registry, terrain_map.optional_map("options"), model);
  const EffectsSection effects(terrain_map);
  nodes.effects = section_of(registry, effects.by_model(), model);
  auto terrain = make_terrain(registry, nodes, ground, gravity, document);
  effects.tell(terrain_map, document);
  terrain_map.finish();
  if (terrain && document)
    check_other_sections(registry, terrain_map, model, load_soil_file(terrain_map.existing_file("soil")), ground,
                         gravity, *document);
  return terrain;
}

}  // namespace grouser
