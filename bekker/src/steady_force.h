#pragma once
#include "grouser/bekker/forces.h"

namespace grouser::bekker {

/// Wheel force of bekker.steady by quadrature or closed form; theta_m and theta_r of `slip`, stresses of the shear
/// state `e`.
WheelForces steady_force(const WheelSize& wheel, const SoilLaw& soil, double theta_f, ShearState e, double slip,
                         Method method, Quadrature quadrature, double pressure_factor);

}  // namespace grouser::bekker
