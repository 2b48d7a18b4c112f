#include "grouser/bekker/effects.h"

#include <algorithm>

namespace grouser::bekker {

const std::array<EffectInfo, effect_count>& effect_table() {
  using enum Effect;
  static const std::array<EffectInfo, effect_count> table{{
      {slip_sinkage_exponent, "slip_sinkage_exponent", "1", Hook::pressure, 0, 0, 1.5, 0.6, false,
       "the sinkage exponent grows with slip", "Ding et al. 2010"},
      {slip_sinkage_factor, "slip_sinkage_factor", "1", Hook::pressure, 0, 0, 1.5, 0.7, false,
       "slip enlarges the sinkage by a factor", "Vasil'ev; Lyasko 2010"},
      {slip_digging, "slip_digging", "m", Hook::geometry, 0, 0, 0.05, 0.003, false,
       "the slipping wheel digs soil away without bearing on it", "Reece 1965"},
      {pressure_rate, "pressure_rate", "1", Hook::pressure, 0, 0, 0.6, 0.1, false,
       "the pressure grows with the speed of penetration", "Pope 1969; Grahn 1991"},
      {shear_rate, "shear_rate", "1", Hook::shear, 0, -0.2, 0.2, 0.05, false,
       "the shear stress depends on the sliding speed", "granular rheology"},
      {repetitive_loading, "repetitive_loading", "1", Hook::pressure, 0, -0.5, 6, 0.8, false,
       "soil that was rolled over before is stiffer", "Wong"},
      {pass_strength, "pass_strength", "1", Hook::shear, 0, -0.5, 1, 0.1, false,
       "soil that was rolled over before is stronger in shear", "Wong"},
      {bulldozing, "bulldozing", "1", Hook::force, 0, 0, 10, 1, false, "the wheel pushes soil ahead of it",
       "Bekker 1969; Hegedus 1960"},
      {side_wall, "side_wall", "1", Hook::force, 0, 0, 50, 2, false, "the soil drags on the wheel's sides",
       "Wong; Ishigami"},
      {lugs, "lugs", "m", Hook::shear, 0, 0, 0.05, 0.01, false, "the soil shears outside the rim, at the lugs",
       "Ding et al. 2011"},
      {interface_friction, "interface_friction", "1", Hook::shear, 1, 0.2, 1, 0.75, false,
       "soil slides on the wheel's surface before it shears", "Wong"},
      {flexible_wheel, "flexible_wheel", "1", Hook::geometry, 0, 0, 1, 0.15, false, "the wheel flattens under load",
       "Bekker; Schmid 1995"},
      {hard_pan, "hard_pan", "m", Hook::pressure, 0, 0, 50, 5, true, "a hard layer lies below", "Bekker"},
      {residual_shear, "residual_shear", "1", Hook::shear, 0, 0, 2, 0.25, false,
       "the shear stress has a peak and falls to a residual value", "Wong; Oida"},
      {contact_angle_curvature, "contact_angle_curvature", "1", Hook::pressure, 0, -1, 1, 0.2, false,
       "the place of the largest pressure moves with slip in another way", "Wong & Reece 1967"},
      {exit_angle, "exit_angle", "1", Hook::geometry, 0, 0, 0.9, 0.25, false,
       "the soil rebounds behind the wheel and the contact ends later", "Wong & Reece 1967"},
      {shear_modulus_load, "shear_modulus_load", "1", Hook::covariate, 0, -2, 2, 0.5, false,
       "the shear displacement K grows with the load", "Wong"},
      {plate_size, "plate_size", "1", Hook::covariate, 0, -1.5, 0.8, 0.35, false,
       "the modulus depends on the size of the contact", "Bekker"},
      {preparation_drift, "preparation_drift", "1", Hook::covariate, 0, -0.9, 3, 0.2, false,
       "the soil changed in the course of the series", "-"},
  }};
  return table;
}

std::optional<Effect> effect_of(std::string_view name) {
  for (const EffectInfo& e : effect_table())
    if (e.name == name) return e.id;
  return std::nullopt;
}

EffectValues no_effects() {
  EffectValues v{};
  for (const EffectInfo& e : effect_table()) v[static_cast<std::size_t>(e.id)] = e.off;
  return v;
}

}  // namespace grouser::bekker
