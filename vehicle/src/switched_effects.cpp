#include "switched_effects.h"

#include <cstdio>

namespace grouser::vehicle {

std::string switched_effects(const Terrain& terrain, const Registry& registry) {
  const std::vector<Effect>& now = terrain.effects();
  if (now.empty()) return "";
  // A model as it is made has every effect off; which soil it stands on does not matter for that.
  Soil any;
  any.bekker.emplace();
  any.bekker->pressure = {PressureSinkage::Law::k_b, 0, 0, 1e5, 1, 0.1};
  any.bekker->shear = {ShearLaw::Type::A, 0, 0.5, 0.01, 0, 1};
  any.rigid.emplace();
  const auto plain = registry.get(terrain.id()).make({any, flat_ground(), {}, 9.81});
  std::string text;
  for (const Effect& e : now) {
    double off = 0;
    for (const Effect& p : plain->effects())
      if (p.id == e.id) off = p.amplitude;
    if (e.amplitude == off) continue;
    char value[48];
    std::snprintf(value, sizeof value, " %.6g", e.amplitude);
    text += (text.empty() ? "" : ", ") + e.id + value + (e.unit == "1" ? "" : " " + e.unit);
  }
  return text;
}

}  // namespace grouser::vehicle
