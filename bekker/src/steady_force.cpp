#include "steady_force.h"

#include "closed_form.h"

namespace grouser::bekker {

WheelForces steady_force(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, double slip,
                         Method method, Quadrature quadrature, double pressure_factor) {
  if (method == Method::nonlinear) return steady_forces(wheel, soil, theta_f, e, slip, quadrature, pressure_factor);
  WheelForces out;
  const ContactRange range = contact_range(soil, theta_f, slip);
  if (theta_f > 0 && !range.front_branch_empty)
    out = closed_form_forces(Arc(wheel, soil, {range.theta_f, range.theta_m, range.theta_r}, e, 0, pressure_factor),
                             method);
  out.range = range;
  return out;
}

}  // namespace grouser::bekker
