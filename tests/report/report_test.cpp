#include "report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <regex>

#include "csv.h"
#include "decode.h"
#include "fake_run.h"
#include "grouser/terrain/recorder.h"
#include "pack.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Report : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("grouser_report_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string report(const std::vector<std::string>& names) {
    std::vector<fs::path> folders;
    for (const auto& n : names) folders.push_back(folder_ / n);
    write_report(folders, folder_ / "report.html");
    return read_text(folder_ / "report.html");
  }
  std::string message_of(const fs::path& folder) {
    try {
      write_report({folder}, folder_ / "report.html");
    } catch (const ResultsError& e) {
      return e.what();
    }
    return "no error";
  }
  fs::path folder_;
};

TEST_F(Report, AsksForNothingFromTheNetwork) {
  write_fake_run(folder_ / "a", {.duration = 2});
  const std::string html = report({"a"});
  // Any attribute or style rule that a browser would follow; data: is inside the file.
  const std::string page = html.substr(0, html.find("id=\"header\"")) + "\n" + html.substr(html.rfind("</script>"));
  std::smatch m;
  EXPECT_FALSE(std::regex_search(page, m, std::regex(R"re((src|href)\s*=\s*(?!["']?data:)[^\s>]+)re"))) << m.str();
  EXPECT_FALSE(std::regex_search(page, m, std::regex(R"(@import|url\(\s*["']?(https?:)?//)"))) << m.str();
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

TEST_F(Report, DecodesToTheRecordedValues) {
  FakeRun f;
  f.duration = 5;
  write_fake_run(folder_ / "a", f);
  const std::string html = report({"a"});
  const json header = json::parse(script_content(html, "header"));
  const auto block = unpack(script_content(html, "block-0"));
  const json& run = header["runs"][0];

  const auto time = decode(block, run["time"]);
  const auto speed = decode(block, run["channels"]["vehicle.speed"]["data"]);
  ASSERT_EQ(time.size(), 1001u);
  ASSERT_EQ(speed.size(), time.size());
  double lower = 1e9, upper = -1e9;
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double truth = fake_speed(0.005 * static_cast<double>(i));
    lower = std::min(lower, truth);
    upper = std::max(upper, truth);
  }
  // Half a step of 16 bits over the range, with room for rounding of the numbers themselves.
  const double limit = 1.001 * (upper - lower) / 131068;
  for (std::size_t i = 0; i < time.size(); ++i) {
    EXPECT_NEAR(time[i], 0.005 * static_cast<double>(i), 0.51e-6);
    ASSERT_NEAR(speed[i], fake_speed(0.005 * static_cast<double>(i)), limit);
  }
  // Positions are kept to a hundredth of a millimetre whatever the distance.
  const auto x = decode(block, run["channels"]["chassis.position"]["components"][0]);
  const auto pose_time = decode(block, run["pose_time"]);
  ASSERT_EQ(x.size(), pose_time.size());
  const RunFile file(folder_ / "a" / "run.h5");
  const auto recorded = file.read("chassis.position");
  const auto stride = static_cast<std::size_t>(std::lround(pose_time[1] / 0.005));
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x[i], recorded[3 * stride * i], 0.51e-5);
  // Triangles name vertices exactly.
  const auto triangles = decode(block, run["meshes"]["chassis"]["triangles"]);
  EXPECT_EQ(triangles, file.read("mesh.chassis.triangles"));
}

TEST_F(Report, KeepsMissingValuesConstantsAndExtremes) {
  report::Pack pack;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> constant(5, 1.0 / 3), holes{nan, -1e9, nan, 1e9, 0.0}, one{2.5}, none;
  const json a = pack.add(constant), b = pack.add(holes), c = pack.add(one), d = pack.add(none),
             e = pack.add_fixed(holes, 1.0);
  const auto block = unpack(pack.base64());
  EXPECT_EQ(decode(block, a), constant);
  const auto back = decode(block, b);
  EXPECT_TRUE(std::isnan(back[0]) && std::isnan(back[2]));
  EXPECT_NEAR(back[1], -1e9, 1e-3);
  EXPECT_NEAR(back[3], 1e9, 1e-3);
  EXPECT_EQ(decode(block, c), one);
  EXPECT_TRUE(decode(block, d).empty());
  EXPECT_EQ(decode(block, e)[3], 1e9);
  const std::vector<double> far{1e10};
  EXPECT_THROW(pack.add_fixed(far, 1.0), std::range_error);
}

TEST_F(Report, ThinningKeepsThePeakOfALongRun) {
  fs::create_directories(folder_ / "long");
  {
    Recorder file = Recorder::create(folder_ / "long" / "run.h5", {"run", "", "Long", "rigid", "0", 1});
    const int c = file.add_channel({"vehicle.speed", "m/s", "", "", 1});
    for (int i = 0; i < 50000; ++i) {
      file.set(c, i == 31234 ? 9.0 : std::sin(0.001 * i));
      file.end_frame(0.01 * i);
    }
    file.set_attribute("status", "finished");
  }
  const std::string html = report({"long"});
  const json header = json::parse(script_content(html, "header"));
  const auto y =
      decode(unpack(script_content(html, "block-0")), header["runs"][0]["channels"]["vehicle.speed"]["data"]);
  EXPECT_LE(y.size(), 4000u);
  EXPECT_NEAR(*std::max_element(y.begin(), y.end()), 9.0, 1e-3);
  EXPECT_EQ(header["runs"][0]["thinned"], true);
  // Statistics come from every frame.
  EXPECT_DOUBLE_EQ(header["runs"][0]["statistics"]["vehicle.speed"]["max"], 9.0);
}

TEST_F(Report, OfTwentySecondsIsSmallerThanFourMegabytes) {
  write_fake_run(folder_ / "a", {.duration = 20});
  EXPECT_LT(report({"a"}).size(), 4u << 20);
}

TEST_F(Report, ComparisonHoldsBothRuns) {
  write_fake_run(folder_ / "soil", {.duration = 2});
  write_fake_run(folder_ / "rigid", {.terrain = "rigid", .duration = 2, .sinkage = 1e-4});
  const std::string html = report({"soil", "rigid"});
  const json header = json::parse(script_content(html, "header"));
  ASSERT_EQ(header["runs"].size(), 2u);
  EXPECT_EQ(header["runs"][0]["terrain"], "bekker.steady");
  EXPECT_EQ(header["runs"][1]["terrain"], "rigid");
  for (int k : {0, 1}) {
    const auto block = unpack(script_content(html, "block-" + std::to_string(k)));
    EXPECT_EQ(decode(block, header["runs"][k]["time"]).size(), 401u);
  }
  // Same title twice is said once.
  EXPECT_EQ(header["title"], "Robot over rough ground");
}

TEST_F(Report, SummaryIsTakenFromTheChannels) {
  write_fake_run(folder_ / "a", {.duration = 3});
  const json run = json::parse(script_content(report({"a"}), "header"))["runs"][0];
  const RunFile file(folder_ / "a" / "run.h5");
  const double distance = file.read("vehicle.distance").back(), motor = file.read("vehicle.motor_energy").back();
  EXPECT_DOUBLE_EQ(run["summary"]["distance_m"], distance);
  EXPECT_DOUBLE_EQ(run["summary"]["energy_per_metre"], motor / distance);
  EXPECT_NEAR(run["summary"]["real_time_factor"], 3 / 0.36, 1e-12);
  EXPECT_NEAR(run["summary"]["energy_residual_ratio"], 1e-3, 1e-9);
  EXPECT_EQ(run["soil"], "mojave_martian_simulant");
  EXPECT_EQ(run["warnings"].size(), 0u);
  EXPECT_EQ(run["assumptions"][0]["key"], "motor.efficiency");
}

TEST_F(Report, OfAStoppedRunSaysSo) {
  write_fake_run(folder_ / "a", {.duration = 1, .status = "stopped: wheel lost at t = 0.9 s"});
  const json stopped = json::parse(script_content(report({"a"}), "header"))["runs"][0];
  EXPECT_THAT(stopped["warnings"][0], HasSubstr("wheel lost at t = 0.9 s"));
  write_fake_run(folder_ / "a", {.duration = 1, .status = "running"});
  const json killed = json::parse(script_content(report({"a"}), "header"))["runs"][0];
  EXPECT_THAT(killed["warnings"][0], HasSubstr("grouser resume"));
}

TEST_F(Report, TextsCannotBreakOutOfThePage) {
  fs::create_directories(folder_ / "a");
  {
    Recorder file =
        Recorder::create(folder_ / "a" / "run.h5", {"run", "</script><b>", "A </title> & </script>", "rigid", "0", 1});
    file.add_channel({"vehicle.speed", "m/s", "", "", 1});
    file.set_attribute("status", "finished");
  }
  const std::string html = report({"a"});
  EXPECT_EQ(json::parse(script_content(html, "header"))["runs"][0]["scenario"], "</script><b>");
  EXPECT_THAT(html, HasSubstr("<title>A &lt;/title&gt; &amp; &lt;/script&gt;</title>"));
}

TEST_F(Report, RigHoldsSweepMeasuredErrorsAndCases) {
  write_fake_rig(folder_ / "rig");
  const std::string html = report({"rig"});
  const json header = json::parse(script_content(html, "header"));
  const json& rig = header["rigs"][0];
  EXPECT_EQ(rig["title"], "One wheel");
  EXPECT_EQ(rig["sweep"]["rows"].size(), 9u);
  EXPECT_EQ(rig["measured"]["rows"].size(), 9u);
  EXPECT_EQ(rig["errors"]["notes"][0], "Invented.");
  EXPECT_EQ(rig["cases"].size(), 9u);
  EXPECT_EQ(rig["sweep"]["rows"][0][1], "115 N, rim");
  const auto block = unpack(script_content(html, "block-0"));
  EXPECT_NEAR(decode(block, rig["cases"][8]["channels"]["wheel.slip"]["data"]).back(), 0.7, 1e-9);
}

TEST_F(Report, FolderWithoutResultsIsNamedWithTheRemedy) {
  fs::create_directories(folder_ / "empty");
  EXPECT_THAT(message_of(folder_ / "empty"),
              AllOf(HasSubstr((folder_ / "empty").string()), HasSubstr("neither run.h5 nor sweep.csv"),
                    HasSubstr("grouser run")));
  EXPECT_THAT(message_of(folder_ / "nothing"),
              AllOf(HasSubstr((folder_ / "nothing").string()), HasSubstr("is not a folder")));
  EXPECT_THROW(write_report({}, folder_ / "report.html"), ResultsError);
  write_fake_run(folder_ / "a", {.duration = 1});
  EXPECT_THROW(write_report({folder_ / "a"}, folder_ / "no" / "such" / "report.html"), ResultsError);
}

TEST_F(Report, WarningsOfTheRunAreItsOwnWords) {
  write_fake_run(folder_ / "a", {.duration = 1, .warnings = {"wheel x left the data"}});
  const json run = json::parse(script_content(report({"a"}), "header"))["runs"][0];
  ASSERT_EQ(run["warnings"].size(), 1u);
  EXPECT_EQ(run["warnings"][0], "wheel x left the data");
  EXPECT_EQ(run["summary"]["energy_yardstick"], "positive motor work");
}

TEST_F(Report, BrokenTableIsNamedWithItsLine) {
  std::ofstream(folder_ / "t.csv") << "a,b\n1,2\n3\n";
  try {
    report::read_table(folder_ / "t.csv");
    FAIL() << "no error";
  } catch (const ConfigError& e) {
    EXPECT_THAT(e.what(), HasSubstr("t.csv:3:1: 1 cell where the header has 2"));
  }
}

}  // namespace
}  // namespace grouser::test
