#include "closed_form.h"

#include "kernel.h"
#include "product_rule.h"

namespace grouser::bekker {

WheelWrench closed_form(const Arc& arc, Method method, double& pressure_z) {
  const StressSums s = kernel().closed_form(arc, method);
  const double rb = arc.r * arc.b, rrb = arc.r * rb;
  pressure_z = rb * s.sigma_cosine;
  return {rb * (s.t_cosine - s.sigma_sine),
          -rb * s.l_one,
          rb * (s.sigma_cosine + s.t_sine),
          -rrb * s.l_cosine,
          -rrb * s.t_one,
          -rrb * s.l_sine};
}

WheelWrench closed_form(const ForceCase& c, Method method) {
  double pressure_z;
  return closed_form(Arc(c), method, pressure_z);
}

WheelForces closed_form_forces(const Arc& arc, Method method) {
  ProductRule rule(arc, method);
  rule.weigh();
  WheelForces out;
  const double rb = arc.r * arc.b, rrb = arc.r * rb;
  const auto add = [&](std::array<double, 6>& d, int i, double t, double l) {
    d[0] += rb * t * rule.cosine(i);
    d[1] -= rb * l * rule.one(i);
    d[2] += rb * t * rule.sine(i);
    d[3] -= rrb * l * rule.cosine(i);
    d[4] -= rrb * t * rule.one(i);
    d[5] -= rrb * l * rule.sine(i);
  };
  std::array<double, 6> shear{};
  for (int i = 0; i < rule.size(); ++i) {
    ArcSlope slope;
    const ArcStress s = stress_at(arc, rule.angles()[i], slope);
    out.pressure_x -= rb * s.sigma * rule.sine(i);
    out.pressure_z += rb * s.sigma * rule.cosine(i);
    out.capacity += rb * arc.tan_phi * s.sigma * rule.one(i);
    add(shear, i, s.tau_t, s.tau_l);
    add(out.d_t, i, slope.tau_t_by_t, slope.tau_l_by_t);
    add(out.d_l, i, slope.tau_t_by_l, slope.tau_l_by_l);
  }
  out.capacity += rb * arc.cohesion * (arc.theta_f - arc.theta_r);
  out.Fx = out.pressure_x + shear[0];
  out.Fy = shear[1];
  out.Fz = out.pressure_z + shear[2];
  out.Mx = shear[3];
  out.My = shear[4];
  out.Mz = shear[5];
  out.evaluations = rule.size();
  return out;
}

}  // namespace grouser::bekker
