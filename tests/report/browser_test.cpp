// Opens reports in headless Chromium where there is one; skipped by name where there is not.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "fake_run.h"
#include "report.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;
std::string output_of(const std::string& command) {
  std::string out;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> piece;
  while (std::size_t n = fread(piece.data(), 1, piece.size(), pipe)) out.append(piece.data(), n);
  pclose(pipe);
  return out;
}

class ReportInChromium : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v chromium > /dev/null 2>&1") != 0) GTEST_SKIP() << "chromium is not installed";
    folder_ = fs::path(testing::TempDir()) /
              (std::string("grouser_browser_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }
  /// The page's elements after it has run, with what it wrote to the console.
  std::string open(const std::string& flags) {
    return output_of(
        "timeout 120 chromium --headless --no-sandbox --hide-scrollbars --virtual-time-budget=6000 "
        "--window-size=1200,900"
        " --disable-background-networking --disable-component-update --disable-sync --no-first-run"
        " --enable-logging=stderr --user-data-dir='" +
        (folder_ / "profile").string() + "' " + flags + " --dump-dom 'file://" + (folder_ / "report.html").string() +
        "'");
  }
  /// Short messages: the page is a megabyte.
  static void expect(const std::string& page, const std::string& part) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  static void expect_quiet(const std::string& page) {
    const auto at = page.find("CONSOLE");
    EXPECT_EQ(at, std::string::npos) << page.substr(at == std::string::npos ? 0 : at, 300);
  }
  fs::path folder_;
};

const char* software_gl = "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --ignore-gpu-blocklist";

TEST_F(ReportInChromium, ComparisonDrawsWithoutConsoleErrors) {
  write_fake_run(folder_ / "soil", {.duration = 4});
  write_fake_run(folder_ / "rigid", {.terrain = "rigid", .duration = 4, .sinkage = 1e-4});
  write_report({folder_ / "soil", folder_ / "rigid"}, folder_ / "report.html");
  const std::string page = open(software_gl);
  expect(page, "data-ready=\"1\"");
  expect(page, "<title>Robot over rough ground</title>");
  expect(page, "Power spectral density");
  expect(page, "data-playback=\"drawn\"");
  expect_quiet(page);
}

TEST_F(ReportInChromium, WhatRoundsToZeroHasNoSignAndWarningsAreShown) {
  write_fake_run(folder_ / "soil", {.duration = 2, .slip = -0.003, .warnings = {"wheel front_left left the data"}});
  write_report({folder_ / "soil"}, folder_ / "report.html");
  const std::string page = open(software_gl);
  expect(page, "slip 0 %");
  EXPECT_EQ(page.find("slip \u22120 %"), std::string::npos);
  expect(page, "<p>wheel front_left left the data</p>");
  expect(page, "% of the positive motor work, ");
  expect_quiet(page);
}

TEST_F(ReportInChromium, RigDrawsWithoutConsoleErrors) {
  write_fake_rig(folder_ / "rig");
  write_report({folder_ / "rig"}, folder_ / "report.html");
  const std::string page = open(software_gl);
  expect(page, "data-ready=\"1\"");
  expect(page, "Model against measurement");
  expect_quiet(page);
}

TEST_F(ReportInChromium, WithoutWebGlThePlotsAreThereAndThePageSaysWhatIsMissing) {
  write_fake_run(folder_ / "soil", {.duration = 2});
  write_report({folder_ / "soil"}, folder_ / "report.html");
  const std::string page = open("--disable-3d-apis");
  expect(page, "data-ready=\"1\"");
  expect(page, "offers no WebGL");
  expect(page, "class=\"uplot ");
}

}  // namespace
}  // namespace grouser::test
