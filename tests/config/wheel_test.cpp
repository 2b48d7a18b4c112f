// The shipped wheels against the printed tables, and the errors of wheel files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "config_support.h"
#include "grouser/terrain/loaders.h"

namespace grouser {
namespace {

using ::testing::ElementsAre;
using testing::messages;

const std::filesystem::path folder = GROUSER_SOURCE_DIR "/examples/wheels";

RunningGear shipped(const std::string& name) { return load_running_gear_file(folder / (name + ".yaml")); }

TEST(Wheels, AllShippedFilesLoad) {
  int count = 0;
  for (const auto& e : std::filesystem::directory_iterator(folder)) {
    if (e.path().extension() != ".yaml") continue;
    ++count;
    SCOPED_TRACE(e.path());
    RunningGear g;
    ASSERT_NO_THROW(g = load_running_gear_file(e.path()));
    EXPECT_GT(g.radius(), 0);
    EXPECT_GE(g.outer_radius(), g.radius());
    EXPECT_GT(g.width(), 0);
  }
  EXPECT_GE(count, 8);
}

TEST(Wheels, Table33AsPrinted) {
  const auto ding = std::get<LuggedCylinder>(shipped("ding_wheel").shape);
  EXPECT_DOUBLE_EQ(ding.radius, 0.157);
  EXPECT_DOUBLE_EQ(ding.width, 0.165);
  EXPECT_EQ(ding.tread_radius, 0);
  EXPECT_EQ(ding.lug_count, 30);
  EXPECT_DOUBLE_EQ(ding.lug_height, 0.005);
  EXPECT_DOUBLE_EQ(ding.lug_width, 0.002);
  EXPECT_EQ(ding.closed_sides, 2);
  EXPECT_EQ(ding.sidewall_height, 0);
  const auto mer = std::get<LuggedCylinder>(shipped("mer_wheel").shape);
  EXPECT_DOUBLE_EQ(mer.radius, 0.125);
  EXPECT_DOUBLE_EQ(mer.width, 0.16);
  EXPECT_DOUBLE_EQ(mer.tread_radius, 0.219);
  EXPECT_EQ(mer.lug_count, 30);
  EXPECT_DOUBLE_EQ(mer.lug_height, 0.00555);
  EXPECT_DOUBLE_EQ(mer.lug_width, 0.0021);
  EXPECT_EQ(mer.closed_sides, 1);
  EXPECT_DOUBLE_EQ(mer.sidewall_height, 0.0025);
  // 30 lugs of 2.1 mm on 2 pi 125 mm = 785.4 mm.
  EXPECT_NEAR(mer.lug_ratio, 0.0802, 1e-4);
  // Section 3.4: the maximum radius with grousers is 0.1306 m.
  EXPECT_NEAR(shipped("mer_wheel").outer_radius(), 0.1306, 1e-4);
}

TEST(Wheels, Table23AsPrinted) {
  const auto s = std::get<SmoothCylinder>(shipped("wheel_s").shape);
  EXPECT_DOUBLE_EQ(s.radius, 0.080);
  EXPECT_DOUBLE_EQ(s.width, 0.075);
  const auto l = std::get<LuggedCylinder>(shipped("wheel_l").shape);
  EXPECT_DOUBLE_EQ(l.radius, 0.080);
  EXPECT_DOUBLE_EQ(l.lug_height, 0.005);
  EXPECT_DOUBLE_EQ(l.lug_ratio, 0.1);
  EXPECT_DOUBLE_EQ(shipped("wheel_l").outer_radius(), 0.085);
}

TEST(Wheels, Tables45And54AsPrinted) {
  EXPECT_DOUBLE_EQ(shipped("mit_wheel").radius(), 0.130);
  EXPECT_DOUBLE_EQ(shipped("mit_wheel").width(), 0.160);
  EXPECT_DOUBLE_EQ(shipped("quasi_2d_wheel").radius(), 0.065);
  EXPECT_DOUBLE_EQ(shipped("quasi_2d_wheel").width(), 0.03);
}

const auto load = [](const ConfigNode& r) { load_running_gear(r); };

TEST(Wheels, NonsenseIsRefusedByName) {
  EXPECT_THAT(messages("wheel: w\nsource: s\nshape: smooth\nradius: -130 mm\nwidth: 160\n", load),
              ElementsAre("f.yaml:4:9: radius: '-130 mm' is out of range; allowed is 0.1 mm to 10000 mm",
                          "f.yaml:5:8: width: '160' has no unit; a length is wanted, for example '160 mm'"));
  const std::string lugged = "wheel: w\nsource: s\nshape: lugged\nradius: 100 mm\nwidth: 160 mm\nlug_height: 5 mm\n";
  EXPECT_THAT(messages(lugged + "lug_count: 400\nlug_width: 2 mm\n", load),
              ElementsAre("f.yaml:7:12: lug_count: 400 lugs of 2 mm do not fit on a circumference of 628.319 mm"));
  EXPECT_THAT(messages(lugged + "lug_count: 4\nlug_width: 2 mm\nlug_ratio: 1.5\n", load),
              ElementsAre("f.yaml:9:12: lug_ratio: '1.5' is out of range; allowed is 0 to 1"));
  EXPECT_THAT(
      messages(lugged + "lug_count: 4\nlug_width: 2 mm\ntread: concave\ntread_radius: 50 mm\n", load),
      ElementsAre("f.yaml:10:15: tread_radius: an arc across a width of 160 mm has a radius of at least 80 mm"));
  EXPECT_THAT(messages(lugged + "lug_count: 4\nlug_width: 2 mm\ntread_radius: 50 mm\n", load),
              ElementsAre("f.yaml:9:15: tread_radius: belongs to 'tread: concave'"));
  EXPECT_THAT(messages("wheel: w\nsource: s\nshape: smooth\nradius: 1 m\nwidth: 1 m\nlug_hight: 5 mm\n", load),
              ElementsAre("f.yaml:6:1: unknown key 'lug_hight'; known here: radius, shape, source, wheel, width"));
}

}  // namespace
}  // namespace grouser
