#pragma once
// Model `bekker.steady`: the steady Bekker-Wong wheel under a vehicle that stops, turns, reverses and bounces.
#include "grouser/terrain/registry.h"

namespace grouser::bekker {

/// Force of the soil at the wheel's true sinkage: the contact patch gives the equivalent sinkage h and entry angle theta_f, the plane
/// (t forward, l left, n normal) and the length ratio lambda; the wheel force is lambda times eq 2.11 in that plane, from two
/// stress distributions, for travel to +t and mirrored for travel to -t:
///   W = (1 + d)/2 W+(theta_f, e_t, e_l) + (1 - d)/2 mirror W+(theta_f, -e_t, e_l)                                (S1)
/// Steady slip is undefined at rest, so rate-independent states of each wheel stand for it:
///   u' = v_s - (|r w|/sigma + |v_s|/K) u,   v_s = (r w - v_t, v_l) sliding velocity [m/s]                         (S2)
///   e = (u/sigma)/(1 - |u|/K)                                                                                     (S3)
///   d' = (v_t - |v_t| d)/l                                                                                        (S4)
///   s' = (r w - v_t - max(|r w|, |v_t|) s)/l, the slip in theta_m and theta_r                                     (S5)
///   sigma = relaxation_length * l, l = r theta_f contact length [m], K shear displacement of the soil [m].
/// Rolling steadily, e -> v_s/|r w| exactly, so eq 2.7 holds for any sigma. Without rolling |u|/K = 1 - exp(-x/K) after sliding by x:
/// Janosi-Hanamoto's curve, elastic and without creep when x returns, full mobilisation when the wheel stays locked. d = 0 is a wheel set
/// down from above: the two halves cancel and nothing pushes it. All are zero clear of the soil.
/// S2, S4 and S5 are integrated exactly for the velocities of the step.
///
/// At rest the load N/g of a wheel rocks on the stick and bounces on the pressure with the damping ratios `stick_damping` and
/// `bounce_damping`, both 0.15: u answers as u + tau u', sigma as sigma (1 + chi h'), never tensile; nothing changes in steady rolling,
///   tau = 2 zeta sqrt(K N/(g (c A + N tan phi))),   chi = 2 zeta sqrt((n + 1/2)/(g h))                            (S6, S7)
///
/// r: radius over the lugs, which is that of the patch; lugs by eqs 2.14 and 2.15 (mean pressure of tips and tread). Options choose the quadrature
/// or a closed form (eqs 2.17 to 2.20) for W+ and the direction of the shear stress.
/// Range: sinkage up to about half the radius; smooth grounds are exact, rough ones by the equivalent patch. Cannot: ruts and multi-pass,
/// single lugs and the ripple they cause, bulldozing, scrub moment of a wheel that turns on the spot.
/// Triangle meshes are refused by name. Errors: TerrainError from add_body; std::invalid_argument from make for a soil without
/// `bekker:`.
/// Effects, off by default: `vertical_damping` [s/m], sigma (1 + chi h'), never tensile (Hunt & Crossley 1975), and those of effects.h with
/// its equations, units, bounds and sources; what each does at rest, on reversal and over a hard pan: README.md. With all of them off the
/// law and its bits are the plain ones; switched on a wheel costs several times as much, with effects by load more.
/// TerrainError from set_effect: closed forms, soil without bulk_density (bulldozing, side_wall), `lugs` on a wheel with lugs.
/// Cost: README.md. Source: Wong & Reece 1967; Janosi & Hanamoto 1961; dissertation section 2.1 with its errata.
ModelInfo steady_model();

}  // namespace grouser::bekker
