// Units against published conversion factors (SI brochure, NIST SP 811), typed in here and not computed by the parser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "config_support.h"

namespace grouser {
namespace {

using ::testing::ElementsAre;
using testing::messages;

double read(const std::string& value, const std::string& unit) {
  const ConfigDocument d = ConfigDocument::from_text("x: \"" + value + "\"\n", "f.yaml");
  const double x = d.root().quantity("x", unit);
  EXPECT_NO_THROW(d.check()) << value << " as " << unit;
  return x;
}

struct Case {
  const char* text;
  const char* wanted;
  double si;
};

class UnitTable : public ::testing::TestWithParam<Case> {};

TEST_P(UnitTable, GivesThePublishedValueInSI) {
  const Case& c = GetParam();
  // A few roundings of one double each: 1e-14 relative.
  EXPECT_NEAR(read(c.text, c.wanted), c.si, 1e-14 * std::abs(c.si));
}

INSTANTIATE_TEST_SUITE_P(
    All, UnitTable,
    ::testing::Values(Case{"1.04 kPa", "Pa", 1040}, Case{"1.04 kPa", "kPa", 1040}, Case{"1e5 N/m", "N/m", 1e5},
                      Case{"-30 %", "1", -0.3}, Case{"0.25", "1", 0.25}, Case{"1 ms", "s", 1e-3},
                      Case{"9.81 m/s^2", "m/s^2", 9.81}, Case{"3 N m s/rad", "N m s/rad", 3},
                      Case{"36 km/h", "m/s", 10}, Case{"60 rpm", "rad/s", 6.283185307179586},
                      Case{"17 deg/s", "rad/s", 0.29670597283903605}, Case{"1 Wh", "J", 3600},
                      Case{"2 kWh", "J", 7.2e6}, Case{"1.6 g/cm^3", "kg/m^3", 1600}, Case{"12 um", "m", 12e-6},
                      Case{"12 \xC2\xB5m", "m", 12e-6}, Case{"12 \xCE\xBCm", "m", 12e-6},
                      Case{"1 psi", "Pa", 6894.757293168361}, Case{"1 in", "m", 0.0254},
                      Case{"1 lbf", "N", 4.4482216152605}, Case{"1 mph", "m/s", 0.44704}, Case{"2 bar", "Pa", 2e5},
                      Case{"5 Nm", "N m", 5}, Case{"5 kN m", "N m", 5000}, Case{"2 N/(m s)", "N/(m s)", 2},
                      Case{"180 deg", "rad", 3.141592653589793}, Case{"180\xC2\xB0", "rad", 3.141592653589793},
                      Case{"16 cycles/m", "rad/m", 100.53096491487338}, Case{"2 m\xC2\xB2", "m^2", 2},
                      Case{"3 N\xC2\xB7m", "N m", 3}, Case{"+4 mm", "m", 4e-3},
                      Case{"\xE2\x88\x92"
                           "4 mm",
                           "m", -4e-3},
                      Case{"5 Ah", "A s", 18000}, Case{"24 V", "V", 24}, Case{"0.1 N m/A", "V s/rad", 0.1},
                      Case{"7mm", "m", 7e-3}, Case{"1e-3 m", "mm", 1e-3}, Case{"90 min", "s", 5400},
                      Case{"2 t", "kg", 2000}, Case{"3 m s^-1", "m/s", 3}, Case{"256e-6 m^3", "m^3", 256e-6}));

TEST(Units, ExponentOfSinkageEntersTheUnit) {
  // 0.9 kN/m^(n+1) with n = 1.1, once more as newton and millimetre: 900 N/m^2.1 = 900 * 1000^-2.1 N/mm^2.1.
  const ConfigDocument d =
      ConfigDocument::from_text("a: 0.9 kN/m^(n+1)\nb: 1523.4 kN/m^(n+2)\nc: 900 N/m^2.1\nd: 1 N/mm^(n+1)\n", "f.yaml");
  const ConfigNode r = d.root();
  EXPECT_DOUBLE_EQ(r.quantity_n("a", "N/m^(n+1)", 1.1), 900);
  EXPECT_DOUBLE_EQ(r.quantity_n("b", "kN/m^(n+2)", 1.1), 1523400);
  EXPECT_DOUBLE_EQ(r.quantity_n("c", "N/m^(n+1)", 1.1), 900);
  EXPECT_NEAR(r.quantity_n("d", "N/m^(n+1)", 1.1), 1995262.3149688789, 1e-6);
  d.check();
}

TEST(Units, WrongExponentOfSinkageIsNamed) {
  EXPECT_THAT(
      messages("kc: 0.9 kN/m^3\n", [](const ConfigNode& r) { r.quantity_n("kc", "kN/m^(n+1)", 0.9); }),
      ElementsAre(
          "f.yaml:1:5: kc: '0.9 kN/m^3' is a stiffness per area, but a value in kN/m^(n+1) with n = 0.9 is wanted, "
          "for example '1 kN/m^(n+1)'"));
}

TEST(Units, AngularSpeedIsNoFrequencyAndAngleNoRatio) {
  EXPECT_FALSE(parse_unit("rad/s").compatible(parse_unit("Hz")));
  EXPECT_FALSE(parse_unit("deg").compatible(parse_unit("1")));
  EXPECT_FALSE(parse_unit("cycles/m").compatible(parse_unit("1/m")));
  EXPECT_TRUE(parse_unit("N m/rad").compatible(parse_unit("N m")));
  EXPECT_TRUE(parse_unit("J").compatible(parse_unit("N m")));
}

TEST(Units, BadExpressionsSayWhatIsAllowed) {
  const auto why = [](const char* unit) -> std::string {
    try {
      parse_unit(unit);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(why("kpa"), "unknown unit 'kpa'; did you mean 'kPa'?");
  EXPECT_EQ(why("N/"), "a unit is missing at the end");
  EXPECT_EQ(why("N/(m s"), "a ')' is missing");
  EXPECT_EQ(why("m^"), "an exponent is missing after '^'");
  EXPECT_EQ(why("m^(n+1"), "a ')' is missing after the exponent");
  EXPECT_EQ(why("m)"), "unexpected ')' in the unit; write it like N, kN/m^2 or N m s/rad");
  EXPECT_EQ(why("m^99"), "an exponent beyond 20 is no unit");
  EXPECT_EQ(why("furlong"),
            "unknown unit 'furlong'; known are m g s N Pa J W Wh V A Ah ohm Hz bar with SI prefixes, deg rad rev "
            "cycle rpm % min h t in ft lb lbf psi mph");
}

}  // namespace
}  // namespace grouser
