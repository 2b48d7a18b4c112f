#pragma once
// Linear and quadratic closed forms of the wheel force (eqs 2.17 to 2.20), written as product integration: the
// integrals of eq 2.11 of a parabola or a straight line through stresses at a few angles are weighted sums of these
// stresses.
#include "arc.h"
#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// Six components by `method` (quadratic or linear) of a case whose status_of is ok.
WheelWrench closed_form(const ForceCase& c, Method method);
/// The same; pressure_z: the part of Fz that the pressure alone carries [N].
WheelWrench closed_form(const Arc& arc, Method method, double& pressure_z);
/// The same on virgin soil with pressure parts, shear capacity and derivatives by the shear state, in the form of the
/// quadrature; `range` is left to the caller.
WheelForces closed_form_forces(const Arc& arc, Method method);

}  // namespace grouser::bekker
