#pragma once
// One case of the single-wheel rig from a few words: the studies below differ in these only.
#include <filesystem>
#include <string>

#include "grouser/vehicle/rig.h"

namespace family {

/// Everything as in a rig file (examples/03_single_wheel_rig/README.md), quantities as text with their unit.
struct RigInput {
  std::string wheel = "mit_wheel", soil = "mojave_martian_simulant";  ///< of examples/wheels, examples/soils
  std::string model = "bekker.steady", options, effects;              ///< "closure: wong, spacing: 3.3 mm"
  std::string ground;                                                 ///< "{shape: ...}"; empty = flat
  std::string load = "load: 115 N";                                   ///< or "mass: 8.155 kg"
  std::string speed = "angular_speed: 17 deg/s";                      ///< or "travel_speed: 0.1 m/s"
  double slip = 0;                                                    ///< (r w - v)/(r w)
  std::string slip_radius;                                            ///< empty = without lugs
  std::string time_step = "1 ms", settle = "0.5 s", ramp = "1 s";
  double distance = 0.7;      ///< [m] of the constant part
  double average_over = 0.2;  ///< [-] last share of it
  std::string rate = "50 Hz";
};

/// Hash of the rig file, the wheel and the soil.
std::string hash_of(const RigInput& input);

struct RigResult {
  grouser::vehicle::RigRow row;
  std::filesystem::path run_file;  ///< series of the case, until the next case
};
/// Runs the case in folder `work` (emptied before). @throws what run_rig throws
RigResult run(const RigInput& input, const std::filesystem::path& work);

/// `PROGRAM RESULTS WORK [--again]`, started in the root of the repository.
struct Arguments {
  std::filesystem::path results, work;
  bool again = false;
};
/// Calls `study`; prints what went wrong. @returns the exit code
int main_of(int argc, char** argv, void (*study)(const Arguments&));

}  // namespace family
