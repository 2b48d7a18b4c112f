// grouser soil calibrate as a user calls it.
#include <gtest/gtest.h>

#include <map>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

/// A shear and a sinkage test of a few grains, in a folder of their own; seeds as text.
void write_tests(const fs::path& folder, const std::string& seeds, const std::string& reference = "",
                 const std::string& size = "40 mm, height: 30 mm, displacement: 4 mm") {
  fs::create_directories(folder);
  const std::string soil =
      "soil: {diameter: [6 mm, 10 mm], density: 3.1 g/cm^3, bulk_density: 1.6 g/cm^3, young_modulus: 30 MPa,\n"
      "  poisson_ratio: 0.35, friction: 0.5, rolling: {law: constant, coefficient: 0.15}, restitution: 0.4,\n"
      "  wall: {friction: 0, restitution: 0.06}}\nsolver: {time_step: auto}\nseeds: [" +
      seeds + "]\npacking: {young_modulus: 30 MPa, friction: 0.5, rolling: {law: constant, coefficient: 0.1}}\n";
  std::ofstream(folder / "shear.yaml") << "soil_test: shear\n"
                                       << soil
                                       << "direct_shear: {side: " + size +
                                              ", pressures: [10 kPa], rates: [40 mm/s], rest: 50 ms, samples: 10}\n"
                                       << reference;
  std::ofstream(folder / "sinkage.yaml")
      << "soil_test: sinkage\n"
      << soil
      << "pressure_sinkage: {bin: [80 mm, 80 mm], depth: 40 mm, plate: [30 mm, 30 mm, 10 mm], brick: 40 mm, rates: [80 "
         "mm/s], "
         "sinkage: 6 mm, samples: 12}\n"
      << (reference.empty() ? "" : "reference: {source: Table 4.1, k: 2.541e5 Pa, n: 1.387, width: 50 mm}\n");
}

const std::string kShearReference =
    "reference: {source: Table 4.1, cohesion: 139.280 Pa, friction_angle: 0.606 rad, K: 0.5151 mm}\n";

void write_calibration(const fs::path& file, const std::string& parameters, const std::string& search,
                       const std::string& shear = "", const std::string& sinkage = "") {
  std::ofstream(file) << "calibration: a test\ndirect_shear: {file: shear.yaml" << shear
                      << "}\npressure_sinkage: {file: sinkage.yaml" << sinkage << "}\nparameters: {" << parameters
                      << "}\nsearch: {" << search << "}\n";
}

#ifdef GROUSER_CALIBRATE_SLOW

std::vector<std::map<std::string, double>> read_sets(const fs::path& csv) {
  std::istringstream lines(read_text(csv));
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(lines, line);
  for (std::istringstream s(line); std::getline(s, cell, ',');) names.push_back(cell);
  std::vector<std::map<std::string, double>> out;
  while (std::getline(lines, line)) {
    std::istringstream s(line);
    out.emplace_back();
    for (std::size_t k = 0; std::getline(s, cell, ','); ++k) out.back()[names.at(k)] = std::stod(cell);
  }
  return out;
}

// Curves of grains whose parameters are known, on six other packings, take the place of measured ones. The search sees the curves
// only and has to find these grains again.
TEST(SoilCalibrate, FindsBackTheParametersOfGrainsFromTheirCurves) {
  const fs::path truth = scratch() / "truth", found = scratch() / "found";
  const std::string large = "60 mm, height: 40 mm, displacement: 6 mm";
  write_tests(truth, "11, 12, 13, 14, 15, 16", "", large);
  for (const char* kind : {"direct-shear", "pressure-sinkage"}) {
    const std::string file = (truth / (kind[0] == 'd' ? "shear.yaml" : "sinkage.yaml")).string();
    const CommandResult r =
        grouser_command("soil " + std::string(kind) + " " + file + " --quiet --out " + (truth / kind).string(), source);
    ASSERT_EQ(r.code, 0) << r.err;
  }
  write_tests(found, "1, 2, 3, 4", "", large);
  struct Case {
    std::string name, bounds;
    double truth;
  };
  // One at a time, the other one known: together they make up for each other, see the README of the example.
  for (const Case& c : {Case{"friction", "[0.15, 1]", 0.5}, Case{"rolling_coefficient", "[0.02, 0.6]", 0.15}}) {
    write_calibration(found / (c.name + ".yaml"), c.name + ": " + c.bounds, "sets: 5, evaluations: 10, tolerance: 0.02",
                      ", target: [{pressure: 10 kPa, file: ../truth/direct-shear/mean.csv}]",
                      ", target: {file: ../truth/pressure-sinkage/mean.csv}");
    const CommandResult r =
        grouser_command("soil calibrate " + (found / (c.name + ".yaml")).string() + " --quiet --beds " +
                            (found / "beds").string() + " --out " + (found / c.name).string(),
                        source);
    ASSERT_EQ(r.code, 0) << r.err;
    const auto sets = read_sets(found / c.name / "sets.csv");
    EXPECT_LE(sets.size(), 10u);
    for (const auto& s : sets) {
      if (s.at("best") != 1) continue;
      // Bounds are 7 and 30 apart. Means of four packings of so few grains leave a factor of 1.6.
      EXPECT_GT(s.at(c.name), c.truth / 1.6);
      EXPECT_LT(s.at(c.name), c.truth * 1.6);
      EXPECT_LT(s.at("error"), 0.35);
    }
  }
}

#else

TEST(SoilCalibrate, AKilledSearchGoesOnWithTheSameBitsForAnyNumberOfThreads) {
  const fs::path folder = scratch() / "calibrate";
  write_tests(folder, "1", kShearReference);
  write_calibration(folder / "c.yaml", "friction: [0.2, 0.8]", "sets: 2, evaluations: 4");
  const std::string run =
      "soil calibrate " + (folder / "c.yaml").string() + " --quiet --beds " + (folder / "beds").string() + " --out ";
  const fs::path whole = folder / "whole", parts = folder / "parts";
  const CommandResult a = grouser_command(run + whole.string(), source);
  ASSERT_EQ(a.code, 0) << a.err;
  EXPECT_NE(a.out.find("best compromise of 4 sets: friction"), std::string::npos) << a.out;
  EXPECT_GT(fs::file_size(whole / "report.html"), 100000u);
  // As a kill leaves it: the first set is complete, nothing else is there.
  for (const char* kind : {"direct-shear", "pressure-sinkage"}) {
    fs::create_directories(parts / kind);
    fs::path first;
    for (const auto& e : fs::directory_iterator(whole / kind))
      if (e.path().extension() == ".yaml" && (first.empty() || e.path() < first)) first = e.path();
    fs::copy(first, parts / kind / first.filename());
    fs::copy(fs::path(first).replace_extension(".csv"), parts / kind / first.stem().concat(".csv"));
  }
  ASSERT_EQ(grouser_command(run + parts.string() + " --threads 2", source).code, 0);
  EXPECT_EQ(read_text(whole / "sets.csv"), read_text(parts / "sets.csv"));
  // All there: nothing is computed again.
  const auto before = fs::last_write_time(*fs::directory_iterator(whole / "direct-shear"));
  ASSERT_EQ(grouser_command(run + whole.string(), source).code, 0);
  EXPECT_EQ(before, fs::last_write_time(*fs::directory_iterator(whole / "direct-shear")));
}

TEST(SoilCalibrate, MistakesAreNamedWithTheirPlace) {
  const fs::path folder = scratch() / "wrong_calibration";
  write_tests(folder, "1");
  std::ofstream(folder / "short.csv") << "displacement_m,shear_Pa\n0,0\n0.001,5000\n";
  std::ofstream(folder / "falling.csv") << "sinkage_m,pressure_Pa\n0.002,10\n0.001,x\n";
  std::ofstream(folder / "c.yaml") << "calibration: wrong\n"
                                      "direct_shear: {file: shear.yaml, target: [{pressure: 5 kPa, file: short.csv}]}\n"
                                      "pressure_sinkage: {file: sinkage.yaml, target: {file: falling.csv}}\n"
                                      "parameters: {young_modulus: [9 MPa, 3 MPa], frction: [0.2, 0.8]}\n"
                                      "search: {sets: 9, evaluations: 4, method: newton}\n";
  const CommandResult r = grouser_command("soil calibrate c.yaml", folder);
  EXPECT_EQ(r.code, 2);
  for (const char* message :
       {"c.yaml:2:54: direct_shear.target[0].pressure: the test does not have this pressure; it has 10000 Pa",
        "the table short.csv has no column 'shear_total_Pa'", "a target for 10000 Pa is missing",
        "falling.csv:3:7: 'x' is not a number",
        "young_modulus: the lower bound comes first and must be less than the upper one",
        "unknown key 'frction' in parameters; did you mean 'friction'?", "'newton'",
        "search.evaluations: counts all sets, so it cannot be less than 'sets'"})
    EXPECT_NE(r.err.find(message), std::string::npos) << message << "\n" << r.err;
  // Neither target nor reference.
  write_calibration(folder / "d.yaml", "friction: [0.2, 0.8]", "sets: 2");
  const CommandResult d = grouser_command("soil calibrate d.yaml", folder);
  EXPECT_EQ(d.code, 2);
  EXPECT_NE(d.err.find("there is nothing to compare with: name a target here or a reference in the file of the test"),
            std::string::npos)
      << d.err;
}

TEST(SoilCalibrate, AnotherFileIsNamed) {
  const CommandResult r =
      grouser_command("soil calibrate '" + (source / "examples/06_soil_tests/shear_quick.yaml").string() + "'", source);
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("this is a soil test on grains, not a calibration of grains; use 'grouser soil"),
            std::string::npos)
      << r.err;
}

TEST(SoilTriaxial, QuickExampleEndsWithAStrengthAndAReport) {
  const fs::path out = scratch() / "triaxial";
  const CommandResult r =
      grouser_command("soil triaxial '" + (source / "examples/06_soil_tests/triaxial_quick.yaml").string() +
                          "' --quiet --out " + out.string(),
                      source);
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(read_text(out / "report.html").find("Angle of internal friction [deg]"), std::string::npos);
  EXPECT_NE(read_text(out / "20000_Pa-seed1.csv").find("mobilised_friction_deg"), std::string::npos);
}

TEST(SoilTriaxial, WrongValuesAreNamed) {
  std::string text = read_text(source / "examples/06_soil_tests/triaxial_quick.yaml");
  text.replace(text.find("strain: 20 %"), 12, "strain: 60 %");
  text.replace(text.find("time_step: 15 us"), 16, "time_step: autom");
  std::ofstream(scratch() / "t.yaml") << text;
  const CommandResult r = grouser_command("soil triaxial t.yaml", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("triaxial.strain"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("solver.time_step"), std::string::npos) << r.err;
}

#endif

}  // namespace
}  // namespace grouser::test
