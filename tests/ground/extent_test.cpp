// Where measured grounds end, and what is said of the heights beyond.
#include <gtest/gtest.h>

#include "grouser/terrain/ground_extent.h"
#include "grouser/terrain/ground_grid.h"
#include "grouser/terrain/ground_profile.h"
#include "grouser/terrain/ground_sum.h"

namespace grouser {
namespace {

/// Five lines from -0.2 to 0.2 m, 1 m long.
ProfileData road() {
  ProfileData d;
  d.n = 11;
  d.lines = 5;
  d.spacing = 0.1;
  d.lateral_first = -0.2;
  d.lateral_spacing = 0.1;
  d.z.assign(55, 0.01);
  return d;
}

TEST(Extent, ProfileNamesTheSideWhereTheOutermostLineContinues) {
  const GroundPtr g = profile_ground(road(), {}, "road");
  EXPECT_EQ(beyond_data(*g, 0.5, 0.2), "");
  EXPECT_EQ(beyond_data(*g, 0.5, 0.201),
            "profile road: left of the outermost line, whose heights continue (data -0.2..0.2 m across)");
  EXPECT_EQ(beyond_data(*g, 0.5, -0.3),
            "profile road: right of the outermost line, whose heights continue (data -0.2..0.2 m across)");
  // It is so: the heights do continue.
  EXPECT_EQ(g->height(0.5, -0.3), g->height(0.5, -0.2));
}

TEST(Extent, ProfileNamesItsEndsUnlessTheFileAsksForWhatComesThere) {
  const GroundPtr plain = profile_ground(road(), {}, "road");
  EXPECT_EQ(beyond_data(*plain, 1.01, 0), "profile road: beyond its end at 1 m, where the last heights continue");
  EXPECT_EQ(beyond_data(*plain, -0.01, 0), "profile road: before its start, where the first heights continue");
  ProfileSettings p;
  p.run_in = 0.2;
  p.outside = Outside::repeat;
  p.seam = 0.3;
  const GroundPtr asked = profile_ground(road(), p, "road");
  EXPECT_EQ(beyond_data(*asked, 1.5, 0), "");
  EXPECT_EQ(beyond_data(*asked, -0.5, 0), "");
  EXPECT_EQ(beyond_data(*asked, -0.5, 1), "") << "flat before the run-in, whatever the width";
}

TEST(Extent, FollowsTheHeadingOfTheProfile) {
  ProfileSettings p;
  p.frame.heading = pi / 2;  // along y; left of it is -x
  const GroundPtr g = profile_ground(road(), p, "road");
  EXPECT_EQ(beyond_data(*g, 0.0, 0.5), "");
  EXPECT_NE(beyond_data(*g, -0.25, 0.5).find("left of"), std::string::npos);
}

TEST(Extent, HeightMapAndSumSayIt) {
  const HeightGrid grid{3, 3, 0, 0, 1, 1, std::vector<double>(9, 0.0)};
  const GroundPtr map = height_map_ground(grid, Outside::extend, "map");
  EXPECT_EQ(beyond_data(*map, 2, 2), "");
  EXPECT_EQ(beyond_data(*map, 2.1, 1), "height map map: outside its edge, whose heights continue");
  EXPECT_EQ(beyond_data(*height_map_ground(grid, Outside::mirror, "map"), 2.1, 1), "");
  const GroundPtr sum = sum_ground({flat_ground(), map});
  EXPECT_EQ(beyond_data(*sum, 2.1, 1), "height map map: outside its edge, whose heights continue");
  EXPECT_EQ(beyond_data(*flat_ground(), 1e6, 1e6), "") << "shapes without data have no end";
}

}  // namespace
}  // namespace grouser
