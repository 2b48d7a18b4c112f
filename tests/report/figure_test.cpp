// The page holds what the CSV files hold, and every wrong line of a figures file is named at its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "decode.h"
#include "fake_run.h"
#include "figure_file.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class Figures : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("grouser_figures_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("sweep.csv",
          "# two "
          "wheels\nslip,drawbar_N,sd_N,model\n0.1,-3.5,0.25,local\n0.3,20,0.5,local\n0.1,-4,,wong\n0.3,,0.5,wong\n");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  /// Items of the page that this figures file gives.
  json items(const std::string& yaml) const {
    write("figures.yaml", yaml);
    report::write_figure_page(report::read_figures(folder_ / "figures.yaml"), folder_ / "page.html");
    return json::parse(script_content(read_text(folder_ / "page.html"), "header"))["figures"]["items"];
  }
  std::string message(const std::string& yaml) const {
    write("figures.yaml", yaml);
    try {
      report::read_figures(folder_ / "figures.yaml");
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no error";
  }
  std::string place(int line, int column) const {
    return (folder_ / "figures.yaml").string() + ":" + std::to_string(line) + ":" + std::to_string(column) + ": ";
  }
  fs::path folder_;
};

const std::string head =
    "title: T\nitems:\n  - plot:\n      title: P\n      x_label: slip\n      y_label: pull\n      series:\n";

TEST_F(Figures, PageHoldsTheColumnsScaledWithGapsAndErrorBars) {
  const json plot = items(head +
                          "        - {file: sweep.csv, x: slip, y: drawbar_N, error: sd_N, y_scale: -2, each: model, "
                          "name: 'model {}', style: points}\n")[0];
  ASSERT_EQ(plot["series"].size(), 2u);
  EXPECT_EQ(plot["series"][0]["name"], "model local");
  EXPECT_EQ(plot["series"][0]["x"], json({0.1, 0.3}));
  EXPECT_EQ(plot["series"][0]["y"], json({7.0, -40.0}));
  EXPECT_EQ(plot["series"][0]["error"], json({0.5, 1.0}));  // half heights stay positive
  EXPECT_EQ(plot["series"][1]["y"], json({8.0, nullptr}));
  EXPECT_EQ(plot["series"][1]["style"], "points");
}

TEST_F(Figures, WhereComparesNumbersAsNumbers) {
  const json plot =
      items(head + "        - {file: sweep.csv, x: slip, y: drawbar_N, where: {slip: 0.10, model: wong}}\n")[0];
  EXPECT_EQ(plot["series"][0]["y"], json({-4.0}));
}

TEST_F(Figures, TablesAndTextStandAsTheyAreTyped) {
  const json all = items(
      "title: T\nitems:\n  - text: a </script> b\n  - table: {title: R, file: sweep.csv, columns: [model, drawbar_N], "
      "heads: [m, 'pull [N]'], where: {slip: 0.3}}\n");
  EXPECT_EQ(all[0]["text"], "a </script> b");
  EXPECT_EQ(all[1]["columns"], json({"m", "pull [N]"}));
  EXPECT_EQ(all[1]["rows"], json::parse(R"([["local", "20"], ["wong", ""]])"));
}

TEST_F(Figures, EveryWrongLineIsNamedAtItsPlace) {
  const std::string text = message(head +
                                   "        - {file: sweep.csv, x: slip, y: drawbar}\n"
                                   "        - {file: sweep.csv, x: slip, y: model}\n"
                                   "        - {file: none.csv, x: slip, y: drawbar_N}\n"
                                   "        - {file: sweep.csv, x: slip, y: drawbar_N, stile: dashed}\n"
                                   "        - {file: sweep.csv, x: slip, y: drawbar_N, where: {model: locl}}\n");
  EXPECT_THAT(text, HasSubstr(place(8, 41) + "items[0].plot.series[0].y: the table "));
  EXPECT_THAT(text, HasSubstr("did you mean 'drawbar_N'?"));
  EXPECT_THAT(text, HasSubstr("sweep.csv:3:15: column 'model': 'local' is not a number"));
  EXPECT_THAT(text, HasSubstr("none.csv"));
  EXPECT_THAT(text, HasSubstr("unknown key 'stile'"));
  EXPECT_THAT(text, HasSubstr("did you mean 'style'?"));
  EXPECT_THAT(text, HasSubstr("no row of the file meets this"));
}

TEST_F(Figures, UnknownColumnNamesTheNearestOne) {
  EXPECT_THAT(message(head + "        - {file: sweep.csv, x: slip, y: drawbar_M}\n"),
              HasSubstr("did you mean 'drawbar_N'?"));
}

TEST_F(Figures, ATypoForAnItemIsAnErrorNotAnEmptyPage) {
  const std::string text = message("title: T\nitems:\n  - plto: {title: P}\n");
  EXPECT_THAT(text, HasSubstr(place(3, 5)));
  EXPECT_THAT(text, HasSubstr("plto"));
}

TEST_F(Figures, SeriesOfUnequalLengthsAreRefusedByName) {
  report::FigurePage page;
  report::Plot plot;
  plot.title = "P";
  plot.series = {{"S", report::Series::Style::line, {1, 2}, {1}, {}, -1}};
  page.items.emplace_back(plot);
  try {
    report::write_figure_page(page, folder_ / "page.html");
    FAIL() << "no error";
  } catch (const ResultsError& e) {
    EXPECT_EQ(std::string(e.what()), "plot 'P', series 'S': x, y and error have 2, 1 and 0 values");
  }
}

}  // namespace
}  // namespace grouser::test
