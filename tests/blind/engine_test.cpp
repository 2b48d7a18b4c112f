// A small fixed evaluation of the command itself: sets with a hidden cause, the diagnosis, the score. The full one is
// run by hand (README.md).
#include <gtest/gtest.h>

#include <filesystem>

#include "drive.h"
#include "generate.h"
#include "score.h"
#include "seal.h"

namespace blind {
namespace {

nlohmann::json evaluated(const std::string& plan, int sets, const std::string& folder) {
  GenerateOptions o;
  o.plan = plan;
  o.sets = sets;
  o.seed = "development of the fixed small set";
  o.out = folder + "/" + plan + "/sets";
  o.answers = folder + "/" + plan + "/sealed/answers.json";
  generate(o);
  EXPECT_EQ(drive({o.out, GROUSER_COMMAND, folder + "/" + plan + "/results", 0, 0, 120}), 0)
      << "a set without a diagnosis";
  const std::string table =
      score(o.out, o.answers, folder + "/" + plan + "/results", folder + "/" + plan + "/score.json");
  std::fputs(table.c_str(), stdout);
  return nlohmann::json::parse(read_text(folder + "/" + plan + "/score.json")).at("bars");
}

// With few sets the interval is wide: only a clear miss fails.
void expect_not_missed(const nlohmann::json& bars, const std::string& beginning) {
  int found = 0;
  for (const auto& b : bars) {
    if (b.at("bar").get<std::string>().rfind(beginning, 0) != 0) continue;
    ++found;
    if (b.at("met").is_null()) continue;
    EXPECT_TRUE(b.at("met").get<bool>()) << b.dump();
  }
  EXPECT_GT(found, 0) << beginning;
}

TEST(BlindEvaluation, NoAlarmOnNothingAndNamesThatAreRight) {
  const std::string folder = testing::TempDir() + "blind_engine";
  std::filesystem::remove_all(folder);
  const nlohmann::json full = evaluated("full", 40, folder);
  expect_not_missed(full, "false alarm");
  expect_not_missed(full, "right when named");
  expect_not_missed(evaluated("confounded", 8, folder), "one name in an exactly confounded class");
}

}  // namespace
}  // namespace blind
