#pragma once
// Model `bekker.soil_node`: dynamic Bekker on a sparse grid of soil nodes.
#include "grouser/terrain/registry.h"

namespace grouser::bekker {

/// Every node remembers its plastic depth and its shear. With z the depth of the gear's surface below the undisturbed ground at the node,
/// m the surface's normal into the gear, a the area of a node, w the share of its cell under the gear:
///   virgin (z >= zu): p = k z^n, zu = z;   else p = max(0, k zu^n - ku (zu - z))                                   (N1, eq 2.12)
///   ku = max(ko + Au zu, R pu/zu), R = max(1, (n + 1)/2); without `repetitive` R = 1/unloading_rebound             (N2)
///   force = a w/m_z (p m - (c + p tan phi) u/K0)                                                                   (N3)
///   u' = v_t, held to |u| <= y = K0 f(J), J' = rate at which |u| presses outward beyond y                          (N4)
/// v_t sliding velocity of the gear's surface in its tangent plane [m/s], u elastic shear displacement [m], f the soil's shear curve of
/// type A, B or C, K0 = 1/f'(0). Straight sliding by j gives tau = (c + p tan phi) f(j); back and forth is elastic: a parked wheel does not
/// creep. u and J are forgotten when the pressure has gone. The pressure acts along the surface's own normal, so pushing soil down costs
/// drawbar (compaction resistance).
/// Lugs as a mean (option lugs, eqs 2.14, 2.15): p = mu k z^n + (1 - mu) k z_ca^n on the cylinder over the tips, z_ca depth of the tread;
/// ku by the work of both, R p^2/(mu p_t z + (1 - mu) p_ca z_ca). `auto` takes lugs one by one (tips and tread, flanks carry nothing) from a
/// width of 2 spacings and 4 K.                                                                                   (N5)
/// Closure `wong` (option): stresses of bekker.steady from the wheel's own theta_f, summed over the nodes; smooth cylinders only; for
/// comparison with the steady wheel, not for vehicles that park or bounce.
/// Effects, off by default: soil_damping [s/m], and of effects.h bulldozing, side_wall, slip_sinkage_exponent, slip_sinkage_factor, plate_size,
/// hard_pan, repetitive_loading, pass_strength (by the nodes' own memory), interface_friction, residual_shear, pressure_rate, shear_rate; how
/// each acts on a node: README_soil_node.md (closure wong: soil_damping).
/// Range: any gear, sinkage to about half the radius. Cannot: flow of soil to the sides or upwards, walls of a rut.
/// Errors: std::invalid_argument from make for a soil without `bekker:`, ConfigError for options, TerrainError from set_effect for
/// bulldozing on a soil without bulk_density, from add_body for closure wong with lugs or a mesh.
/// Cost and memory: README.md. Sources: Wong 2010; Janosi & Hanamoto 1961; dissertation sections 2.1, 2.3, 4.1.2 with its errata.
ModelInfo soil_node_model();

}  // namespace grouser::bekker
