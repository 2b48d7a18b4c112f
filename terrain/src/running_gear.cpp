#include "grouser/terrain/running_gear.h"

namespace grouser {

double RunningGear::radius() const {
  return std::visit([](const auto& s) { return s.radius; }, shape);
}

double RunningGear::outer_radius() const {
  if (const auto* lugged = std::get_if<LuggedCylinder>(&shape)) return lugged->radius + lugged->lug_height;
  if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
    double r2 = 0;
    for (const Vec3& v : mesh->vertices) r2 = std::max(r2, v.x() * v.x() + v.z() * v.z());
    return std::sqrt(r2);
  }
  return radius();
}

double RunningGear::width() const {
  return std::visit([](const auto& s) { return s.width; }, shape);
}

}  // namespace grouser
