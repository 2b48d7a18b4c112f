#include "grouser/bekker/forces.h"

#include <cmath>

#include "arc.h"
#include "closed_form.h"
#include "nonlinear.h"

namespace grouser::bekker {

ForceResult forces(const ForceCase& c, Method method, double tolerance) noexcept {
  const ForceStatus status = status_of(c);
  if (status != ForceStatus::ok) return {{}, status};
  if (method != Method::nonlinear) return {closed_form(c, method), ForceStatus::ok};
  if (!(tolerance >= 1e-13 && tolerance <= 1e-2)) return {{}, ForceStatus::bad_argument};
  return nonlinear_forces(Arc(c), tolerance);
}

}  // namespace grouser::bekker
