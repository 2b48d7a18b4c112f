#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "grouser/terrain/ground.h"
#include "grouser/vehicle/vehicle_world.h"

namespace grouser::vehicle {

/// Notes which wheels leave the data that the ground is made of, and when first. Looks once per frame.
class ExtentWatch {
 public:
  /// @return true when a wheel left the data for the first time
  bool look(double t, const VehicleWorld& world, const Ground& ground);
  void traverse(State& s);
  /// One line per wheel that left: since when, how long, and what the ground is there.
  std::vector<std::string> warnings(const VehicleSpec& vehicle) const;

 private:
  struct Wheel {
    std::int64_t frames = 0;  ///< outside
    double since = 0;         ///< [s]
    std::string where;
  };
  std::int64_t frames_ = 0;
  std::vector<Wheel> wheels_;
};

}  // namespace grouser::vehicle
