// Files that are not what they claim to be, or hold what nobody means: refused with place and remedy, never passed on.
#include <gtest/gtest.h>

#include "command.h"

namespace grouser::test {
namespace {

const std::string examples = (source / "examples").string();

/// A file of the library with its paths made absolute and one line replaced (or taken out, when `by` is empty).
std::string changed(const std::string& file, const std::string& key, const std::string& by) {
  std::string out, line;
  std::istringstream in(read_text(source / "examples" / file));
  while (std::getline(in, line)) {
    if (line.starts_with(key + ":")) line = by;
    for (std::size_t at; (at = line.find("../")) != std::string::npos;) line.replace(at, 2, examples);
    if (const std::size_t at = line.find("file: data/"); at != std::string::npos)
      line.replace(at, 6, "file: " + examples + "/03_single_wheel_rig/");
    if (!line.empty()) out += line + "\n";
  }
  return out;
}

std::string scenario(const std::string& key, const std::string& by) {
  return changed("02_robot_rough_ground/robot_sinusoid.yaml", key, by);
}
std::string rig(const std::string& key, const std::string& by) {
  return changed("03_single_wheel_rig/mit_mms.yaml", key, by);
}

struct Hostile {
  const char* name;
  std::string command;  ///< before the file's name
  std::string file, content;
  std::string message;  ///< all of stderr
};

class HostileFiles : public testing::TestWithParam<Hostile> {};

TEST_P(HostileFiles, EndWithCode2AndNameThePlaceAndTheRemedy) {
  const Hostile& h = GetParam();
  std::ofstream(scratch() / h.file, std::ios::binary) << h.content;
  const CommandResult r = grouser_command(h.command + " " + h.file, scratch());
  EXPECT_EQ(r.code, 2) << r.out;
  EXPECT_EQ(r.err, h.message);
}

const std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x07\xff", 20), hdf5("\x89HDF\r\n\x1a\n\0\0\0\0", 12);
const std::string yaml_wanted = "a YAML file is wanted\n";

INSTANTIATE_TEST_SUITE_P(
    Kinds, HostileFiles,
    testing::Values(
        Hostile{"png_as_yaml", "check", "a.yaml", png, "a.yaml:1:1: this is a PNG picture; " + yaml_wanted},
        Hostile{"png_as_scenario", "run", "a.yaml", png, "a.yaml:1:1: this is a PNG picture; " + yaml_wanted},
        Hostile{"hdf5_as_yaml", "rig", "a.yaml", hdf5, "a.yaml:1:1: this is an HDF5 file; " + yaml_wanted},
        Hostile{"control_bytes", "check", "a.yaml", std::string("soil: x\nsource: \0\x01", 18),
                "a.yaml:2:9: byte \\x00 is no text; a YAML file is wanted, which is text in UTF-8\n"},
        Hostile{"latin_1", "check", "a.yaml", "soil: L\xF6\xDF\n",
                "a.yaml:1:8: byte \\xf6 is no UTF-8; save the file as UTF-8, or is it not a YAML file?\n"},
        Hostile{"utf_16", "check", "a.yaml", std::string("\xFF\xFEs\0o\0", 6),
                "a.yaml:1:1: this text is in UTF-16; save it as UTF-8\n"},
        Hostile{"undefined_alias", "check", "a.yaml", "soil: *foo\n",
                "a.yaml:1:7: not valid YAML: the referenced anchor is not defined; a value that begins with * repeats "
                "one marked &name further up: mark it, or put the value in quotes\n"},
        Hostile{
            "escape", "check", "a.yaml", "soil: \"a\\qb\"\n",
            "a.yaml:1:9: not valid YAML: unknown escape character: q; in \"...\" a \\ begins an escape such as \\n or "
            "\\u00e9: write \\\\ for the \\ itself, or use '...'\n"},
        Hostile{"tabs", "check", "a.yaml", "soil: x\nbekker:\n\tpressure: 1\n",
                "a.yaml:3:1: not valid YAML: illegal map value; this line is indented with a tab: use spaces\n"},
        Hostile{"empty", "run", "a.yaml", "", "a.yaml:1:1: the file is empty; 'key: value' lines are wanted\n"},
        Hostile{"terminal_escape", "check", "a.yaml", "soil: red\nsource: \"\\e[31mred\"\n\"\\e[31mkey\": 1\n",
                "a.yaml:1:1: the soil has no model parameters; give a section 'bekker:', 'rigid:' or 'dem:'\n"
                "a.yaml:3:1: unknown key '\\x1b[31mkey'; known here: bekker, bulk_density, dem, rigid, soil, source\n"},
        Hostile{"obj_alone", "check", "a.obj", "v 0 0 0\n",
                "a.obj: a mesh alone says nothing of its use; check the wheel file that names it\n"}),
    [](const testing::TestParamInfo<Hostile>& i) { return i.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Numbers, HostileFiles,
    testing::Values(
        Hostile{"duration", "run", "s.yaml", scenario("duration", "duration: 1e30 s"),
                "s.yaml:6:11: duration: '1e30 s' is out of range; allowed is more than 0 s and at most 1e+06 s\n"},
        Hostile{"gravity", "run", "s.yaml", scenario("duration", "duration: 1 s\ngravity: 1e30 m/s^2"),
                "s.yaml:7:10: gravity: '1e30 m/s^2' is out of range; allowed is more than 0 m/s^2 and at most 1000 "
                "m/s^2\n"},
        Hostile{"time_step", "run", "s.yaml", scenario("time_step", "time_step: 1e-30 s"),
                "s.yaml:4:12: time_step: '1e-30 s' is out of range; allowed is 1e-06 s to 0.02 s\n"},
        Hostile{"load", "rig", "r.yaml", rig("load", "load: 1e30 N"),
                "r.yaml:8:7: load: '1e30 N' is out of range; allowed is more than 0 N and at most 1e+07 N\n"},
        Hostile{"rig_gravity", "rig", "r.yaml", rig("settle", "gravity: 1e30 m/s^2"),
                "r.yaml:14:10: gravity: '1e30 m/s^2' is out of range; allowed is more than 0 m/s^2 and at most 1000 "
                "m/s^2\n"}),
    [](const testing::TestParamInfo<Hostile>& i) { return i.param.name; });

INSTANTIATE_TEST_SUITE_P(
    OneMistakeOneLine, HostileFiles,
    testing::Values(Hostile{"missing_wheel", "rig", "r.yaml", rig("wheel", "wheel: no_wheel.yaml"),
                            "r.yaml:3:8: wheel: file 'no_wheel.yaml' not found; looked for no_wheel.yaml\n"},
                    Hostile{"soil_folder", "rig", "r.yaml", rig("  soil", "  soil: " + examples + "/soils"),
                            "r.yaml:6:9: terrain.soil: '" + examples +
                                "/soils' is a folder; a file is wanted, for example '" + examples +
                                "/soils/clayey_soil.yaml'\n"},
                    Hostile{"no_slips", "rig", "r.yaml", rig("slips", ""),
                            "r.yaml:1:1: missing key 'slips'; for example 'slips: [0.5]'\n"},
                    Hostile{"no_title", "check", "r.yaml", rig("rig", ""),
                            "r.yaml:1:1: missing key 'rig'; for example 'rig: text'\n"}),
    [](const testing::TestParamInfo<Hostile>& i) { return i.param.name; });

TEST(OneMistakeOneLine, AMissingWheelFileOfAVehicleIsNamedOnlyWhereItIsNamed) {
  std::string vehicle = read_text(source / "examples/vehicles/skid_robot.yaml");
  for (std::size_t at; (at = vehicle.find("../wheels/robot_wheel.yaml")) != std::string::npos;)
    vehicle.replace(at, 26, "no_wheel.yaml");
  std::ofstream(scratch() / "v.yaml") << vehicle;
  const CommandResult r = grouser_command("check v.yaml", scratch());
  EXPECT_EQ(r.code, 2);
  std::istringstream lines(r.err);
  int wheels = 0;
  for (std::string line; std::getline(lines, line); ++wheels)
    EXPECT_NE(line.find(".wheel: file 'no_wheel.yaml' not found; looked for no_wheel.yaml"), std::string::npos) << line;
  EXPECT_EQ(wheels, 4);
}

TEST(Slips, SoNearToOneThatTheDistanceTakesWeeksAreRefused) {
  std::ofstream(scratch() / "slips.yaml") << rig("slips", "slips: [0.99999]");
  const CommandResult r = grouser_command("rig slips.yaml", scratch());
  EXPECT_EQ(r.code, 2);
  // 0.7 m at 17 deg/s x 0.13 m x 1e-5
  EXPECT_NE(r.err.find("slips.yaml:11:1: slips: 0.99999 means a travel of 1.8148e+06 s over the rig file's 'distance'"),
            std::string::npos)
      << r.err;
}

TEST(Remedies, TheExampleOfSlipsIsValidWhenFollowed) {
  std::ofstream(scratch() / "slips.yaml") << rig("slips", "slips: [0.5]");
  const CommandResult r = grouser_command("check slips.yaml", scratch());
  EXPECT_EQ(r.code, 0) << r.err;
}

}  // namespace
}  // namespace grouser::test
