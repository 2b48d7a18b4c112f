#pragma once
// What a run says of lugs that are not taken one by one.
#include <cstdio>

#include "grouser/terrain/terrain.h"

namespace grouser::bekker {

inline SimplifiedGear lugs_as_mean(const LuggedCylinder& gear, std::string why) {
  char as[120];
  std::snprintf(as, sizeof as, "lugs as the mean pressure of tips (share %.3g) and tread, eqs 2.14 and 2.15",
                gear.lug_ratio);
  return {as, std::move(why)};
}

}  // namespace grouser::bekker
