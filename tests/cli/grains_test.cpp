// Soil tests, runs and beds of grains as a user calls them: results, messages, and what is left after a kill.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <regex>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

const fs::path quick = source / "examples" / "06_soil_tests";

/// Starts the command, kills it (SIGKILL) as soon as `file` is there, and says whether it was killed before its end.
bool killed_after(const std::string& arguments, const fs::path& file) {
  const std::string line =
      "'" GROUSER_COMMAND "' " + arguments + " >/dev/null 2>&1 & p=$!; n=0; until [ -e '" + file.string() +
      "' ] || [ $n -gt 2000 ]; do sleep 0.02; n=$((n+1)); done; kill -KILL $p; wait $p; " + "[ $? -eq 137 ]";
  const int status =
      std::system(("bash -c \"" + std::regex_replace(line, std::regex("([\"$])"), "\\$1") + "\"").c_str());
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// A copy of a file with one text in it replaced.
fs::path changed(const fs::path& file, const std::string& from, const std::string& to, const std::string& name) {
  std::string text = read_text(file);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const fs::path out = scratch() / name;
  std::ofstream(out) << text;
  return out;
}

void expect_message(const std::string& arguments, int code, const std::string& message) {
  const CommandResult r = grouser_command(arguments, scratch());
  EXPECT_EQ(r.code, code) << r.err;
  EXPECT_NE(r.err.find(message), std::string::npos) << r.err;
}

TEST(SoilCommand, AKilledTestContinuesWithTheSameBits) {
  const std::string test = "soil direct-shear '" + (quick / "shear_quick.yaml").string() + "' --quiet --beds " +
                           (scratch() / "beds").string() + " --checkpoint-every 0 --out ";
  const fs::path whole = scratch() / "whole", parts = scratch() / "parts";
  ASSERT_EQ(grouser_command(test + whole.string(), source).code, 0);
  const std::string name = "5000_Pa_20_mm_s-seed1";
  ASSERT_TRUE(killed_after(test + parts.string(), parts / (name + ".checkpoint.h5")));
  EXPECT_FALSE(fs::exists(parts / (name + ".yaml")));
  ASSERT_EQ(grouser_command(test + parts.string(), source).code, 0);
  for (const char* seed : {"1", "2"}) {
    const std::string file = "5000_Pa_20_mm_s-seed" + std::string(seed) + ".csv";
    EXPECT_EQ(read_text(whole / file), read_text(parts / file));
  }
  EXPECT_FALSE(fs::exists(parts / (name + ".checkpoint.h5")));
  EXPECT_GT(fs::file_size(parts / "report.html"), 100000u);
  // Finished cases are not computed again; two at a time give the same.
  const CommandResult again = grouser_command(
      "soil direct-shear '" + (quick / "shear_quick.yaml").string() + "' --out " + parts.string(), source);
  EXPECT_NE(again.err.find("2 of 2 cases are finished already"), std::string::npos) << again.err;
  const fs::path pair = scratch() / "pair";
  ASSERT_EQ(grouser_command(test + pair.string() + " --threads 2", source).code, 0);
  EXPECT_EQ(read_text(whole / "mean.csv"), read_text(pair / "mean.csv"));
}

TEST(BedCommand, AKilledPourContinuesWithTheSameBits) {
  const std::string bed =
      "dem bed '" + (quick / "bed_sinusoid.yaml").string() + "' --quiet --checkpoint-every 0 --out ";
  const fs::path whole = scratch() / "whole_bed.h5", parts = scratch() / "parts_bed.h5";
  const CommandResult one = grouser_command(bed + whole.string(), source);
  ASSERT_EQ(one.code, 0) << one.err;
  ASSERT_TRUE(killed_after(bed + parts.string(), scratch() / "parts_bed.checkpoint.h5"));
  EXPECT_FALSE(fs::exists(parts));
  const CommandResult two = grouser_command(bed + parts.string(), source);
  ASSERT_EQ(two.code, 0) << two.err;
  EXPECT_FALSE(fs::exists(scratch() / "parts_bed.checkpoint.h5"));
  // The same grains in the same places: one bed answers for the other's run, which names the hash of its last state.
  const auto state_of = [](const fs::path& file) {
    const std::string text =
        "dem: bed at rest\ndomain: {lower: [0 mm, 0 mm, -10 mm], upper: [120 mm, 40 mm, 200 mm], periodic: [x, y]}\n"
        "grains: {bed: '" +
        file.string() +
        "'}\nlaw: {rolling: constant}\n"
        "materials: [{name: a, young_modulus: 70 MPa, poisson_ratio: 0.3}]\n"
        "pairs: [{of: [a, a], friction: 0.5, restitution: 0.5, rolling_coefficient: 0.1}]\n"
        "time_step: 5 us\nduration: 1 ms\n"
        "bodies: [{name: floor, material: a, surfaces: [{plane: {point: [0 mm, 0 mm, 0 mm], normal: [0, 0, 1]}}]}]\n";
    std::ofstream(scratch() / "rest.yaml") << text;
    const CommandResult r = grouser_command("dem run rest.yaml --quiet --overwrite --out rest", scratch());
    EXPECT_EQ(r.code, 0) << r.err;
    const auto at = r.out.find("state ");
    return at == std::string::npos ? "" : r.out.substr(at, 22);
  };
  EXPECT_EQ(state_of(whole), state_of(parts));
}

TEST(RunCommand, StepsByThemselvesFollowTheRayleighTime) {
  // The number of steps says what the step was.
  const fs::path data = quick / "data" / "eight_grains.csv";
  changed(quick / "collision.yaml", "data/eight_grains.csv", data.string(), "whole_path.yaml");
  double least = 1e30;
  std::ifstream csv(data);
  std::string line;
  while (std::getline(csv, line) && line.rfind("x,y,z,radius,density", 0) != 0) {
  }
  while (std::getline(csv, line)) {
    double x[5];
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", x, x + 1, x + 2, x + 3, x + 4), 5);
    // Johnson 1985: speed of Rayleigh waves (0.1631 nu + 0.8766) sqrt(G/rho), half way round the sphere.
    const double shear = 70e6 / (2 * (1 + 0.25));
    least = std::min(least, 3.14159265358979 * x[3] / ((0.1631 * 0.25 + 0.8766) * std::sqrt(shear / x[4])));
  }
  const auto steps = [](const std::string& file) {
    const CommandResult r = grouser_command("dem run " + file + " --quiet --overwrite --out steps", scratch());
    EXPECT_EQ(r.code, 0) << r.err;
    const auto at = r.out.find("grains, ");
    return at == std::string::npos ? 0.0 : std::atof(r.out.c_str() + at + 8);
  };
  changed(scratch() / "whole_path.yaml", "time_step: 5 us", "time_step: auto", "auto.yaml");
  EXPECT_NEAR(steps("auto.yaml"), 0.3 / (0.17 * least), 1);
  changed(scratch() / "whole_path.yaml", "time_step: 5 us", "time_step: auto\nstep_share: 0.1", "share.yaml");
  EXPECT_NEAR(steps("share.yaml"), 0.3 / (0.1 * least), 1);
  // Eight grains, mostly flying: as long as allowed, 0.4, after a beginning at 0.17 and short ones while they collide.
  changed(scratch() / "whole_path.yaml", "time_step: 5 us", "time_step: adaptive", "adaptive.yaml");
  const double adaptive = steps("adaptive.yaml");
  EXPECT_GT(adaptive, 0.3 / (0.4 * least));
  EXPECT_LT(adaptive, 0.3 / (0.17 * least));
  changed(scratch() / "whole_path.yaml", "time_step: 5 us", "time_step: adaptiv", "wrong_step.yaml");
  EXPECT_EQ(grouser_command("dem run wrong_step.yaml --out wrong_step", scratch()).code, 2);
}

TEST(SoilCommand, ResultsOfOtherInputsAreNotMixedIn) {
  const fs::path out = scratch() / "mixed";
  const fs::path one = changed(quick / "sinkage_quick.yaml", "seeds: [1, 2]", "seeds: [1]", "one.yaml");
  ASSERT_EQ(grouser_command("soil pressure-sinkage one.yaml --quiet --out mixed", scratch()).code, 0);
  changed(one, "friction: 0.86", "friction: 0.5", "other.yaml");
  expect_message("soil pressure-sinkage other.yaml --quiet --out mixed", 2,
                 "holds the results of other inputs; use --overwrite, or another folder with --out");
}

TEST(SoilCommand, EveryMistakeIsNamedWithItsPlace) {
  const fs::path wrong =
      changed(changed(changed(quick / "shear_quick.yaml", "friction: 0.86", "fricton: 0.86", "w1.yaml"), "side: 40 mm",
                      "side: 15 mm", "w2.yaml"),
              "restitution: 0.4", "restitution: 1.4", "wrong_shear.yaml");
  const CommandResult r = grouser_command("soil direct-shear wrong_shear.yaml", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("did you mean 'friction'"), std::string::npos) << r.err;
  EXPECT_NE(
      r.err.find("wrong_shear.yaml:15:9: direct_shear.side: the box must be wider than two of the largest grains"),
      std::string::npos)
      << r.err;
  EXPECT_NE(r.err.find("restitution"), std::string::npos) << r.err;
}

TEST(SoilCommand, ARollingCoefficientHasTheUnitOfItsLaw) {
  changed(quick / "shear_quick.yaml", "law: constant, coefficient: 0.3", "law: rate, coefficient: 0.3", "rate.yaml");
  expect_message("soil direct-shear rate.yaml", 2, "rate.yaml:9:");
}

TEST(SoilCommand, AFileOfAnotherKindIsNamed) {
  expect_message("soil direct-shear '" + (source / "examples/03_single_wheel_rig/mit_mms.yaml").string() + "'", 2,
                 "this is a rig file, not a soil test on grains; use 'grouser rig");
}

TEST(SoilCommand, AnotherSoilTestIsNamed) {
  expect_message("soil oedometer '" + (quick / "shear_quick.yaml").string() + "'", 2,
                 "this is a test for 'grouser soil direct-shear', not 'oedometer'");
}

TEST(SoilCommand, EveryFileOfTheExamplePassesTheCheck) {
  for (const auto& entry : fs::directory_iterator(quick)) {
    if (entry.path().extension() != ".yaml") continue;
    const CommandResult r = grouser_command("check '" + entry.path().string() + "'", scratch());
    EXPECT_EQ(r.code, 0) << r.err;
  }
}

TEST(DemRun, AKilledRunContinuesWithTheSameBits) {
  changed(quick / "collision.yaml", "data/eight_grains.csv", (quick / "data/eight_grains.csv").string(), "c1.yaml");
  changed(scratch() / "c1.yaml", "time_step: 5 us", "time_step: 0.2 us", "long.yaml");
  const std::string run = "dem run " + (scratch() / "long.yaml").string() + " --quiet --checkpoint-every 0 --out ";
  const fs::path whole = scratch() / "dem_whole", parts = scratch() / "dem_parts";
  const CommandResult a = grouser_command(run + whole.string(), scratch());
  ASSERT_EQ(a.code, 0) << a.err;
  ASSERT_TRUE(killed_after(run + parts.string(), parts / "checkpoint.h5"));
  ASSERT_EQ(grouser_command(run + parts.string(), scratch()).code, 0);
  for (const char* file : {"grains.csv", "forces.csv", "energy.csv", "contacts.csv"})
    EXPECT_EQ(read_text(whole / file), read_text(parts / file)) << file;
}

TEST(DemRun, FinalStateIsAnInputAgainAndThePlateCarriesTheWeight) {
  const fs::path out = scratch() / "collision";
  const CommandResult r =
      grouser_command("dem run '" + (quick / "collision.yaml").string() + "' --quiet --out " + out.string(), source);
  ASSERT_EQ(r.code, 0) << r.err;
  // Last row of forces: 4 grains of 5 mm and 4 of 4 mm radius, 2500 kg/m3, weigh 77.7 mN; they roll, no longer bounce.
  std::istringstream rows(read_text(out / "forces.csv"));
  std::string line, last;
  while (std::getline(rows, line)) last = line;
  std::vector<double> v;
  std::istringstream cells(last);
  while (std::getline(cells, line, ',')) v.push_back(std::stod(line));
  EXPECT_NEAR(v[3], -0.0777, 2e-4);
  EXPECT_NEAR(v[7], 0.005, 1e-9);  // 0.1 s at 50 mm/s
  changed(quick / "collision.yaml", "data/eight_grains.csv", (out / "grains.csv").string(), "again.yaml");
  EXPECT_EQ(grouser_command("dem run again.yaml --quiet --out again", scratch()).code, 0);
}

TEST(DemRun, WrongGrainsAreNamedByLine) {
  const std::string head = "x,y,z,radius,density,vx,material\n";
  std::ofstream(scratch() / "g.csv") << head << "0,0,0.01,-0.005,2500,0,glass\n0,0,0.03,0.005,2500,nan,glas\n";
  changed(quick / "collision.yaml", "data/eight_grains.csv", "g.csv", "g.yaml");
  const CommandResult r = grouser_command("dem run g.yaml", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("g.csv:2:10: radius -0.005 must be positive"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("g.csv:3:21: vx: 'nan' is not a number"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("there is no material 'glas'; did you mean 'glass'?"), std::string::npos) << r.err;
}

TEST(DemRun, OverlappingGrainsAreNamed) {
  std::ofstream(scratch() / "o.csv") << "x,y,z,radius,density\n0,0,0.01,0.005,2500\n0.004,0,0.01,0.005,2500\n";
  changed(quick / "collision.yaml", "data/eight_grains.csv", "o.csv", "o.yaml");
  expect_message("dem run o.yaml --out o", 2, "grains 0 and 1 overlap");
  expect_message("dem run o.yaml --out o", 2, "o.csv:3:1: ");
  expect_message("dem run o.yaml --out o", 2, "o.csv:2, grain 1 is ");
}

TEST(DemRun, GrainsOfSeveralFilesAreNamedByFileAndLine) {
  // Notes and blank lines count as lines; grains are numbered through: 0 and 1 in the first file, 2 and 3 in the second.
  std::ofstream(scratch() / "one.csv")
      << "# note\nx,y,z,radius,density\n\n0,0,0.01,0.005,2500\n0.03,0,0.01,0.005,2500\n";
  std::ofstream(scratch() / "two.csv")
      << "x,y,z,radius,density\n0,0.03,0.01,0.005,2500\n# note\n0.034,0,0.01,0.005,2500\n";
  changed(quick / "collision.yaml", "grains: {file: data/eight_grains.csv}",
          "grains: [{file: one.csv}, {file: two.csv}]", "several.yaml");
  const CommandResult r = grouser_command("dem run several.yaml --out several", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("two.csv:4:1: grains 1 and 3 overlap by 0.006 m"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("one.csv:5, grain 3 is "), std::string::npos) << r.err;
  // Each wrong cell of each file at its place.
  std::ofstream(scratch() / "two.csv") << "x,y,z,radius,density\n0,nan,0.01,0.005,2500\n0,0,0.05,0,2500\n";
  const CommandResult wrong = grouser_command("dem run several.yaml --out several", scratch());
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("two.csv:2:3: y: 'nan' is not a number"), std::string::npos) << wrong.err;
  EXPECT_NE(wrong.err.find("two.csv:3:10: radius 0 must be positive"), std::string::npos) << wrong.err;
  // Apart they run, and all four are there at the end.
  std::ofstream(scratch() / "two.csv") << "x,y,z,radius,density\n0,0.03,0.01,0.005,2500\n0.03,0.03,0.01,0.005,2500\n";
  const CommandResult good = grouser_command("dem run several.yaml --quiet --out several", scratch());
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_EQ(good.out.find("4 grains, "), 0u) << good.out;
}

TEST(DemRun, AGrainInsideABodyIsNamedByLineAndBody) {
  // The plate's top is at z = 0: the second grain's centre lies 1 mm below.
  std::ofstream(scratch() / "b.csv") << "x,y,z,radius,density\n0,0,0.03,0.005,2500\n0.02,0,-0.001,0.005,2500\n";
  changed(quick / "collision.yaml", "data/eight_grains.csv", "b.csv", "b.yaml");
  const CommandResult r = grouser_command("dem run b.yaml --out b", scratch());
  EXPECT_EQ(r.code, 2);
  EXPECT_NE(r.err.find("b.csv:3:1: grain 1 at "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("body 0 is 'plate'"), std::string::npos) << r.err;
}

TEST(DemRun, AGrainOutsideTheDomainIsNamedByLine) {
  std::ofstream(scratch() / "d.csv") << "x,y,z,radius,density\n0,0,0.03,0.005,2500\n0,0,0.2,0.005,2500\n";
  changed(quick / "collision.yaml", "data/eight_grains.csv", "d.csv", "d.yaml");
  expect_message("dem run d.yaml --out d", 2, "d.csv:3:1: grain 1: z = 0.2 m is outside the domain");
}

/// Largest memory of one run of the command [bytes].
double largest_memory(const std::vector<std::string>& arguments) {
  const pid_t child = fork();
  if (child == 0) {
    std::vector<char*> argv{const_cast<char*>(GROUSER_COMMAND)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    std::freopen("/dev/null", "w", stdout);
    if (chdir(scratch().c_str()) == 0) execv(GROUSER_COMMAND, argv.data());
    _exit(127);
  }
  int status = -1;
  rusage use{};
  EXPECT_EQ(wait4(child, &status, 0, &use), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  return 1024.0 * static_cast<double>(use.ru_maxrss);
}

TEST(DemRun, MemoryFromReadingToTheFinalStateIsBelow400BytesAGrain) {
  // A lattice whose neighbours along x and y overlap by 1 % of the diameter and are listed along z: two contacts and three
  // neighbours a grain, as in a bed.
  const auto write = [](const std::string& name, int n) {
    std::ofstream csv(scratch() / (name + ".csv"));
    csv << "x,y,z,radius,density,vx,vy,vz,wx,wy,wz,material,frozen\n";
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k)
          csv << 0.00495 * i << ',' << 0.00495 * j << ',' << 0.0025 + 0.0054 * k << ",0.0025,3100,0,0,0,0,0,0,soil,0\n";
    std::ofstream(scratch() / (name + ".yaml"))
        << "dem: memory\ndomain: {lower: [0 mm, 0 mm, -1 mm], upper: [" << 4.95 * n << " mm, " << 4.95 * n << " mm, "
        << 20 + 5.4 * n << " mm], periodic: [x, y]}\ngrains: {file: " << name
        << ".csv}\nlaw: {rolling: constant}\nmaterials: [{name: soil, young_modulus: 70 MPa, poisson_ratio: 0.35}]\n"
           "pairs: [{of: [soil, soil], friction: 0.8, restitution: 0.4, rolling_coefficient: 0.3}]\ntime_step: 2 us\n"
           "duration: 40 us\nbodies: [{name: floor, material: soil, surfaces: [{plane: {normal: [0, 0, 1]}}]}]\n";
  };
  write("few", 10);
  write("many", 62);
  const double few = largest_memory({"dem", "run", "few.yaml", "--quiet"}),
               many = largest_memory({"dem", "run", "many.yaml", "--quiet"});
  EXPECT_LT((many - few) / (62.0 * 62 * 62 - 1000), 400);
}

TEST(DemRun, AnUnstableStepStopsByName) {
  changed(quick / "collision.yaml", "data/eight_grains.csv", (quick / "data/eight_grains.csv").string(), "u1.yaml");
  changed(scratch() / "u1.yaml", "time_step: 5 us", "time_step: 500 us", "u.yaml");
  expect_message("dem run u.yaml --quiet --out u", 1, "too large for the stiffness of the contacts; at most");
}

TEST(DemRun, AMissingPairIsNamed) {
  changed(quick / "collision.yaml", "data/eight_grains.csv", (quick / "data/eight_grains.csv").string(), "p1.yaml");
  changed(scratch() / "p1.yaml",
          "  - {of: [glass, steel], friction: 0.3, restitution: 0.6, rolling_coefficient: 0.1}\n", "", "p.yaml");
  expect_message("dem run p.yaml --quiet --out p", 2, "the pair [glass, steel] is missing");
}

TEST(DemRun, AFullDiskIsSaidAndTheResultsBeforeItStay) {
  if (!fs::exists("/dev/full")) GTEST_SKIP();
  changed(quick / "collision.yaml", "data/eight_grains.csv", (quick / "data/eight_grains.csv").string(), "f.yaml");
  const fs::path out = scratch() / "full";
  fs::create_directories(out);
  fs::create_symlink("/dev/full", out / "forces.csv.part");
  expect_message("dem run f.yaml --quiet --out full", 2, "forces.csv: cannot be written: No space left on device");
  // The state is safe: once there is room, the same command ends the run.
  EXPECT_TRUE(fs::exists(out / "checkpoint.h5"));
  EXPECT_EQ(grouser_command("dem run f.yaml --quiet --out full", scratch()).code, 0);
}

TEST(DemBed, IsStoredWithItsInputsAndFeedsARun) {
  const fs::path bed = scratch() / "bed.h5";
  const std::string make = "dem bed '" + (quick / "bed_sinusoid.yaml").string() + "' --quiet --out " + bed.string();
  const CommandResult r = grouser_command(make, source);
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NE(grouser_command(make, source).out.find("is there already"), std::string::npos);
  std::ofstream(scratch() / "on_bed.yaml")
      << "dem: a bed at rest\ndomain: {lower: [0 m, 0 m, -10 mm], upper: [120 mm, 40 mm, 100 mm], periodic: [x, y]}\n"
         "grains: {bed: bed.h5}\nmaterials:\n  - {name: soil, young_modulus: 70 MPa, poisson_ratio: 0.35}\npairs:\n"
         "  - {of: [soil, soil], friction: 0.86, restitution: 0.4, rolling_coefficient: 0.3}\n"
         "time_step: 10 us\nduration: 20 ms\nbodies:\n  - {name: floor, material: soil, surfaces: [{plane: {normal: "
         "[0, 0, 1]}}]}\n";
  const CommandResult run = grouser_command("dem run on_bed.yaml --quiet --out on_bed", scratch());
  EXPECT_EQ(run.code, 0) << run.err;
  // One byte of a number changed: found out.
  std::string bytes = read_text(bed);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  std::ofstream(scratch() / "bed.h5", std::ios::binary) << bytes;
  expect_message("dem run on_bed.yaml --quiet --out on_bed2", 2, "bed.h5");
}

}  // namespace
}  // namespace grouser::test
