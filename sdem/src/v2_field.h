#pragma once
// `sdem.v2` with `rows`: wheels of a width, on soil that all of them share.
#include "grouser/sdem/field_wheel.h"

namespace grouser::sdem {

/// @throws TerrainError: no law, or a wheel of another radius than the law's.
void check_carries(const FieldSettings& o, const BodySpec& b);
std::unique_ptr<Terrain> make_v2_field(const FieldSettings& o, GroundPtr ground);

}  // namespace grouser::sdem
