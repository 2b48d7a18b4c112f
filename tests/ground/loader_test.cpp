// Grounds from YAML: what loads, and the whole text of every error.
#include <png.h>

#include <algorithm>

#include "grouser/terrain/loaders.h"
#include "helpers.h"

namespace grouser {
namespace {

using ground_test::examples;

class Errors : public testing::Test {
 protected:
  /// Diagnostics of a `ground:` text, one per line, the test's folder written as @.
  std::string of(const std::string& ground) {
    const ConfigDocument doc = ConfigDocument::from_text(ground, "ground.yaml", folder.path);
    const GroundPtr g = load_ground(doc.root().node("ground"), 1);
    EXPECT_NE(g, nullptr);
    std::string text;
    for (const Diagnostic& d : doc.diagnostics()) text += (text.empty() ? "" : "\n") + d.text();
    for (std::size_t at; (at = text.find(folder.path.string())) != std::string::npos;)
      text.replace(at, folder.path.string().size(), "@");
    return text;
  }
  std::string height_map(const std::string& rest) { return of("ground: {shape: height_map, " + rest + "}"); }
  std::string profile(const std::string& file) {
    return of("ground: {shape: profile, file: " + file + ", length_unit: m, height_unit: mm}");
  }
  ground_test::Folder folder;
};

TEST_F(Errors, UnknownShapeSuggestsTheNearest) {
  EXPECT_EQ(of("ground: {shape: sinusiod}"),
            "ground.yaml:1:17: ground.shape: 'sinusiod' is not one of: flat, slope, step, sinusoid, iso8608, "
            "height_map, profile; "
            "did you mean 'sinusoid'?");
  EXPECT_EQ(of("ground: {height: 1 m}"),
            "ground.yaml:1:1: missing key 'shape' in ground; for example 'shape: flat'; allowed are: flat, slope, "
            "step, sinusoid, iso8608, "
            "height_map, profile");
}

TEST_F(Errors, AShapeMustBeAMap) {
  EXPECT_EQ(of("ground: flat"),
            "ground.yaml:1:9: ground: a ground shape is a map such as {shape: flat}, or {include: file.yaml}");
  EXPECT_EQ(of("ground: []"),
            "ground.yaml:1:1: ground: the list of ground shapes is empty; for level ground write {shape: flat}");
}

TEST_F(Errors, NegativePeriodAndTypoInOneGo) {
  EXPECT_EQ(of("ground:\n  shape: sinusoid\n  amplitude: 10\n  period: -195 mm\n  phse: 1 deg\n"),
            "ground.yaml:3:14: ground.amplitude: '10' has no unit; a length is wanted, for example '10 mm'\n"
            "ground.yaml:4:11: ground.period: '-195 mm' is out of range; allowed is 0.001 mm to 1e+09 mm\n"
            "ground.yaml:5:3: unknown key 'phse' in ground; did you mean 'phase'?");
}

TEST_F(Errors, WavenumberMustSayRadOrCycle) {
  EXPECT_EQ(of("ground: {shape: sinusoid, amplitude: 10 mm, wavenumber: 32.2 1/m}"),
            "ground.yaml:1:57: ground.wavenumber: '32.2 1/m' is a curvature, but a spatial frequency is wanted, for "
            "example '1 rad/m'");
}

TEST_F(Errors, PeriodAndWavenumberExcludeEachOther) {
  EXPECT_EQ(of("ground: {shape: sinusoid, amplitude: 10 mm}"),
            "ground.yaml:1:1: ground: give 'period' (for example 195 mm) or 'wavenumber' (for example 32.2 rad/m)");
  EXPECT_EQ(of("ground: {shape: sinusoid, amplitude: 10 mm, period: 1 m, wavenumber: 3 rad/m}"),
            "ground.yaml:1:1: ground: 'period' and 'wavenumber' are both given; one of them says it all");
}

TEST_F(Errors, ASinusoidMayNotJump) {
  EXPECT_EQ(of("ground: {shape: sinusoid, amplitude: 10 mm, period: 1 m, start: 1 m, phase: 90 deg}"),
            "ground.yaml:1:1: ground: sinusoid: phase 90 deg makes a jump at the start; give run_in or a phase of 0 or "
            "180 deg");
  EXPECT_EQ(of("ground: {shape: sinusoid, amplitude: 10 mm, period: 1 m, start: 1 m, end: 0 m}"),
            "ground.yaml:1:75: ground.end: must lie beyond the start at 1 m");
}

TEST_F(Errors, EachItemOfAListIsNamed) {
  EXPECT_EQ(
      of("ground:\n  - shape: iso8608\n    class: I\n    track_width: 1 m\n  - 3\n  - {shape: slope, angle: 80 deg}\n"),
      "ground.yaml:3:12: ground[0].class: 'I' is not one of: A, B, C, D, E, F, G, H\n"
      "ground.yaml:5:5: ground[1]: a ground shape is a map such as {shape: flat}, or {include: file.yaml}\n"
      "ground.yaml:6:27: ground[2].angle: '80 deg' is out of range; allowed is -60 deg to 60 deg");
}

TEST_F(Errors, Iso8608SaysWhatBelongsTogether) {
  EXPECT_EQ(of("ground: {shape: iso8608, class: E, track_width: 1 m, decay: 2}"),
            "ground.yaml:1:61: ground.decay: belongs to 'coherence: exponential'");
  EXPECT_EQ(of("ground: {shape: iso8608, class: E, track_width: 1 m, period: 100 m}"),
            "ground.yaml:1:1: ground: iso8608: period must be at least 2/lowest = 181.818 m");
  EXPECT_EQ(of("ground: {shape: iso8608, track_width: 1 m}"),
            "ground.yaml:1:1: ground: give 'class' (A..H) or 'roughness' (Gd at 0.1 cycle/m, for example 4096e-6 m^3)");
}

TEST_F(Errors, MissingFileIsNamedWhereItWasLookedFor) {
  EXPECT_EQ(height_map("file: nope.png, spacing: 1 m, height_range: [0 m, 1 m]"),
            "ground.yaml:1:35: ground.file: file 'nope.png' not found; looked for @/nope.png");
}

TEST_F(Errors, HeightMapFormatMustBeClear) {
  folder.write("a.txt", "1,2\n3,4\n");
  EXPECT_EQ(height_map("file: a.txt"),
            "ground.yaml:1:35: ground.file: the format is not clear from 'a.txt'; add 'format: png', 'esri' or 'csv'");
  EXPECT_EQ(height_map("file: a.txt, format: csv, spacing: 1 m, height_unit: kg"),
            "ground.yaml:1:82: ground.height_unit: 'kg' is not one of: m, cm, mm, um, in, ft");
  EXPECT_EQ(height_map("file: a.txt, format: csv, spacing: 1 m"),
            "ground.yaml:1:1: missing key 'height_unit' in ground; for example 'height_unit: m'; allowed are: m, cm, "
            "mm, um, in, ft");
}

TEST_F(Errors, CsvCellsAndRaggedRowsAreNamed) {
  folder.write("bad.csv", "1,2,3\n4, nan,6\n7,8\n1,,3\n1,2,3,4\n");
  EXPECT_EQ(
      height_map("file: bad.csv, spacing: 1 m, height_unit: mm"),
      "@/bad.csv:2:4: row 2, column 2: 'nan' is not a finite number; fill it in from its neighbours, or cut the "
      "table there: heights are finite numbers\n"
      "@/bad.csv:3:3: row 3 has 2 cells where the first row has 3; separate cells by commas\n"
      "@/bad.csv:4:3: row 4, column 2: the cell is empty; fill it in from its neighbours, or cut the table there: "
      "heights are finite numbers\n"
      "@/bad.csv:5:7: row 5 has 4 cells where the first row has 3; separate cells by commas");
  folder.write("none.csv", "# nothing\n\n");
  EXPECT_EQ(height_map("file: none.csv, spacing: 1 m, height_unit: mm"),
            "@/none.csv:1:1: the file has no rows of numbers; one row per line, cells separated by commas");
}

TEST_F(Errors, ManyErrorsOfOneFileAreCounted) {
  std::string text = "1,2\n";
  for (int i = 0; i < 30; ++i) text += "x,2\n";
  folder.write("many.csv", text);
  const std::string all = height_map("file: many.csv, spacing: 1 m, height_unit: mm");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 20);
  EXPECT_NE(all.find("@/many.csv:21:1: and 10 more errors in this file"), std::string::npos) << all;
}

TEST_F(Errors, EsriHeaderAndNoDataCellsAreNamed) {
  const std::string place = "xllcorner 0\nyllcorner 0\ncellsize 1\n";
  folder.write("key.asc", "ncols 3\nnrow 2\n" + place + "1 2 3\n4 5 6\n");
  EXPECT_EQ(height_map("file: key.asc"),
            "@/key.asc:2:1: unknown header entry 'nrow'; did you mean 'nrows'? An ESRI ASCII grid has ncols, nrows, "
            "xllcorner, yllcorner, "
            "cellsize and optionally NODATA_value");
  folder.write("lacks.asc", "ncols 3\nnrows 2\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n");
  EXPECT_EQ(height_map("file: lacks.asc"), "@/lacks.asc:4:1: the header lacks 'xllcorner' (or 'xllcenter')");
  folder.write("hole.asc", "ncols 3\nnrows 2\n" + place + "NODATA_value -9999\n1 2 3\n4 -9999 6\n");
  EXPECT_EQ(height_map("file: hole.asc"),
            "@/hole.asc:8:3: row 2, column 2: the cell has no data (-9999); fill the grid before using it as ground");
  folder.write("few.asc", "ncols 3\nnrows 2\n" + place + "1 2 3\n4 5\n");
  EXPECT_EQ(height_map("file: few.asc"), "@/few.asc:7:3: the header says 2 x 3 = 6 cells, the file has 5");
  folder.write("size.asc", "ncols 2.5\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize -1\n1 2 3\n4 5 6\n");
  EXPECT_EQ(height_map("file: size.asc"),
            "@/size.asc:1:1: ncols must be a whole number within 2..100000, got 2.5\n@/size.asc:5:1: cellsize must be "
            "positive, got -1");
}

TEST_F(Errors, PngMustBeSixteenBitGreyAndWhole) {
  const std::string rest = ", spacing: 1 m, height_range: [0 m, 1 m]";
  folder.write("text.png", "hello, this is no PNG");
  EXPECT_EQ(height_map("file: text.png" + rest),
            "@/text.png: not a PNG file; export the height map as PNG, 16-bit grey, or name its 'format'");

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = image.height = 2;
  image.format = PNG_FORMAT_RGB;
  const png_byte pixels[12] = {};
  ASSERT_NE(png_image_write_to_file(&image, (folder.path / "rgb.png").c_str(), 0, pixels, 0, nullptr), 0);
  EXPECT_EQ(height_map("file: rgb.png" + rest),
            "@/rgb.png: the PNG is 8-bit RGB; a height map needs 16-bit grey: export it so");

  std::ifstream in(examples() / "data/crater_field.png", std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  folder.write("half.png", whole.substr(0, whole.size() / 2));
  EXPECT_EQ(height_map("file: half.png" + rest),
            "@/half.png: the PNG is cut off or damaged (Read Error); export it again, as 16-bit grey");
  EXPECT_EQ(height_map("file: half.png, spacing: 1 m, height_range: [1 m, 0 m]"),
            "ground.yaml:1:59: ground.height_range: the first height (black) must be below the second (white)");
}

TEST_F(Errors, GapInAProfileNamesItsLine) {
  folder.write("gap.csv", "u,z_v0\n0.0,1\n0.1,2\n0.2,2\n0.4,3\n0.5,4\n0.45,4\n0.47,4\n");
  EXPECT_EQ(
      profile("gap.csv"),
      "@/gap.csv:5:1: row 4: gap in the profile: the distance steps from 0.2 to 0.4 where the step is 0.1; fill the "
      "missing rows or "
      "split the file\n"
      "@/gap.csv:7:1: row 6: the distance along the road does not rise (0.5 to 0.45); sort the rows by it, and keep "
      "one row of each distance\n"
      "@/gap.csv:8:1: row 7: the distance steps from 0.45 to 0.47 where the step is 0.1; a profile needs equal steps");
  folder.write("cell.csv", "u,z_v0\n0.0,1\n0.1,\n");
  EXPECT_EQ(profile("cell.csv"),
            "@/cell.csv:3:5: row 2, column 2 ('z_v0'): the cell is empty; fill it in from its neighbours, or cut the "
            "table there: heights are "
            "finite numbers");
}

TEST_F(Errors, LinesOfAProfileNeedTheirPlaces) {
  folder.write("names.csv", "u,left,z_v0.5\n0,1,2\n1,2,3\n");
  EXPECT_EQ(profile("names.csv"),
            "@/names.csv:1:3: column 'left' does not end in v<metres to the left> such as v-1.30; rename it or give "
            "lateral_first and "
            "lateral_spacing");
  folder.write("uneven.csv", "u,z_v0,z_v1,z_v3\n0,1,2,3\n1,2,3,4\n");
  EXPECT_EQ(profile("uneven.csv"),
            "@/uneven.csv:1:8: the lines must be equally spaced across: 'z_v1' is 1 m from its neighbour, the mean "
            "spacing is 1.5 m\n"
            "@/uneven.csv:1:13: the lines must be equally spaced across: 'z_v3' is 2 m from its neighbour, the mean "
            "spacing is 1.5 m");
  folder.write("bare.csv", "0,1\n1,2\n2,3\n");
  EXPECT_EQ(profile("bare.csv"),
            "@/bare.csv:1:1: a header row with one name per column is expected before the numbers");
}

TEST_F(Errors, SeamBelongsToRepeat) {
  folder.write("p.csv", "u,z_v0\n0,1\n1,2\n2,3\n");
  const std::string rest = "ground: {shape: profile, file: p.csv, length_unit: m, height_unit: mm, ";
  EXPECT_EQ(of(rest + "outside: repeat}"), "ground.yaml:1:1: missing key 'seam' in ground; for example 'seam: 1 m'");
  EXPECT_EQ(of(rest + "outside: repeat, seam: 5 m}"),
            "ground.yaml:1:1: ground: p.csv: outside: repeat needs a seam of 1..1 m for a ground without a jump");
  EXPECT_EQ(of(rest + "seam: 1 m}"), "ground.yaml:1:78: ground.seam: belongs to 'outside: repeat'");
}

TEST_F(Errors, OfIncludedFilesNameThem) {
  folder.write("inner.yaml", "ground: {shape: flat, hight: 1 m}\n");
  folder.write("self.yaml", "ground: {include: self.yaml}\n");
  folder.write("other.yaml", "soil: sand\n");
  EXPECT_EQ(of("ground: [{include: inner.yaml}, {include: missing}]"),
            "@/inner.yaml:1:23: unknown key 'hight' in ground; did you mean 'height'?\n"
            "ground.yaml:1:43: ground[1].include: file 'missing' not found; looked for @/missing");
  EXPECT_EQ(of("ground: {include: self.yaml}"),
            "@/self.yaml:1:19: ground.include: grounds include each other more than 8 deep");
  EXPECT_EQ(of("ground: {include: other.yaml}"),
            "@/other.yaml:1:1: a ground file needs 'ground:' with a shape or a list of shapes\n"
            "@/other.yaml:1:1: unknown key 'soil'; known here: ground, source");
}

GroundPtr loaded(const std::string& text, std::uint64_t seed = 1) {
  const ConfigDocument doc = ConfigDocument::from_text(text, "ground.yaml", examples());
  const GroundPtr g = load_ground(doc.root().node("ground"), seed);
  doc.check();
  return g;
}

TEST(LoadGround, AListAddsUpAndIncludesResolveAgainstTheirOwnFile) {
  const GroundPtr sum =
      loaded("ground: [{include: crater_field_esri.yaml}, {shape: flat, height: 0.5 m}, {include: slope.yaml}]");
  const GroundPtr crater = load_ground_file(examples() / "crater_field_esri.yaml", 1),
                  slope = load_ground_file(examples() / "slope.yaml", 1);
  for (double x = 0; x < 8; x += 0.31)
    EXPECT_DOUBLE_EQ(sum->height(x, -1), crater->height(x, -1) + 0.5 + slope->height(x, -1));
}

TEST(LoadGround, ScenarioSeedServesRandomShapesWithoutTheirOwn) {
  const std::string road = "{shape: iso8608, class: C, track_width: 1 m";
  const GroundPtr one = loaded("ground: " + road + "}", 5), same = loaded("ground: " + road + "}", 5),
                  own = loaded("ground: " + road + ", seed: 5}", 9), other = loaded("ground: " + road + "}", 6);
  EXPECT_EQ(one->height(3.1, 0.2), same->height(3.1, 0.2));
  EXPECT_EQ(one->height(3.1, 0.2), own->height(3.1, 0.2));
  EXPECT_NE(one->height(3.1, 0.2), other->height(3.1, 0.2));
  // Two roads of one list are two roads, not one twice.
  const GroundPtr two = loaded("ground: [" + road + "}, " + road + "}]", 5);
  EXPECT_GT(std::abs(two->height(3.1, 0.2) - 2 * one->height(3.1, 0.2)), 1e-4);
}

TEST(LoadGround, AnAbsentNodeIsLevelGround) { EXPECT_EQ(load_ground(ConfigNode(), 1)->height(3, 4), 0); }

TEST(LoadGround, Iso8608BandIsInCyclesPerMetre) {
  // 0.1 cycles/m = 0.628 rad/m: one harmonic, which returns after 10 m and is opposite after 5 m.
  const GroundPtr g = loaded(
      "ground: {shape: iso8608, class: E, track_width: 1 m, period: 100 m, lowest: 0.0999 cycles/m, highest: 0.6289 "
      "rad/m}");
  EXPECT_NEAR(g->height(11.3, 0.5), g->height(1.3, 0.5), 1e-8);
  EXPECT_NEAR(g->height(6.3, 0.5), -g->height(1.3, 0.5), 1e-8);
}

class Shipped : public testing::TestWithParam<std::string> {};

std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const auto& e : std::filesystem::directory_iterator(examples()))
    if (e.path().extension() == ".yaml") names.push_back(e.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST_P(Shipped, LoadsAndALineEqualsItsPointsBitByBit) {
  const GroundPtr g = load_ground_file(examples() / (GetParam() + ".yaml"), 1);
  EXPECT_FALSE(g->describe().empty());
  EXPECT_GT(g->resolution(), 0);
  std::vector<double> z(700);
  for (int k = 0; k < 20; ++k) {
    const double x0 = -2 + 0.77 * k, y0 = -1.7 + 0.19 * k, dx = 0.0113 - 0.002 * k, dy = 0.003 * (k % 5);
    g->heights(x0, y0, dx, dy, 700, z.data());
    for (int i = 0; i < 700; ++i)
      ASSERT_EQ(z[static_cast<std::size_t>(i)], g->height(x0 + i * dx, y0 + i * dy)) << k << " " << i;
  }
}

TEST_P(Shipped, HasNoJump) {
  const GroundPtr g = load_ground_file(examples() / (GetParam() + ".yaml"), 1);
  double before = g->height(-1, 0.13);
  // 0.1 mm apart; the steepest thing shipped is a kerb's ramp of 5:1, and blocks of 3:1 in the cross-fade.
  for (double x = -1; x < 25; x += 1e-4) {
    const double h = g->height(x, 0.13);
    ASSERT_LT(std::abs(h - before), 6e-4) << x;
    before = h;
  }
}

INSTANTIATE_TEST_SUITE_P(Grounds, Shipped, testing::ValuesIn(shipped_names()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace grouser
