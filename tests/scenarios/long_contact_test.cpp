// What a contact does in a minute at rest and in whole runs on the stiffest soils.
#include <cmath>

#include "support.h"

namespace grouser::vehicle {
namespace {

using namespace test;

struct Stand {
  const char *vehicle, *soil, *speed;
  double
      from;  ///< [s] the vehicle has rocked to rest on its springs: two seconds after braking, six for the off-road vehicle's
};

TEST(LongRun, VehiclesDrivenUpATenDegreeSlopeAndBrakedStayWithinAMillimetreForAMinute) {
  // Where the load bounces on an elastic soil it works its way downhill (3 to 17 mm in a minute without damping). Greatest way at any time.
  // The rover is left out on the snow, in which it sinks to its hubs.
  for (const Stand& c : {Stand{"skid_robot.yaml", "dry_sand.yaml", "0.5 m/s", 6},
                         {"skid_robot.yaml", "lunar_soil_nominal.yaml", "0.5 m/s", 6},
                         {"skid_robot.yaml", "mojave_martian_simulant.yaml", "0.5 m/s", 6},
                         {"skid_robot.yaml", "snow_sweden.yaml", "0.5 m/s", 6},
                         {"offroad.yaml", "dry_sand.yaml", "0.5 m/s", 10},
                         {"offroad.yaml", "lunar_soil_nominal.yaml", "0.5 m/s", 10},
                         {"offroad.yaml", "mojave_martian_simulant.yaml", "0.5 m/s", 10},
                         {"rover.yaml", "dry_sand.yaml", "0.12 m/s", 6},
                         {"rover.yaml", "lunar_soil_nominal.yaml", "0.12 m/s", 6},
                         {"rover.yaml", "mojave_martian_simulant.yaml", "0.12 m/s", 6}}) {
    const Folder f;
    run(braked(f.path(), c.vehicle, c.soil, c.speed, c.from + 60), f.path() / "out", "bekker.steady", 0);
    const RunFile r(f.path() / "out/run.h5");
    const auto first = static_cast<std::size_t>(std::lround(c.from * 20));  // frames at 20 Hz
    ASSERT_NEAR(r.time().at(first), c.from, 1e-9);
    EXPECT_LT(greatest_way(r.read("chassis.position"), first), 1e-3) << c.vehicle << " on " << c.soil;
  }
}

TEST(LongRun, TheEnergyLedgerClosesOnSoilsAndGroundsThatTheStepDoesNotResolve) {
  // Whole shipped runs on the stiffest soils, whose contacts are micrometres deep and open within a step; the bound is that of every run.
  const auto soil = [](const char* scenario, const char* name) {
    const std::string text = shipped(scenario);
    const std::size_t at = text.find("soils/") + 6;
    return text.substr(0, at) + name + text.substr(text.find(".yaml", at));
  };
  const Folder f;
  const auto ratio = [&](const std::string& text, const char* terrain) {
    return run(f.write("case.yaml", text), f.path() / "out", terrain, 0).energy_residual_ratio;
  };
  for (const char* clay : {"heavy_clay_25_wes", "lean_clay_22_wes", "clayey_soil_38_thailand"})
    for (const char* scenario : {"robot_sinusoid.yaml", "robot_belgian_block.yaml", "robot_iso_e.yaml"})
      EXPECT_LT(ratio(soil(scenario, clay), "bekker.steady"), 0.005) << scenario << " on " << clay;
  for (const auto& [amplitude, wavenumber] :
       {std::pair{"8 mm", "50 rad/m"}, {"5 mm", "80 rad/m"}, {"3 mm", "120 rad/m"}}) {
    std::string text = replaced(shipped("robot_sinusoid.yaml"), "9.75 mm", amplitude);
    text = replaced(text, "32.2 rad/m", wavenumber);
    for (const char* terrain : {"rigid", "bekker.steady"})
      EXPECT_LT(ratio(text, terrain), 0.005) << amplitude << " " << terrain;
  }
}

}  // namespace
}  // namespace grouser::vehicle
