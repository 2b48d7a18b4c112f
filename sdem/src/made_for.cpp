#include "made_for.h"

#include <cmath>
#include <cstdio>

#include "grouser/sdem/v1.h"

namespace grouser::sdem {

std::filesystem::path named_file(const ConfigNode& o, const FileKind& kind) {
  const ConfigNode file = o.node(kind.key);
  const bool named = file.present() && !(file.is_scalar() && file.as_text() == "none");
  return named ? o.existing_file(kind.key) : std::filesystem::path();
}

void check_soil(const ConfigNode& o, const FileKind& kind, const std::string& grains, const Soil& soil) {
  const std::string given = soil_text(soil.dem), noun = kind.noun;
  if (given.empty())
    o.error_at(kind.key, std::string(kind.content) + ", and soil '" + soil.name +
                             "' has no section 'dem:' that could be shown to be the same; add it" + kind.how_to_see +
                             " or say 'other_soil: accept'");
  else if (const std::string d = first_difference(grains, given); !d.empty())
    o.error_at(kind.key, "is of another soil than '" + soil.name + "' (" + noun + " | soil file): " + d +
                             "; name the " + noun + " of this soil, or say 'other_soil: accept'");
}

void check_wheel(const FileKind& kind, const BodySpec& b, double radius, const std::string& wheel) {
  const double r = b.gear.outer_radius();
  if (std::abs(r - radius) <= 1e-3 * r) return;
  char text[200];
  std::snprintf(text, sizeof text, "its radius is %.6g m, and the %s %s of a wheel of %.6g m ('", r, kind.noun,
                kind.verb, radius);
  throw TerrainError(std::string(kind.model) + " cannot carry body '" + b.name + "': " + text + wheel + "')");
}

}  // namespace grouser::sdem
