#pragma once
// Hard ground: penalty spring-damper and Coulomb friction. The baseline of every soil.
#include "grouser/terrain/registry.h"

namespace grouser {

/// Model `rigid`. With the contact patch (contact_patch.h): h [m] equivalent sinkage, g [-] generalised normal (6), V twist,
/// N = k h + clamp(d hdot, -k h, k h), hdot = -g . V, wrench = N g                                             (R1)
///   k [N/m], d [N s/m]. k h g is the gradient of k h^2/2, so it is conservative on any ground; the damper never exceeds the
///   spring, so the force is continuous at touch-down and never tensile, and is the plain k h + d hdot near rest.
/// Friction: bristle u [m] in the contact plane, v_s = sliding velocity of the wheel's surface (r w - v, -v_y),
///   u' = v_s - |r w| u / sigma, T = k_t u + d_t v_s, |T| <= mu N (u is set back to the cone)                    (R2)
///   sigma = contact length: the bristles roll off. At rest u is kept: true stick.
/// Rolling resistance: M_y = -c_r N r q, q' = (r w - |r w| q)/sigma (Dahl), so it also holds a wheel at rest      (R3)
/// Valid for sinkage below the radius. Any running gear as the cylinder of its outer radius and width (lugs and mesh detail are
/// not resolved). Cost: about 1 us per wheel and step on smooth ground.
/// Sources: Dahl 1968 (R3), bristle form of Coulomb friction as in Haessig & Friedland 1991 (R2).
ModelInfo rigid_model();

}  // namespace grouser
