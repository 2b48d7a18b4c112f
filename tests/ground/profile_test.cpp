// Measured profiles: the Belgian block and small made-up lines.
#include <sstream>

#include "grouser/terrain/ground_profile.h"
#include "helpers.h"

namespace grouser {
namespace {

const std::filesystem::path belgian = ground_test::examples() / "data/belgian_block_profile/belgian_block_lines.csv";

/// The CSV read in the plainest way: rows of mm.
std::vector<std::vector<double>> plain_rows() {
  std::ifstream in(belgian);
  std::string text;
  std::getline(in, text);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, text)) {
    std::istringstream cells(text);
    std::vector<double> row;
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    rows.push_back(row);
  }
  return rows;
}

ProfileData belgian_data() { return read_profile_csv(belgian, {1.0, 1e-3, {}, {}}); }

/// Three samples 0, 1, 2 m of one line.
ProfileData ramp() { return {3, 1, 1.0, 0, 0, {0.0, 0.1, 0.4}}; }

TEST(BelgianBlock, HeightsAtItsNodesAreTheCsv) {
  const auto rows = plain_rows();
  ASSERT_EQ(rows.size(), 1001u);
  ASSERT_EQ(rows[0].size(), 32u);
  const GroundPtr g = profile_ground(belgian_data(), {}, "belgian");
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t c = 1; c < 32; ++c)
      // Only the rounding of the coordinates: slopes stay below 10.
      ASSERT_NEAR(g->height(rows[i][0] - 730, -1.3 + 0.1 * static_cast<double>(c - 1)), rows[i][c] * 1e-3, 1e-11);
}

TEST(BelgianBlock, BetweenNodesLiesBetweenItsNeighbours) {
  const auto rows = plain_rows();
  const GroundPtr g = profile_ground(belgian_data(), {}, "belgian");
  for (std::size_t i = 0; i + 1 < rows.size(); i += 3)
    for (std::size_t c = 1; c + 1 < 32; ++c) {
      const auto [lo, hi] = std::minmax({rows[i][c], rows[i + 1][c], rows[i][c + 1], rows[i + 1][c + 1]});
      const double h = g->height(rows[i][0] - 730 + 0.0037, -1.3 + 0.1 * static_cast<double>(c - 1) + 0.061) * 1e3;
      ASSERT_GE(h, lo - 1e-9);
      ASSERT_LE(h, hi + 1e-9);
    }
}

TEST(BelgianBlock, PlaneDetrendLeavesNoMeanAndNoTilt) {
  ProfileSettings p;
  p.detrend = ProfileSettings::Detrend::plane;
  const GroundPtr g = profile_ground(belgian_data(), p, "belgian");
  double z = 0, sz = 0, tz = 0;
  for (int i = 0; i <= 1000; ++i)
    for (int j = 0; j <= 30; ++j) {
      const double h = g->height(0.01 * i, -1.3 + 0.1 * j);
      z += h, sz += h * (0.01 * i - 5), tz += h * (0.1 * j - 1.5);
    }
  EXPECT_NEAR(z / 31031, 0, 1e-12);
  EXPECT_NEAR(sz / 31031, 0, 1e-12);
  EXPECT_NEAR(tz / 31031, 0, 1e-12);
}

/// No two points 0.1 mm apart differ by more than the steepest facet allows.
void expect_continuous(const Ground& g, double from, double to, double steepest) {
  double before = g.height(from, 0.07);
  for (double x = from + 1e-4; x < to; x += 1e-4) {
    const double h = g.height(x, 0.07);
    ASSERT_LT(std::abs(h - before), 1.01e-4 * steepest) << x;
    before = h;
  }
}

TEST(Profile, RepeatsWithoutAJump) {
  double steepest = 0;
  const ProfileData d = belgian_data();
  for (int j = 0; j < d.lines; ++j)
    for (int i = 1; i < d.n; ++i) {
      const auto k = static_cast<std::size_t>(j * d.n + i);
      steepest = std::max(steepest, std::abs(d.z[k] - d.z[k - 1]) / d.spacing);
    }
  ProfileSettings p;
  p.outside = Outside::repeat;
  p.seam = 1;
  const GroundPtr g = profile_ground(d, p, "belgian");
  // The cross-fade adds the difference of both ends (below 0.1 m) times its own slope 1.5/m.
  expect_continuous(*g, 8.5, 20, 1.5 * steepest + 0.15);
  // First pass as measured; period 9 m after it.
  const GroundPtr once = profile_ground(d, {}, "belgian");
  for (double x = 0; x < 9; x += 0.0173) EXPECT_EQ(g->height(x, 0.2), once->height(x, 0.2));
  for (double x = 9.1; x < 18; x += 0.0173) EXPECT_NEAR(g->height(x, 0.2), g->height(x + 9, 0.2), 1e-11);
  for (double x = 10.05; x < 18; x += 0.0173) EXPECT_NEAR(g->height(x, 0.2), once->height(x - 9, 0.2), 1e-11);
}

TEST(Profile, MirrorsBackAndForth) {
  ProfileSettings p;
  p.outside = Outside::mirror;
  const GroundPtr g = profile_ground(ramp(), p, "ramp");
  EXPECT_NEAR(g->height(2.5, 0), 0.25, 1e-15);
  EXPECT_NEAR(g->height(4.5, 0), 0.05, 1e-15);
  EXPECT_EQ(g->height(-1, 0), 0);
}

TEST(Profile, RunInBlendsFromFlatToTheMeasuredHeights) {
  ProfileSettings p;
  p.run_in = 1;
  p.offset = 0.2;
  p.frame.start = 5;
  ProfileData d = ramp();
  d.z = {0.3, 0.3, 0.3};
  const GroundPtr g = profile_ground(d, p, "level");
  EXPECT_EQ(g->height(4.9, 0), 0.2);
  EXPECT_NEAR(g->height(5.5, 0), 0.2 + 0.15, 1e-15);
  EXPECT_NEAR(g->height(6.5, 0), 0.5, 1e-15);
  EXPECT_NEAR(g->height(9, 0), 0.5, 1e-15);
}

TEST(Profile, ErrorOutsideNamesThePoint) {
  ProfileSettings p;
  p.outside = Outside::error;
  const GroundPtr g = profile_ground(ramp(), p, "ramp.csv");
  EXPECT_NEAR(g->height(2, 77), 0.4, 1e-15);
  try {
    g->height(2.5, 0);
    FAIL();
  } catch (const GroundError& e) {
    EXPECT_STREQ(e.what(),
                 "profile ramp.csv: the point (2.5, 0) m lies at 2.5 m along and 0 m across, outside 0..2 m along, and "
                 "'outside' is error");
  }
}

TEST(Profile, LinesMayRunFromLeftToRight) {
  const ground_test::Folder folder;
  const auto a = folder.write("a.csv", "s,z_v-0.5,z_v+0.5\n0,1,2\n1,3,4\n");
  const auto b = folder.write("b.csv", "s,z_v+0.5,z_v-0.5\n0,2,1\n1,4,3\n");
  const auto c = folder.write("c.csv", "s,left,right\r\n0,2,1\r\n1,4,3\r\n");
  const ProfileData da = read_profile_csv(a, {}), db = read_profile_csv(b, {}),
                    dc = read_profile_csv(c, {1, 1, 0.5, -1.0});
  EXPECT_EQ(da.z, (std::vector<double>{1, 3, 2, 4}));
  EXPECT_EQ(da.lateral_first, -0.5);
  for (const ProfileData& d : {db, dc}) {
    EXPECT_EQ(d.z, da.z);
    EXPECT_EQ(d.lateral_first, -0.5);
    EXPECT_EQ(d.lateral_spacing, 1);
  }
}

TEST(Profile, RefusesSettingsOutOfRange) {
  ProfileSettings p;
  p.outside = Outside::repeat;
  EXPECT_THROW(profile_ground(ramp(), p, "ramp"), GroundError);
  p.seam = 1.5;
  EXPECT_THROW(profile_ground(ramp(), p, "ramp"), GroundError);
  p.seam = 1;
  EXPECT_NO_THROW(profile_ground(ramp(), p, "ramp"));
  p = {};
  p.run_in = 3;
  EXPECT_THROW(profile_ground(ramp(), p, "ramp"), GroundError);
}

}  // namespace
}  // namespace grouser
