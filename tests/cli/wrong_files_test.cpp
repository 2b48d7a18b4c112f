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
                  "bekker.steady, bekker.soil_node; did you mean 'bekker.steady'?\n"},
        WrongFile{
            "soil_without_bekker.yaml",
            "soil_without_bekker.yaml:5:9: terrain.soil: ../../../examples/soils/concrete.yaml: soil 'Concrete' has "
            "no 'bekker:' section, which model bekker.steady needs\n"},
        WrongFile{
            "unknown_shape.yaml",
            "unknown_shape.yaml:7:10: ground.shape: 'sinusiod' is not one of: flat, slope, step, sinusoid, iso8608, "
            "height_map, profile; did you mean 'sinusoid'?\n"},
        WrongFile{"negative_step.yaml",
                  "negative_step.yaml:10:12: time_step: '-1 ms' is out of range; allowed is more than "
                  "0 ms and at most 20 ms\n"},
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
        WrongFile{"profile_nan.yaml", "nan.csv:3:6: row 2, column 2 ('z_mm'): 'nan' is not a finite number\n"},
        WrongFile{"syntax.yaml", "syntax.yaml:9:9: not valid YAML: end of map flow not found\n"},
        WrongFile{"negative_radius.yaml",
                  "negative_radius.yaml:4:9: radius: '-130 mm' is out of range; allowed is more "
                  "than 0 mm and at most 10000 mm\n"},
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
            "massless_vehicle.yaml:4:19: bodies.chassis.mass: '0 kg' is out of range; allowed is more than 0 kg\n"
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
        "many.yaml:11:12: time_step: '1 h' is out of range; allowed is more than 0 s and at most 0.02 s",
        "many.yaml:12:1: unknown key 'sede'; did you mean 'seed'?"})
    EXPECT_NE(r.err.find(part), std::string::npos) << part << "\nin\n" << r.err;
}

TEST(WrongUrdf, MalformedXmlIsNamedWithItsLine) {
  const CommandResult r = grouser_command("check urdf_scenario.yaml", source / "tests/cli/wrong");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err.find("broken.urdf:4:1: not well-formed XML"), 0u) << r.err;
  EXPECT_EQ(r.err.find("unknown key"), std::string::npos) << "the scenario is right:\n" << r.err;
}

}  // namespace
}  // namespace grouser::test
