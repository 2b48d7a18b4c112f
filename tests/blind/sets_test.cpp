// Files of the sets, seeds, seals, plans and the driver.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <sstream>

#include "drive.h"
#include "generate.h"
#include "score.h"
#include "seal.h"
#include "set_files.h"

namespace blind {
namespace {

namespace fs = std::filesystem;

std::string scratch(const std::string& name) {
  const std::string folder = testing::TempDir() + "blind_" + name;
  fs::remove_all(folder);
  return folder;
}

TEST(BlindSeal, IsThePublishedNameBasedHash) {
  // RFC 9562, appendix A.4: version 5 of www.example.com in the DNS name space.
  EXPECT_EQ(digest("www.example.com"), "2ed6657d-e927-568b-95e1-2665a8aea6a2");
  EXPECT_NE(seed_of("a", 1), seed_of("a", 2));
  EXPECT_NE(seed_of("a", 1), seed_of("b", 1));
  EXPECT_THROW(digest(""), std::invalid_argument);
}

TEST(BlindPlan, AllPlansHave216RunsAndOneOrderEach) {
  for (const Plan p : {Plan::slip, Plan::slip_load, Plan::full, Plan::constant_load, Plan::constant_speed}) {
    Dice dice(1);
    const std::vector<PlannedRun> runs = plan_runs(p, {}, dice);
    EXPECT_EQ(runs.size(), 216u) << name(p);
    std::set<int> orders;
    for (const PlannedRun& r : runs) orders.insert(r.order);
    EXPECT_EQ(orders.size(), 216u);
    EXPECT_EQ(*orders.rbegin(), 216);
  }
}

TEST(BlindPlan, OptionsAddReplicatesBatchesAndTheWithheldBlock) {
  Dice dice(2);
  PlanOptions o;
  o.extra_replicates = 24;
  o.shared_preparation = true;
  o.withheld_block = true;
  const std::vector<PlannedRun> runs = plan_runs(Plan::full, o, dice);
  EXPECT_EQ(runs.size(), 216u + 48u + 54u);
  std::map<int, int> batches;
  int withheld = 0;
  for (const PlannedRun& r : runs) {
    ++batches[r.batch];
    withheld += r.withheld ? 1 : 0;
  }
  EXPECT_EQ(withheld, 54);
  int of_three = 0;
  for (const auto& [batch, count] : batches) of_three += count == 3 ? 1 : 0;
  EXPECT_EQ(of_three, 24);
}

TEST(BlindFiles, SlipColumnsConvertBackToTheTrueSlip) {
  // (r w - v)/(r w) and (r w - v)/max from the same speeds.
  const ColumnStyle rim{true, 0.13}, wide{false, 0.135};
  EXPECT_NEAR(slip_in_column(-0.7, rim, 0.13), 1 - 1 / 0.3, 1e-12);
  EXPECT_NEAR(slip_in_column(0.3, rim, 0.13), 0.3, 1e-12);
  EXPECT_NEAR(slip_in_column(0.3, wide, 0.13), 1 - 0.7 * 0.13 / 0.135, 1e-12);
}

TEST(BlindFiles, TheCaseIsYamlWithThePriorsOfTheReferenceSetUp) {
  const YAML::Node n = YAML::Load(case_text(Wheel{}, Priors{}));
  EXPECT_EQ(n["model"].as<std::string>(), "bekker.steady");
  EXPECT_EQ(n["wheel"]["radius"].as<std::string>(), "0.13 m");
  EXPECT_EQ(n["soil"]["pressure"]["k"]["value"].as<std::string>(), "254.1 kPa");
  EXPECT_EQ(n["soil"]["pressure"]["k"]["ln_sd"].as<double>(), 0.30);
  EXPECT_EQ(n["soil"]["shear"]["K"]["value"].as<std::string>(), "0.5151 mm");
  EXPECT_EQ(n["soil"]["shear"]["phi"]["sd"].as<std::string>(), "0.0502 rad");
  EXPECT_EQ(n["effects"].as<std::string>(), "all");
}

TEST(BlindMix, SharesAreExactAndEveryPlanHasOne) {
  GenerateOptions o;
  o.sets = 800;
  std::map<std::string, int> counted;
  for (const std::string& f : families(o)) ++counted[f];
  EXPECT_EQ(counted["null_plain"], 100);
  EXPECT_EQ(counted["null_preparation"], 100);
  EXPECT_EQ(counted["null_numeric"], 100);
  EXPECT_EQ(counted["effect"], 210);
  EXPECT_EQ(counted["outside"], 80);
  EXPECT_EQ(counted["pair"], 60);
  o.sets = 37;
  EXPECT_EQ(families(o).size(), 37u);
  EXPECT_THROW(mix_of("everything"), std::invalid_argument);
}

TEST(BlindSets, TheSameTextGivesTheSameBytesAndAnotherTextOthers) {
  GenerateOptions o;
  o.seed = "test";
  const MadeSet a = make_set(o, "sensor", 3), b = make_set(o, "sensor", 3);
  EXPECT_EQ(a.csv, b.csv);
  EXPECT_EQ(a.answer, b.answer);
  o.seed = "other";
  EXPECT_NE(make_set(o, "sensor", 3).csv, a.csv);
}

TEST(BlindSets, NothingInTheEnginesFilesTellsTheAnswer) {
  GenerateOptions o;
  o.seed = "test";
  const MadeSet a = make_set(o, "outliers", 1), null = make_set(o, "null_plain", 2);
  EXPECT_EQ(a.case_yaml, null.case_yaml);
  EXPECT_EQ(a.csv.substr(0, a.csv.find('\n')), null.csv.substr(0, null.csv.find('\n')));
  for (const Effect& e : effects()) EXPECT_EQ(a.csv.find(e.name), std::string::npos);
}

TEST(BlindSets, ScatterOfANullSetIsTheNoiseThatItStates) {
  // chi squared of 648 numbers about the true nominal wheel: 648 +- 36.
  GenerateOptions o;
  o.seed = "test";
  const MadeSet made = make_set(o, "null_plain", 5);
  const auto& s = made.answer.at("soil");
  const Soil soil{s.at("k"), s.at("n"), s.at("c"), s.at("phi"), s.at("K"), s.at("a0"), s.at("a1")};
  std::istringstream in(made.csv);
  std::string line;
  std::getline(in, line);
  double chi2 = 0;
  while (std::getline(in, line)) {
    std::vector<std::string> f;
    std::istringstream row(line);
    for (std::string one; std::getline(row, one, ',');) f.push_back(one);
    const Channels y = simulate(Wheel{}, soil, {}, {std::stod(f[0]), std::stod(f[3])});
    const double e[] = {(std::stod(f[9]) - y.drawbar) / 2, (std::stod(f[10]) - y.torque) / 0.2,
                        (std::stod(f[11]) - y.sinkage) / 0.0015};
    for (const double one : e) chi2 += one * one;
  }
  EXPECT_NEAR(chi2, 648, 4 * 36);
}

TEST(BlindDrive, QuotesPathsAndWithholds) {
  const std::string folder = scratch("quote");
  write_text(folder + "/set_0001/withhold.txt", "load_N=280\n");
  const std::string line = command_line({folder, "it's here", "/r", 1, 0, 60}, "set_0001");
  EXPECT_EQ(line.find("timeout 60 'it'\\''s here' diagnose '" + folder + "/set_0001/case.yaml' --data "), 0u);
  EXPECT_NE(line.find(" --withhold 'load_N=280' > '/r/set_0001/log.txt' 2>&1"), std::string::npos);
}

// Generates, answers with a stand-in that always says "adequate", scores; then breaks the seal.
TEST(BlindDrive, RunsResumesAndScoresEndToEnd) {
  const std::string folder = scratch("drive");
  GenerateOptions o;
  o.sets = 4;
  o.seed = "test";
  o.family = "null_plain";
  o.out = folder + "/sets";
  o.answers = folder + "/sealed/answers.json";
  generate(o);
  const std::string command = folder + "/stand_in";
  write_text(
      command,
      "#!/bin/sh\n# diagnose CASE --data DATA --out DIR\necho '{\"verdict\": \"adequate\"}' > \"$6/diagnosis.json\"\n");
  fs::permissions(command, fs::perms::owner_all);
  DriveOptions d{o.out, command, folder + "/results", 2, 0, 60};
  EXPECT_EQ(drive(d), 0);
  write_text(d.results + "/set_0002/diagnosis.json", "{\"verdict\": \"unknown\"}");
  EXPECT_EQ(drive(d), 0);  // nothing is run again
  const std::string table = score(o.out, o.answers, d.results, folder + "/score.json");
  EXPECT_NE(table.find("false alarm, null_plain"), std::string::npos);
  const nlohmann::json bars = nlohmann::json::parse(read_text(folder + "/score.json")).at("bars");
  EXPECT_EQ(bars.at(0).at("n"), 4);
  EXPECT_EQ(bars.at(0).at("figure"), 0.25);
  write_text(o.answers, read_text(o.answers) + " ");
  EXPECT_THROW(score(o.out, o.answers, d.results, ""), std::runtime_error);
}

TEST(BlindDrive, SaysWhichSetGaveNothing) {
  const std::string folder = scratch("nothing");
  write_text(folder + "/sets/set_0001/data.csv", "slip\n");
  EXPECT_EQ(drive({folder + "/sets", "/bin/false", folder + "/results", 1, 0, 60}), 1);
  EXPECT_THROW(drive({folder + "/no", "/bin/true", folder + "/results", 1, 0, 60}), std::invalid_argument);
}

}  // namespace
}  // namespace blind
