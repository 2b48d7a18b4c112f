// A law of sdem.v2 in the rig: its error bars and what lay outside of its training reach table and page.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <vector>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

const fs::path kExample = source / "examples" / "17_surrogate_by_direction";

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted)
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

/// Value of a column in the only row of sweep.csv.
double value(const fs::path& folder, const std::string& column) {
  std::istringstream text(read_text(folder / "sweep.csv"));
  std::string head, row;
  std::getline(text, head);
  std::getline(text, row);
  const std::vector<std::string> names = cells(head), values = cells(row);
  for (std::size_t i = 0; i < names.size() && i < values.size(); ++i)
    if (names[i] == column) return std::stod(values[i]);
  ADD_FAILURE() << "no column " << column;
  return 0;
}

TEST(LawInTheRig, ErrorBarsAndWhatLiesOutsideReachTableAndPage) {
  const auto rig = [](const std::string& file, const fs::path& out) {
    const CommandResult r =
        grouser_command("rig " + (kExample / file).string() + " --slips=-0.5 --quiet --out " + out.string(), scratch());
    EXPECT_EQ(r.code, 0) << r.err;
  };
  const fs::path flat = scratch() / "flat", rough = scratch() / "rough", nodes = scratch() / "nodes";
  rig("flat.yaml", flat);
  rig("sinusoid.yaml", rough);
  rig("nodes/flat.yaml", nodes);
  // 1.645 times what training runs differ by (results/training.txt): 0.47 mm, 0.04 and 0.042 of the load of 5.4 N.
  EXPECT_NEAR(value(flat, "sinkage_model_error_mm"), 0.78, 0.08);
  EXPECT_NEAR(value(flat, "drawbar_pull_model_error_N"), 0.35, 0.05);
  EXPECT_NEAR(value(flat, "driving_torque_model_error_Nm"), 0.024, 0.004);
  EXPECT_LT(value(flat, "outside"), 0.1);
  EXPECT_GT(value(rough, "outside"), 0.1);
  const std::string outside = "lay outside of what it was fitted to";
  EXPECT_EQ(read_text(flat / "report.html").find(outside), std::string::npos);
  EXPECT_NE(read_text(rough / "report.html").find(outside), std::string::npos);
  EXPECT_TRUE(std::isnan(value(nodes, "outside"))) << "a model that was not fitted to data says so";
}

}  // namespace
}  // namespace grouser::test
