#pragma once
// Grains and their law from YAML.
#include "grouser/dem/packing.h"
#include "grouser/terrain/config.h"

namespace grouser::dem {

/// soil:
///   diameter: [2.5 mm, 10 mm]           smallest and largest, uniform by number
///   density: 3.1 g/cm^3                 of grains while pouring
///   bulk_density: 1.6 g/cm^3            optional: density of grains is scaled to it
///   young_modulus, poisson_ratio, friction, restitution
///   rolling: {law: rate, coefficient: 6.75e8 s^2/m^2}     law: constant (coefficient without unit) | rate | rate_without_spin
///   cohesion: 0 J/m^3                   optional
///   wall: {friction: 0, restitution: 0.06}                optional: rolling_coefficient, in the unit of the law
///   wheel: {friction: 0.1, cohesion: 0 J/m^3}              optional: grains on wheels of dem.sphere, else as two grains; rolling_coefficient, restitution
///   model: hertz-ch4                    optional: hertz-ch3 wants normal_stiffness, shear_stiffness [Pa], gamma_n, gamma_t [1/(m s)]
///   cap: sum | springs, tangential_stiffness: mindlin | printed, damping: implicit | explicit       optional
/// A partial map (`base` given) changes what it names and keeps the rest: variants of a case.
SoilSettings read_soil(const ConfigNode& node, const SoilSettings* base = nullptr);

/// law: {model, rolling: constant | rate | rate_without_spin, cap, tangential_stiffness, damping}: each optional.
void read_law(const ConfigNode& node, LawSettings& law);

/// solver: {time_step: 8 us | auto, step_share: 0.17, precision: single | double}: each optional. auto: step_share of the Rayleigh
/// time of the smallest grain (set_step() makes it from the final parameters), 8 us with Table 4.2.
void read_solver(const ConfigNode& node, SoilSettings& soil);

}  // namespace grouser::dem
