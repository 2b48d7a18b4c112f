// grouser plot: figures from CSV files, and what is said about a wrong figure file.
#include <gtest/gtest.h>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

fs::path figures(const std::string& name, const std::string& text) {
  const fs::path folder = scratch() / "plot";
  fs::create_directories(folder);
  std::ofstream(folder / "pull.csv") << "# invented\nslip,model,pull_N\n0.1,a,7\n0.3,a,18.25\n0.3,b,nan\n";
  std::ofstream(folder / "ragged.csv") << "slip,pull_N\n0.1,7\n0.3\n";
  std::ofstream(folder / "empty.csv");
  std::ofstream(folder / name) << text;
  return folder;
}

std::string plot_of(const std::string& series) {
  return "title: Pull\nitems:\n  - plot:\n      title: P\n      x_label: slip\n      y_label: pull\n      series:\n"
         "        - " +
         series + "\n";
}

TEST(Plot, WritesOneOfflinePageWithTheNumbersOfTheTable) {
  const fs::path folder = figures("good.yaml", plot_of("{file: pull.csv, x: slip, y: pull_N, where: {model: a}}"));
  const CommandResult r = grouser_command("plot good.yaml", folder);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(r.out, "figures: good.html\n");
  const std::string page = read_text(folder / "good.html");
  EXPECT_NE(page.find("[7.0,18.25]"), std::string::npos) << "the rows of model a";
  EXPECT_EQ(page.find("src=\"http"), std::string::npos) << "nothing is fetched";
  const std::size_t colon = page.find("th:after{content:\":\""), none = page.find("th:after{content:none}");
  EXPECT_NE(none, std::string::npos) << "entries of a legend end without a colon";
  EXPECT_TRUE(colon == std::string::npos || colon < none) << "the style of the plot library comes first";
}

TEST(Plot, PutsThePageWhereItIsAsked) {
  const fs::path folder = figures("good.yaml", plot_of("{file: pull.csv, x: slip, y: pull_N}"));
  const CommandResult r = grouser_command("plot good.yaml -o other.html", folder);
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_TRUE(fs::exists(folder / "other.html"));
  const CommandResult nowhere = grouser_command("plot good.yaml -o no/such/folder/x.html", folder);
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_NE(nowhere.err.find("no/such/folder/x.html: "), std::string::npos) << nowhere.err;
}

struct WrongFigures {
  const char *name, *series, *message;
};
class PlotErrors : public testing::TestWithParam<WrongFigures> {};

TEST_P(PlotErrors, NameFileLineAndRemedy) {
  const fs::path folder = figures("wrong.yaml", plot_of(GetParam().series));
  const CommandResult r = grouser_command("plot wrong.yaml", folder);
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, GetParam().message);
  EXPECT_FALSE(fs::exists(folder / "wrong.html"));
}

INSTANTIATE_TEST_SUITE_P(
    Series, PlotErrors,
    testing::Values(
        WrongFigures{"column", "{file: pull.csv, x: slp, y: pull_N}",
                     "wrong.yaml:8:31: items[0].plot.series[0].x: the table pull.csv has no column 'slp'; did you mean "
                     "'slip'?\n"},
        WrongFigures{"where", "{file: pull.csv, x: slip, y: pull_N, where: {model: c}}",
                     "wrong.yaml:8:48: items[0].plot.series[0].where: no row of the file meets this\n"},
        WrongFigures{"absent", "{file: pul.csv, x: slip, y: pull_N}",
                     "wrong.yaml:8:18: items[0].plot.series[0].file: file 'pul.csv' not found; looked for pul.csv; did "
                     "you mean 'pull.csv'?\n"},
        WrongFigures{"ragged", "{file: ragged.csv, x: slip, y: pull_N}",
                     "ragged.csv:3:3: 1 cell where the header has 2; separate cells by commas\n"},
        WrongFigures{
            "empty", "{file: empty.csv, x: slip, y: pull_N}",
            "empty.csv:1:1: the file is empty; a header line and rows, cells separated by commas, are wanted\n"},
        WrongFigures{"text", "{file: pull.csv, x: slip, y: model}",
                     "pull.csv:3:5: column 'model': 'a' is not a number; the file of figures draws it as y\n"}),
    [](const testing::TestParamInfo<WrongFigures>& i) { return std::string(i.param.name); });

}  // namespace
}  // namespace grouser::test
