#pragma once
// Work that pressing a wheel into the ground takes on its way over a step.
#include <algorithm>
#include <cmath>

#include "grouser/terrain/wheel_motion.h"

namespace grouser {

/// Power of an elastic force F(h) g on the hub, F(h) h' [W], h' = -g . V (P3).
template <class Force>
double pressing_power(const ContactPatch& patch, const Twist& V, const Force& force) {
  if (!patch.contact) return 0;
  return -force(patch.sinkage) * (patch.g.template head<3>().dot(V.v) + patch.g.template tail<3>().dot(V.w));
}

/// Where a wheel that ends a step of constant twist in `end` was `ago` seconds before its end.
inline WheelPose earlier(const WheelPose& end, const Twist& V, double ago) {
  WheelPose p = end;
  p.hub_W -= ago * V.v;
  p.axis_W = (p.axis_W - ago * V.w.cross(p.axis_W)).normalized();
  return p;
}

/// Integral of F(h) h' dt over the step [J], h and g from the patches on the way: it knows no potential, so a ledger that holds it against
/// the change of a potential finds a force that is no gradient. `begin`, `end` [W]: pressing_power at the ends of the step; `expected` [J]:
/// what the potential says. The trapezoid of the ends is taken where it agrees with that to `tolerance` [J]; else adaptive Simpson, halves to
/// dt/64, until halving changes it by less than the tolerance. Cost: nothing, or a patch for each further point.
template <class Force>
double path_work(PatchFinder& finder, const Ground& ground, const WheelMotion& m, double dt, double begin, double end,
                 double expected, double tolerance, const Force& force) {
  const double trapezoid = 0.5 * dt * (begin + end);
  if (std::abs(trapezoid - expected) <= tolerance) return trapezoid;
  const auto at = [&](double ago) {
    return pressing_power(finder.find(earlier(m.pose, m.V, ago), ground), m.V, force);
  };
  const auto refine = [&](const auto& self, double ago, double width, double a, double b, double c, double whole,
                          double bound, int depth) -> double {
    const double left = at(ago + 0.75 * width), right = at(ago + 0.25 * width);
    const double first = width / 12 * (a + 4 * left + b), second = width / 12 * (b + 4 * right + c);
    const double error = first + second - whole;  // not a fifteenth of it: touching ground is a kink
    if (depth == 0 || std::abs(error) <= bound) return first + second;
    return self(self, ago + 0.5 * width, 0.5 * width, a, left, b, first, 0.5 * bound, depth - 1) +
           self(self, ago, 0.5 * width, b, right, c, second, 0.5 * bound, depth - 1);
  };
  const double middle = at(0.5 * dt);
  return refine(refine, 0, dt, begin, middle, end, dt / 6 * (begin + 4 * middle + end), tolerance, 5);
}

}  // namespace grouser
