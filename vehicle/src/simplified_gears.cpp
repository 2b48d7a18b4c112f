#include "simplified_gears.h"

#include <map>

namespace grouser::vehicle {

void tell_simplified_gears(const Terrain& terrain, const std::string& file, std::vector<Assumption>& assumptions,
                           std::vector<std::string>& notices) {
  std::map<std::string, std::string> alike;  // wheels by what is said of them
  for (std::size_t i = 0; i < terrain.bodies().size(); ++i) {
    const auto s = terrain.simplified_gear(static_cast<int>(i));
    if (!s) continue;
    const std::string& name = terrain.bodies()[i].name;
    assumptions.push_back({file, name, s->as, s->why});
    std::string& names = alike[s->as + "; " + s->why];
    names += (names.empty() ? "" : ", ") + name;
  }
  for (const auto& [what, names] : alike) notices.push_back(names + " simplified: " + what);
}

}  // namespace grouser::vehicle
