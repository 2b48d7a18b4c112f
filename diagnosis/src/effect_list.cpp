#include "effect_list.h"

#include "grouser/bekker/effects.h"

namespace grouser::diagnosis {

const std::vector<EffectEntry>& effect_entries() {
  static const std::vector<EffectEntry> list = [] {
    std::vector<EffectEntry> out;
    for (const bekker::EffectInfo& e : bekker::effect_table())
      out.push_back({std::string(e.name), std::string(e.unit), std::string(e.says), e.off, e.lower, e.upper, e.typical,
                     e.inverse, false, 1, nullptr});
    const double deg = 0.017453292519943295;
    const auto map = [&](const char* id, const char* unit, const char* says, double bound, double typical, double shown,
                         const char* check) {
      out.push_back({id, unit, says, 0, -bound, bound, typical, false, true, shown, check});
    };
    const char *spin = "turn the wheel clear of the ground at two speeds, with and without load on its bearing",
               *dead = "hang a known weight on the drawbar sensor", *level = "put a spirit level on the bed",
               *plate = "set the wheel on a rigid plate at two loads", *scale = "weigh the wheel on a balance",
               *roll = "roll the wheel ten turns on hard ground and measure the way",
               *arm = "hang a known weight on an arm of known length at the torque sensor";
    map("torque_offset", "N m", "the torque sensor has an offset", 10, 0.3, 1, spin);
    map("torque_viscous", "N m s/rad", "the drive's friction grows with speed", 50, 0.4, 1, spin);
    map("torque_bearing", "m", "the bearing's friction grows with load", 0.1, 0.003, 1, spin);
    map("drawbar_bias", "N", "the drawbar sensor has an offset", 100, 2, 1, dead);
    map("bed_slope", "deg", "the bed is not level", 0.3, 0.025, 1 / deg, level);
    map("sinkage_datum", "m", "the zero of the sinkage is off", 0.05, 0.002, 1, plate);
    map("rig_compliance", "m/N", "the rig gives way under load", 1e-3, 2e-5, 1, plate);
    map("wheel_radius_error", "1", "the slip was computed with a wrong radius", 0.3, 0.03, 1, roll);
    map("load_error", "1", "the load is not what is stated", 0.5, 0.04, 1, scale);
    map("drawbar_gain", "1", "the drawbar sensor has a wrong gain", 0.5, 0.04, 1, dead);
    map("torque_gain", "1", "the torque sensor has a wrong gain", 0.5, 0.04, 1, arm);
    return out;
  }();
  return list;
}

std::vector<std::string> effect_ids() {
  std::vector<std::string> out;
  for (const EffectEntry& e : effect_entries()) out.push_back(e.id);
  return out;
}

int entry_of(const std::string& id) {
  for (std::size_t i = 0; i < effect_entries().size(); ++i)
    if (effect_entries()[i].id == id) return static_cast<int>(i);
  return -1;
}

}  // namespace grouser::diagnosis
