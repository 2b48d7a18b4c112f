#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grouser/vehicle/rig_slip.h"

using namespace grouser::vehicle;

namespace {

constexpr double r = 0.13, w = 17 * 3.14159265358979323846 / 180;

// Table 4.5's braking slips and their values by the other definition, as printed to three digits in the list of errata.
TEST(Slip, BrakingSlipsOfTable45ByBothDefinitions) {
  const double table[][2] = {{-0.7, -0.412}, {-0.5, -0.333}, {-0.3, -0.231}, {-0.1, -0.091}};
  for (const auto& [rim, symmetric] : table) {
    EXPECT_NEAR(convert_slip(rim, SlipDefinition::rim, SlipDefinition::symmetric), symmetric, 5e-4);
    EXPECT_NEAR(convert_slip(symmetric, SlipDefinition::symmetric, SlipDefinition::rim), rim, 2e-3);
  }
}

TEST(Slip, DrivingSlipsAreTheSameByBothDefinitions) {
  for (const double s : {0.0, 0.1, 0.7, 1.0}) {
    EXPECT_EQ(convert_slip(s, SlipDefinition::rim, SlipDefinition::symmetric), s);
    EXPECT_EQ(convert_slip(s, SlipDefinition::symmetric, SlipDefinition::rim), s);
  }
}

// Tables 5.1 and 5.5: radius 65 mm at 17 deg/s travels 0.69 m at all nine slips in the printed times, by eq 3.8 only.
TEST(Slip, TravelOfTable55IsTheSameAtAllSlipsByTheRimDefinition) {
  const double times[][2] = {{-0.7, 20.9}, {-0.5, 23.7}, {-0.3, 27.4}, {-0.1, 32.5}, {0.0, 35.8},
                             {0.1, 40.0},  {0.3, 51.4},  {0.5, 72.1},  {0.7, 120.5}};
  for (const auto& [slip, time] : times)
    EXPECT_NEAR(travel_speed_for(SlipDefinition::rim, 0.065, slip, w) * time, 0.69, 0.01) << slip;
}

TEST(Slip, SpeedsGiveBackTheSlipThatWasAskedFor) {
  for (const auto d : {SlipDefinition::rim, SlipDefinition::symmetric})
    for (const double s : {-0.9, -0.4, -0.1, 0.0, 0.3, 0.95}) {
      EXPECT_NEAR(slip_of(d, r, w, travel_speed_for(d, r, s, w)), s, 1e-14);
      EXPECT_NEAR(slip_of(d, r, angular_speed_for(d, r, s, 0.04), 0.04), s, 1e-14);
    }
}

TEST(Slip, LockedAndSpinningWheels) {
  EXPECT_EQ(slip_of(SlipDefinition::symmetric, r, 0, 0.1), -1);
  EXPECT_EQ(slip_of(SlipDefinition::symmetric, r, w, 0), 1);
  EXPECT_EQ(slip_of(SlipDefinition::rim, r, w, 0), 1);
  EXPECT_EQ(slip_of(SlipDefinition::rim, r, 0, 0.1), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(slip_of(SlipDefinition::symmetric, r, 0, 0), 0);
}

TEST(Slip, ImpossibleSlipsAreRefused) {
  EXPECT_THROW(travel_speed_for(SlipDefinition::rim, r, 1.1, w), std::invalid_argument);
  EXPECT_THROW(travel_speed_for(SlipDefinition::symmetric, r, -1, w), std::invalid_argument);
  EXPECT_THROW(angular_speed_for(SlipDefinition::symmetric, r, 1, 0.1), std::invalid_argument);
  EXPECT_THROW(angular_speed_for(SlipDefinition::symmetric, r, -1.2, 0.1), std::invalid_argument);
}

}  // namespace
