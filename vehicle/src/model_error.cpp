#include "model_error.h"

#include <cmath>
#include <cstdio>

namespace grouser::vehicle {

namespace {
constexpr double k90 = 1.645;         ///< normal
constexpr double kWorthSaying = 0.1;  ///< touch-down and spinning up are outside in every run
}  // namespace

ModelError model_error(const Terrain& terrain) {
  ModelError e;
  for (const FieldInfo& f : terrain.fields()) {
    const auto take = [&](const char* name, double& to, double scale) {
      if (f.name == name) to = scale * terrain.field(f.name, 0, 0);
    };
    take("drawbar_sd", e.drawbar_pull, k90);
    take("torque_sd", e.driving_torque, k90);
    take("sinkage_sd", e.sinkage, k90);
    take("outside", e.outside, 1);
  }
  return e;
}

std::string outside_warning(const Terrain& terrain) {
  const double outside = model_error(terrain).outside;
  if (!(outside > kWorthSaying)) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "%s lay outside of what it was fitted to on %.0f %% of the way in contact: its error bars do not hold there",
                terrain.id().c_str(), 100 * outside);
  return text;
}

}  // namespace grouser::vehicle
