// Each wrong file ends with exit code 2 and one line per error that names file, line, column and the remedy.
#include <gtest/gtest.h>
#include <unistd.h>

#include "command.h"

namespace grouser::test {
namespace {

struct WrongFile {
  std::string file;
  std::string message;  ///< all of stderr
};

class WrongFiles : public testing::TestWithParam<WrongFile> {};

TEST_P(WrongFiles, EndsWithCode2AndNamesThePlaceAndTheRemedy) {
  const CommandResult r = grouser_command("check " + GetParam().file, source / "tests/cli/wrong");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, GetParam().message);
  EXPECT_EQ(r.out, "");
}

INSTANTIATE_TEST_SUITE_P(
    Corpus, WrongFiles,
    testing::Values(
        WrongFile{"typo.yaml", "typo.yaml:9:1: unknown key 'duraton'; did you mean 'duration'?\n"},
        WrongFile{"wrong_unit.yaml",
                  "wrong_unit.yaml:9:11: duration: '2 kg' is a mass, but a time is wanted, for example '1 s'\n"},
        WrongFile{"no_unit.yaml",
                  "no_unit.yaml:9:11: duration: '2' has no unit; a time is wanted, for example '2 s'\n"},
        WrongFile{"missing_key.yaml",
                  "missing_key.yaml:1:1: missing key 'vehicle'; for example 'vehicle: folder/file'\n"},
        WrongFile{"duplicate_key.yaml",
                  "duplicate_key.yaml:11:1: duplicate key 'duration'; first given in line 9, remove "
                  "one of the two\n"},
        WrongFile{"unknown_model.yaml",
                  "unknown_model.yaml:4:10: terrain.model: 'bekker.stedy' is not one of: rigid, "
                  "bekker.steady, bekker.soil_node, dem.sphere, sdem.v1, sdem.v2; did you mean 'bekker.steady'?\n"},
        WrongFile{
            "soil_without_bekker.yaml",
            "soil_without_bekker.yaml:5:9: terrain.soil: ../../../examples/soils/concrete.yaml: soil 'Concrete' has "
            "no 'bekker:' section, which model bekker.steady needs\n"},
        WrongFile{
            "unknown_shape.yaml",
            "unknown_shape.yaml:7:10: ground.shape: 'sinusiod' is not one of: flat, slope, step, sinusoid, iso8608, "
            "height_map, profile; did you mean 'sinusoid'?\n"},
        WrongFile{"negative_step.yaml",
                  "negative_step.yaml:10:12: time_step: '-1 ms' is out of range; allowed is 0.001 ms to 20 ms\n"},
        WrongFile{"missing_soil.yaml",
                  "missing_soil.yaml:5:9: terrain.soil: file 'no_such_soil.yaml' not found; looked for "
                  "no_such_soil.yaml\n"},
        WrongFile{"unknown_effect.yaml",
                  "unknown_effect.yaml:6:29: unknown key 'vertical_dampin' in "
                  "terrain.effects.bekker.steady; did you mean 'vertical_damping'?\n"},
        WrongFile{"profile_gap.yaml",
                  "gap.csv:5:1: row 4: gap in the profile: the distance steps from 0.02 to 0.05 where "
                  "the step is 0.01; fill the missing rows or split the file\n"},
        WrongFile{"profile_ragged.yaml",
                  "ragged.csv:3:8: row 2 has 2 cells where the header has 3; separate cells by commas\n"},
        WrongFile{"profile_nan.yaml",
                  "nan.csv:3:6: row 2, column 2 ('z_mm'): 'nan' is not a finite number; fill it in from "
                  "its neighbours, or cut the table there: heights are finite numbers\n"},
        WrongFile{
            "syntax.yaml",
            "syntax.yaml:8:9: not valid YAML: the '{' that opens here is not closed, or a comma is missing between "
            "two of its entries\n"},
        WrongFile{"no_colon.yaml",
                  "no_colon.yaml:2:1: not valid YAML: the colon after the key is missing in 'vehicle "
                  "../../../examples/vehicles/skid_robot.yaml'; write 'vehicle: "
                  "../../../examples/vehicles/skid_robot.yaml'\n"},
        WrongFile{
            "no_colon_inside.yaml",
            "no_colon_inside.yaml:4:3: not valid YAML: the colon after the key is missing in 'model rigid'; write "
            "'model: rigid'\n"},
        WrongFile{
            "no_colon_in_braces.yaml",
            "no_colon_in_braces.yaml:7:28: not valid YAML: the colon after the key is missing in 'speed 0.5 m/s'; "
            "write 'speed: 0.5 m/s'\n"},
        WrongFile{"no_blank.yaml",
                  "no_blank.yaml:8:1: not valid YAML: a blank is missing after the colon in 'duration:2 s'; write "
                  "'duration: 2 s'\n"},
        WrongFile{
            "two_colons.yaml",
            "two_colons.yaml:1:16: not valid YAML: a second ': ' in this line; put the value in quotes: scenario: "
            "\"wrong: on purpose\"\n"},
        WrongFile{"open_quote.yaml", "open_quote.yaml:1:11: not valid YAML: the quote that opens here is not closed\n"},
        WrongFile{"indent.yaml",
                  "indent.yaml:5:5: not valid YAML: indented deeper than line 4, which has a value already; let both "
                  "begin in the same column\n"},
        WrongFile{"vehicle_folder.yaml",
                  "vehicle_folder.yaml:2:10: vehicle: '../../../examples/vehicles' is a folder; a file is wanted, for "
                  "example '../../../examples/vehicles/offroad.yaml'\n"},
        WrongFile{"half_step.yaml",
                  "half_step.yaml:8:11: duration: 'duration' must be a whole number of time steps; give a multiple of "
                  "time_step\n"},
        WrongFile{
            "text.yaml",
            "text.yaml:1:1: cannot tell what this file is; it should begin with one of the keys scenario, rig, fit, "
            "items, soil_test, dem, surrogate, training, bed, campaign, calibration, table, vehicle, wheel, terrain, soil, ground, shape\n"},
        WrongFile{"token.yaml", "token.yaml:1:11: not valid YAML: '`' cannot begin a value; put the value in quotes\n"},
        WrongFile{"profile_empty.yaml",
                  "empty.csv:1:1: the file has no rows of numbers; one row per line, cells separated by commas\n"},
        WrongFile{"negative_radius.yaml",
                  "negative_radius.yaml:4:9: radius: '-130 mm' is out of range; allowed is 0.1 mm to 10000 mm\n"},
        WrongFile{"missing_mesh.yaml",
                  "missing_mesh.yaml:4:7: file: file 'no_such_mesh.obj' not found; looked for no_such_mesh.obj\n"},
        WrongFile{"open_mesh.yaml", "open.obj:6:1: bad vertex index '9'; 4 vertices are known above this line\n"},
        WrongFile{
            "nan_soil.yaml",
            "nan_soil.yaml:4:27: bekker.pressure.k: '.nan' is not a finite number; for example '1 kPa'\n"
            "nan_soil.yaml:5:53: bekker.shear.friction_angle: '95 deg' is out of range; allowed is at least 0 deg and "
            "less than 90 deg\n"},
        WrongFile{
            "massless_vehicle.yaml",
            "massless_vehicle.yaml:1:1: missing key 'wheels'; for example 'wheels: {...}'\n"
            "massless_vehicle.yaml:4:3: missing key 'inertia' in bodies.chassis; for example 'inertia: {...}'\n"
            "massless_vehicle.yaml:4:19: bodies.chassis.mass: '0 kg' is out of range; allowed is more than 0 kg and at "
            "most 1e+06 kg\n"
            "massless_vehicle.yaml:4:54: unknown key 'box' in bodies.chassis; known here: inertia, mass, position, "
            "rotation, visual\n"},
        WrongFile{"absent.yaml", "absent.yaml: the file does not exist\n"}),
    [](const testing::TestParamInfo<WrongFile>& i) { return i.param.file.substr(0, i.param.file.find('.')); });

TEST(WrongFilesAtOnce, AllMistakesOfAFileAreNamedInOneGo) {
  const CommandResult r = grouser_command("check many.yaml", source / "tests/cli/wrong");
  EXPECT_EQ(r.code, 2);
  for (const char* part :
       {"many.yaml:8:3: unknown key 'clas' in ground; did you mean 'class'?",
        "many.yaml:9:35: driver.speed: '0.5' has no unit", "many.yaml:10:11: duration: '2 kg' is a mass",
        "many.yaml:11:12: time_step: '1 h' is out of range; allowed is 1e-06 s to 0.02 s",
        "many.yaml:12:1: unknown key 'sede'; did you mean 'seed'?"})
    EXPECT_NE(r.err.find(part), std::string::npos) << part << "\nin\n" << r.err;
}

TEST(WrongUrdf, MalformedXmlIsToldInWordsWithItsLine) {
  const CommandResult r = grouser_command("check urdf_scenario.yaml", source / "tests/cli/wrong");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(
      r.err,
      "broken.urdf:4:3: not well-formed XML: a tag is broken in '</link'; write <name ...> with </name> after its "
      "content, or <name .../>\n");
}

struct BrokenUrdf {
  const char *from, *to;  ///< what is changed in the shipped file, first occurrence
  const char* message;
};

TEST(WrongUrdf, EachKindOfBrokenTagHasItsRemedy) {
  const std::string shipped = read_text(source / "examples/vehicles/skid_robot.urdf");
  std::string scenario = read_text(source / "tests/cli/wrong/urdf_scenario.yaml");
  for (std::size_t at; (at = scenario.find("../../../examples")) != std::string::npos;)
    scenario.replace(at, 17, (source / "examples").string());
  std::ofstream(scratch() / "urdf.yaml") << scenario;
  for (const BrokenUrdf& b :
       {BrokenUrdf{"value=\"22\"", "value=22",
                   "12:7: not well-formed XML: an attribute of <mass> is broken; write name=\"value\""},
        BrokenUrdf{
            "value=\"22\"/>", "value=\"22\">",
            "12:7: not well-formed XML: <mass> is opened here and not closed, or closed by a tag of another name; "
            "write </mass>"},
        BrokenUrdf{"</robot>", "",
                   "3:1: not well-formed XML: the tag that opens in '<robot name=\"skid_robot\">' is not closed before "
                   "the file "
                   "ends; write </name> behind its content"},
        BrokenUrdf{"-->", "",
                   "2:1: not well-formed XML: the comment that opens here is not closed; it ends with -->"}}) {
    std::string text = shipped;
    text.replace(text.find(b.from), std::string(b.from).size(), b.to);
    std::ofstream(scratch() / "broken.urdf") << text;
    const CommandResult r = grouser_command("check urdf.yaml", scratch());
    EXPECT_EQ(r.code, 2) << b.message;
    EXPECT_EQ(r.err, std::string("broken.urdf:") + b.message + "\n");
  }
}

}  // namespace
}  // namespace grouser::test
