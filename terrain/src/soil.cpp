#include "grouser/terrain/soil.h"

#include <cmath>

namespace grouser {

double PressureSinkage::modulus(double wheel_width) const {
  // The plate's short side is the usual reference of k_b; a stated 0 means the wheel's own width.
  const double b = reference_width > 0 ? reference_width : wheel_width;
  return law == Law::kc_kphi ? kc / b + kphi : k / std::pow(b, n);
}

}  // namespace grouser
