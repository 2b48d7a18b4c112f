// Campaigns: the plan as printed, tables from records whose content is known, and one run of grains.
#include "grouser/sdem/campaign.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "grouser/terrain/config.h"
#include "grouser/terrain/types.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

const fs::path kExamples = fs::path(GROUSER_SOURCE_DIR) / "examples" / "14_surrogate";

TEST(PublishedPlan, HasTheRunsAndLengthsThatArePrinted) {
  const sdem::Campaign c = sdem::load_campaign(kExamples / "published.yaml");
  const auto runs = sdem::plan_of(c);
  ASSERT_EQ(runs.size(), 108u);
  double shortest = 1e9, longest = 0, least = 1e9, most = 0;
  for (const auto& r : runs) {
    shortest = std::min(shortest, r.duration);
    longest = std::max(longest, r.duration);
    least = std::min(least, c.margin + r.vx * r.duration);
    most = std::max(most, c.margin + r.vx * r.duration);
  }
  // Table 5.1: simulation length 14.5 to 58 s, soil box length 0.88 to 2.91 m.
  EXPECT_NEAR(shortest, 14.5, 1e-9);
  EXPECT_NEAR(longest, 58, 1e-9);
  EXPECT_NEAR(least, 0.88, 1e-9);
  EXPECT_NEAR(most, 2.91, 1e-9);
  // Section 5.3: 11,500 grains in 1.22 x 0.03 m to about 0.11 m; a bed of that size here within the scatter of packings.
  sdem::CampaignRun r = runs[0];
  r.bricks = 1;
  sdem::Campaign bed = c;
  bed.brick = 1.22;
  bed.bed_depth = 0.11;
  EXPECT_NEAR(sdem::grain_steps(bed, r) / r.duration * c.soil.dt, 11500, 0.1 * 11500);
}

sdem::Campaign one_node() {
  sdem::Campaign c;
  c.title = "t";
  c.wheel = "wheel";
  c.radius = 0.065;
  c.width = 0.03;
  c.w = {0};
  c.vx = {0.02};
  c.vz = {-0.01};
  return c;
}

TEST(MakeTables, SurfaceVelocitiesAreThoseOfTheUppermostGrains) {
  const sdem::Campaign c = one_node();
  const auto runs = sdem::plan_of(c);
  // Flat soil that sinks past the hub, window by window; grains at the surface move by a linear field, those below ten times as fast.
  const auto fx = [](double dx, double dz) { return 0.004 + 0.02 * dx - 0.01 * dz; };
  const auto fz = [](double dx, double dz) { return -0.002 - 0.03 * dx + 0.02 * dz; };
  sdem::RunRecord r;
  for (double level = -0.15; level < 0.15; level += 0.0005) {
    r.time.push_back(0);
    r.height.push_back(0.1F);
    for (auto* v : {&r.fx, &r.fz, &r.torque}) v->push_back(0);
    r.bin_fx.resize(r.bin_fx.size() + sdem::RunRecord::kBins);
    r.bin_fz.resize(r.bin_fz.size() + sdem::RunRecord::kBins);
    for (double dx = -0.19; dx < 0.19; dx += 0.001)
      for (const double below : {0.0, 0.01}) {
        const double dz = level - below, times = below > 0 ? 10 : 1;
        r.dx.push_back(static_cast<float>(dx));
        r.dz.push_back(static_cast<float>(dz));
        r.vx.push_back(static_cast<float>(times * fx(dx, dz)));
        r.vz.push_back(static_cast<float>(times * fz(dx, dz)));
        r.radius.push_back(0.002F);
      }
    r.first.push_back(static_cast<std::int64_t>(r.dx.size()));
  }
  const sdem::Tables t = sdem::make_tables(c, runs, [&](std::size_t) { return r; });
  EXPECT_TRUE(t.faults().empty());
  // Left and right see every level; a linear field is the mean of its cell and stays under smoothing. Cells of 4 mm hold grains 1 mm apart at
  // up to half a grain's distance off the middle: 0.5 mm times the gradient 0.03/s, 2e-5 m/s.
  int checked = 0;
  for (const sdem::Part part : {sdem::Part::soil_left, sdem::Part::soil_right}) {
    const sdem::Grid& g = t.part(part);
    for (int i = 16; i + 16 < g.u.count; ++i)
      for (int j = 3; j + 3 < g.v.count; ++j) {
        ASSERT_EQ(g.known[g.index(0, i, j)], 1.0F);
        ASSERT_NEAR(g.x[g.index(0, i, j)], fx(g.v.at(j), g.u.at(i)), 3e-5);
        ASSERT_NEAR(g.z[g.index(0, i, j)], fz(g.v.at(j), g.u.at(i)), 3e-5);
        ++checked;
      }
  }
  EXPECT_GT(checked, 2000);
  // Nothing was ever above the levels or below them: estimated, finite, said so.
  EXPECT_EQ(t.part(sdem::Part::soil_right).known[t.part(sdem::Part::soil_right).index(0, 0, 10)], 0.0F);
}

TEST(MakeTables, PressureTimesRimIsTheForce) {
  const sdem::Campaign c = one_node();
  const auto runs = sdem::plan_of(c);
  sdem::RunRecord r;
  // 3 N a bin forward and 5 N upward, from -10 to 40 degrees, at every height; one contact alone at 100 degrees.
  for (double h = 0.095; h < 0.24; h += 0.001) {
    r.time.push_back(0);
    r.height.push_back(static_cast<float>(h));
    for (auto* v : {&r.fx, &r.fz, &r.torque}) v->push_back(0);
    for (int b = 0; b < sdem::RunRecord::kBins; ++b) {
      const double angle = -180 + 2 * (b + 0.5);
      const bool on = angle > -10 && angle < 40;
      r.bin_fx.push_back(on ? 0.03F : 0);
      r.bin_fz.push_back(on ? 0.05F : angle > 100 && angle < 102 ? 1.0F : 0);
    }
    r.first.push_back(0);
  }
  const sdem::Tables t = sdem::make_tables(c, runs, [&](std::size_t) { return r; });
  const sdem::Grid& g = t.part(sdem::Part::wheel_bottom);
  const double area = 2 * pi / 180 * c.radius * c.width;  // rim of one bin
  for (int i = 0; i < g.u.count; ++i) {
    const int middle = 45 + 7;  // 14 degrees, far from both ends
    EXPECT_NEAR(g.x[g.index(0, i, middle)], 0.03 / area, 1e-4 * 0.03 / area);
    EXPECT_NEAR(g.z[g.index(0, i, middle)], 0.05 / area, 1e-4 * 0.05 / area);
  }
  const sdem::Grid& top = t.part(sdem::Part::wheel_top);
  for (const float z : top.z) EXPECT_EQ(z, 0.0F);  // the lone contact made no pressure, and there is no soil up there
}

/// Seconds of one core: large soft grains, a few windows.
sdem::Campaign coarse() {
  sdem::Campaign c = sdem::load_campaign(kExamples / "coarse.yaml");
  c.w = {1.2};
  c.vx = {0.06};
  c.vz = {-0.08, 0.08};
  return c;
}

TEST(ConstantVelocityRun, PressesHarderTheDeeperAndReadsBackAsItWas) {
  const fs::path folder = fs::temp_directory_path() / ("sdem_campaign_" + std::to_string(getpid()));
  const sdem::Campaign c = coarse();
  const auto runs = sdem::plan_of(c);
  ASSERT_EQ(runs.size(), 2u);
  const dem::Packing brick = sdem::campaign_brick(c, folder);
  const sdem::RunRecord down = sdem::simulate(c, runs[0], brick), up = sdem::simulate(c, runs[1], brick);
  ASSERT_GT(down.windows(), 30u);
  EXPECT_NEAR(down.height.front(), runs[0].high, 0.01);
  EXPECT_NEAR(down.height.back(), runs[0].low, 0.01);
  EXPECT_NEAR(up.height.front(), runs[1].low, 0.01);
  const auto mean = [](const std::vector<float>& v, std::size_t a, std::size_t b) {
    double sum = 0;
    for (std::size_t k = a; k < b; ++k) sum += static_cast<double>(v[k]);
    return sum / static_cast<double>(b - a);
  };
  const std::size_t n = down.windows();
  EXPECT_EQ(mean(down.fz, 0, n / 20), 0);  // begins clear of the soil
  EXPECT_GT(mean(down.fz, n * 2 / 3, n), 2 * mean(down.fz, n / 3, n * 2 / 3));
  EXPECT_GT(mean(down.fz, n / 2, n), 3 * mean(up.fz, up.windows() / 4, up.windows()));  // pulled out: little
  // Springs of the contacts (bins) against the impulse of all forces: dampers and rolling are some per cent, windows few.
  double bins = 0;
  for (const float f : down.bin_fz) bins += static_cast<double>(f);
  EXPECT_NEAR(bins / (mean(down.fz, 0, n) * static_cast<double>(n)), 1, 0.15);

  sdem::write_run(down, runs[0], folder / "a.h5");
  const sdem::RunRecord back = sdem::read_run(runs[0], folder / "a.h5");
  EXPECT_EQ(back.dx, down.dx);
  EXPECT_EQ(back.bin_fx, down.bin_fx);
  EXPECT_EQ(back.first, down.first);
  EXPECT_THROW(sdem::read_run(runs[1], folder / "a.h5"), ResultsError);
  // Again: same bits.
  EXPECT_EQ(sdem::simulate(c, runs[0], brick).dx, down.dx);

  const sdem::Tables t = sdem::make_tables(c, runs, [&](std::size_t k) { return k == 0 ? down : up; });
  EXPECT_TRUE(t.faults().empty());
  EXPECT_EQ(t.nodes(), 2u);
  fs::remove_all(folder);
}

/// A wheel dragged without spin through soil that is its own neighbour along x: the bed must not go along, so that soil resists.
TEST(ConstantVelocityRun, TheBedIsHeldByItsEndsOrItsFloor) {
  const fs::path folder = fs::temp_directory_path() / ("sdem_held_" + std::to_string(getpid()));
  sdem::Campaign c = coarse();
  c.w = {0};
  c.vx = {0.12};
  c.vz = {-0.04};
  for (const bool floor : {false, true}) {
    c.rough_floor = floor;
    const auto run = sdem::plan_of(c).front();
    const sdem::RunRecord r = sdem::simulate(c, run, sdem::campaign_brick(c, folder));
    double fx = 0, fz = 0, low = 0;
    int grains = 0;
    for (std::size_t k = 2 * r.windows() / 3; k < r.windows(); ++k) {
      fx += static_cast<double>(r.fx[k]);
      fz += static_cast<double>(r.fz[k]);
      for (auto i = static_cast<std::size_t>(r.first[k]); i < static_cast<std::size_t>(r.first[k + 1]); ++i)
        if (static_cast<double>(r.dx[i]) < -0.2) low += static_cast<double>(r.vx[i]), ++grains;
    }
    ASSERT_GT(grains, 100);
    EXPECT_LT(fx, -0.3 * fz) << floor;  // friction of grains is 0.6; a bed that goes along gives none
    // Behind the wheel, where it has passed; over a smooth floor soil slides on into the rut.
    EXPECT_LT(std::abs(low / grains), (floor ? 0.05 : 0.5) * c.vx[0]) << floor;
  }
  EXPECT_NE(sdem::plan_of(coarse()).front().name, sdem::plan_of(c).front().name);
  fs::remove_all(folder);
}

TEST(Campaign, NamesEveryErrorOfItsFile) {
  const fs::path file = fs::temp_directory_path() / ("sdem_bad_" + std::to_string(getpid()) + ".yaml");
  std::string text;
  {
    std::FILE* f = std::fopen((kExamples / "coarse.yaml").c_str(), "r");
    char line[400];
    while (std::fgets(line, sizeof line, f)) text += line;
    std::fclose(f);
  }
  const auto swap = [&](const std::string& a, const std::string& b) { text.replace(text.find(a), a.size(), b); };
  swap("coarse_wheel.yaml", (kExamples / "coarse_wheel.yaml").string());
  swap("\"-10 mm/s\"", "\"0 mm/s\"");
  swap("width: 40 mm", "width: 30 mm");
  swap("clearance:", "clearence:");
  std::FILE* f = std::fopen(file.c_str(), "w");
  std::fputs(text.c_str(), f);
  std::fclose(f);
  try {
    sdem::load_campaign(file);
    FAIL();
  } catch (const ConfigError& e) {
    const std::string all = e.what();
    for (const char* part : {"give no 0", "wider than two of the largest grains", "did you mean 'clearance'"})
      EXPECT_NE(all.find(part), std::string::npos) << all;
  }
  fs::remove(file);
}

}  // namespace
}  // namespace grouser::test
