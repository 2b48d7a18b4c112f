// A URDF file alone, and what is refused in it.
#include <gtest/gtest.h>

#include "command.h"

namespace grouser::test {
namespace {

const std::string shipped = read_text(source / "examples/vehicles/skid_robot.urdf");

CommandResult check_urdf(const std::string& text) {
  std::ofstream(scratch() / "u.urdf", std::ios::binary) << text;
  return grouser_command("check u.urdf", scratch());
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(UrdfAlone, IsCheckedAsFarAsItGoesAndSaysWhereTheRestIs) {
  const CommandResult r = check_urdf(shipped);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out,
            "u.urdf: URDF of 5 bodies and 4 joints (wheels and motors: check the scenario that names it), no errors\n");
}

struct WrongUrdfText {
  const char* name;
  std::string text, message;
};
class WrongUrdfs : public testing::TestWithParam<WrongUrdfText> {};

TEST_P(WrongUrdfs, EndWithCode2AndNameThePlaceAndTheRemedy) {
  const CommandResult r = check_urdf(GetParam().text);
  EXPECT_EQ(r.code, 2) << r.out;
  EXPECT_EQ(r.err, GetParam().message);
}

const std::string not_xml = "u.urdf:1:1: not well-formed XML: ";

INSTANTIATE_TEST_SUITE_P(
    Texts, WrongUrdfs,
    testing::Values(
        WrongUrdfText{
            "doctype", "<!-- a <!DOCTYPE -->\n<!DOCTYPE robot [<!ENTITY m \"5\">]>\n<robot name=\"a\"/>",
            "u.urdf:2:1: <!DOCTYPE ...> is not read: the entities and defaults in it would be lost; write them "
            "out and remove it\n"},
        WrongUrdfText{"no_xml", "robot: a\n",
                      not_xml + "the file begins with other text; a URDF file begins with <?xml ...?> or <robot "
                                "name=\"...\">\n"},
        WrongUrdfText{"empty", "", not_xml + "the file is empty; a URDF file begins with <robot name=\"...\">\n"},
        WrongUrdfText{"picture", "\x89PNG\r\n\x1a\n", "u.urdf:1:1: this is a PNG picture; a text file is wanted\n"},
        WrongUrdfText{"two_files", shipped + shipped,
                      "u.urdf:68:1: not well-formed XML: <?xml ...?> is allowed once, before everything else, and ends "
                      "with ?>; is a second file appended here?\n"},
        WrongUrdfText{"broken_tag", changed(shipped, "<joint name", "<joint<< name"),
                      "u.urdf:5:3: not well-formed XML: a tag is broken in '<joint<< name=\"base_joint\" "
                      "type=\"fixed\">'; write <name ...> with </name> after its content, or <name .../>\n"},
        WrongUrdfText{"no_robot", "<sdf name=\"a\"/>",
                      "u.urdf:1:1: a URDF file has the root element <robot name=\"...\">; here it is <sdf>\n"},
        WrongUrdfText{"no_body", "<robot name=\"a\"/>",
                      "u.urdf:1:1: the vehicle has no body; a vehicle file has them in 'bodies:', a URDF as <link>\n"},
        WrongUrdfText{
            "xacro", "<robot name=\"a\" xmlns:xacro=\"http://ros.org/wiki/xacro\"/>",
            "u.urdf:1:1: this is a xacro file; write the URDF with 'xacro FILE > robot.urdf' and give that\n"},
        WrongUrdfText{"two_joints", changed(shipped, "<joint name=\"front_left_axle\"", "<joint name=\"base_joint\""),
                      "u.urdf:25:3: joint 'base_joint' is defined twice, first in line 5; rename or remove one of the "
                      "two\n"},
        WrongUrdfText{
            "two_links",
            changed(shipped, "<link name=\"front_left\"", "<link name=\"chassis\"/><link name=\"front_left\""),
            "u.urdf:19:3: link 'chassis' is defined twice, first in line 10; rename or remove one of the two\n"},
        WrongUrdfText{"unit_in_a_number", changed(shipped, "value=\"22\"", "value=\"22 kg\""),
                      "u.urdf:12:7: attribute 'value' of <mass> must be a number alone, in SI units, of at most 1e12, "
                      "got '22 kg'\n"},
        WrongUrdfText{"huge_number", changed(shipped, "value=\"22\"", "value=\"1e300\""),
                      "u.urdf:12:7: attribute 'value' of <mass> must be a number alone, in SI units, of at most 1e12, "
                      "got '1e300'\n"},
        WrongUrdfText{
            "negative_mass", changed(shipped, "value=\"22\"", "value=\"-22\""),
            "u.urdf:12:7: the mass must not be negative [kg], got '-22'; give what the body weighs, 0 only for "
            "one that is fixed to another\n"}),
    [](const testing::TestParamInfo<WrongUrdfText>& i) { return i.param.name; });

}  // namespace
}  // namespace grouser::test
