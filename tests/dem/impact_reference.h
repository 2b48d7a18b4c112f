#pragma once
// Two spheres that collide, as differential equations solved by CVODE to a tight tolerance: the law written out
// again from eqs 3.9 to 3.13 (Mindlin's stiffness), without the solver's code. Without caps.
#include <array>

struct Impact {
  double r[2] = {0.00125, 0.005};
  double density = 3100, young = 7e7, poisson = 0.35, restitution = 0.4;
  std::array<double, 3> v[2] = {{0, 0, 0}, {0, 0, 0}};  // sphere 0 at the origin, 1 ahead along `axis`
  std::array<double, 3> w[2] = {{0, 0, 0}, {0, 0, 0}};
  std::array<double, 3> axis = {1, 0, 0};
  bool tangential = false;
  /// Mass and moment of inertia of sphere 1 as infinite, radius kept: a rigid target.
  bool fixed_target = false;
};
struct Outcome {
  std::array<double, 3> v[2], w[2];
  double time;  // duration of contact
};
Outcome solve_impact(const Impact& c, double rtol);
