#pragma once
// All effects a diagnosis considers: those of the model (bekker/effects.h) and the maps of the measurement, which live here only.
#include <cstdint>
#include <string>
#include <vector>

namespace grouser::diagnosis {

/// Measurement maps. They change what a rig shows, never what a vehicle feels.
enum class Map : std::uint8_t {
  torque_offset,       ///< T += T0
  torque_viscous,      ///< T += b w
  torque_bearing,      ///< T += b W
  drawbar_bias,        ///< F += F0
  bed_slope,           ///< F -= W tan a
  sinkage_datum,       ///< z += z0
  rig_compliance,      ///< z += C W
  wheel_radius_error,  ///< r_true = r/(1 + e): slip anew with v/(r_true w)
  load_error,          ///< W (1 + e)
  drawbar_gain,        ///< F (1 + e)
  torque_gain,         ///< T (1 + e)
};
constexpr int map_count = 11;

/// One amplitude in the list: model effects first, in the order of bekker::effect_table(), then the maps.
struct EffectEntry {
  std::string id, unit, says;
  double off, lower, upper, typical;
  bool inverse;  ///< shown as 1/amplitude
  bool is_map;
  double shown;             ///< shown value = amplitude * shown
  const char* bench_check;  ///< what settles a sensor effect without soil; nullptr for model effects
};
const std::vector<EffectEntry>& effect_entries();
std::vector<std::string> effect_ids();
int entry_of(const std::string& id);  ///< -1 when there is none

}  // namespace grouser::diagnosis
