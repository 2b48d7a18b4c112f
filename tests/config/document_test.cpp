// Every class of error with its whole message, line and column.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config_support.h"
#include "grouser/terrain/types.h"

namespace grouser {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::messages;

const auto nothing = [](const ConfigNode&) {};

auto reads(const char* unit, Range range = Range::any()) {
  return [=](const ConfigNode& r) { r.map("shear").quantity("cohesion", unit, range); };
}

TEST(Config, BareNumberWhereAUnitIsDue) {
  EXPECT_THAT(
      messages("shear:\n  cohesion: 1040\n", reads("kPa")),
      ElementsAre("f.yaml:2:13: shear.cohesion: '1040' has no unit; a pressure is wanted, for example '1040 kPa'"));
}

TEST(Config, WrongDimension) {
  EXPECT_THAT(
      messages("shear:\n  cohesion: 1 m\n", reads("kPa")),
      ElementsAre("f.yaml:2:13: shear.cohesion: '1 m' is a length, but a pressure is wanted, for example '1 kPa'"));
}

TEST(Config, UnitWhereNoneIsDue) {
  EXPECT_THAT(
      messages("shear: {cohesion: 1 m}\n", reads("1")),
      ElementsAre(
          "f.yaml:1:19: shear.cohesion: '1 m' is a length, but a number without unit is wanted, for example '1'"));
}

TEST(Config, UnknownUnit) {
  EXPECT_THAT(messages("shear:\n  cohesion: 1 kPaa\n", reads("kPa")),
              ElementsAre("f.yaml:2:13: shear.cohesion: '1 kPaa': unknown unit 'kPaa'; did you mean 'kPa'?"));
}

TEST(Config, NotANumber) {
  EXPECT_THAT(messages("shear:\n  cohesion: high\n", reads("kPa")),
              ElementsAre("f.yaml:2:13: shear.cohesion: 'high' is not a number with a unit; for example '1 kPa'"));
}

TEST(Config, DecimalComma) {
  EXPECT_THAT(messages("shear:\n  cohesion: 1,04 kPa\n", reads("kPa")),
              ElementsAre("f.yaml:2:13: shear.cohesion: '1,04 kPa': write the decimal sign as a point"));
}

TEST(Config, NaNAndInfinityAreRefused) {
  for (const std::string bad : {"nan kPa", ".nan", ".inf", "-inf kPa", "1e999 kPa", "NaN"})
    EXPECT_THAT(messages("shear:\n  cohesion: " + bad + "\n", reads("kPa")),
                ElementsAre("f.yaml:2:13: shear.cohesion: '" + bad + "' is not a finite number; for example '1 kPa'"));
  EXPECT_THAT(messages("shear:\n  cohesion: 1e306 kPa\n", reads("kPa")),
              ElementsAre("f.yaml:2:13: shear.cohesion: '1e306 kPa' is not a finite number in SI units"));
}

TEST(Config, RangeIsStatedInTheUnitOfTheFile) {
  EXPECT_THAT(messages("shear:\n  cohesion: -25 mm\n", reads("m", Range::positive())),
              ElementsAre("f.yaml:2:13: shear.cohesion: '-25 mm' is out of range; allowed is more than 0 mm"));
  EXPECT_THAT(
      messages("shear:\n  cohesion: 400 deg\n", reads("rad", {0, pi / 2, false, true})),
      ElementsAre(
          "f.yaml:2:13: shear.cohesion: '400 deg' is out of range; allowed is at least 0 deg and less than 90 deg"));
  EXPECT_THAT(messages("shear:\n  cohesion: 120 %\n", reads("1", Range::between(0, 1))),
              ElementsAre("f.yaml:2:13: shear.cohesion: '120 %' is out of range; allowed is 0 % to 100 %"));
}

TEST(Config, MissingKeyIsReportedAtItsMapWithAnExample) {
  EXPECT_THAT(messages("name: x\nshear:\n  K: 1 mm\n", reads("kPa")),
              ElementsAre("f.yaml:2:1: missing key 'cohesion' in shear; for example 'cohesion: 1 kPa'"));
  EXPECT_THAT(messages("name: x\n", [](const ConfigNode& r) { r.map("shear"); }),
              ElementsAre("f.yaml:1:1: missing key 'shear'; for example 'shear: {...}'"));
  EXPECT_THAT(messages("name: x\n",
                       [](const ConfigNode& r) {
                         r.choice("type", {"A", "B"});
                       }),
              ElementsAre("f.yaml:1:1: missing key 'type'; for example 'type: A'; allowed are: A, B"));
}

TEST(Config, UnknownKeySuggestsTheNearest) {
  const auto read = [](const ConfigNode& r) {
    const ConfigNode s = r.map("shear");
    s.quantity_or("cohesion", 0, "kPa");
    s.quantity_or("K", 0, "mm");
    s.finish();
    r.finish();
  };
  EXPECT_THAT(messages("shear:\n  K: 1 mm\n  cohesoin: 1 kPa\nzzzzzz: 1\n", read),
              ElementsAre("f.yaml:3:3: unknown key 'cohesoin' in shear; did you mean 'cohesion'?",
                          "f.yaml:4:1: unknown key 'zzzzzz'; known here: shear"));
}

TEST(Config, MisspeltRequiredKeyIsOneError) {
  const auto read = [](const ConfigNode& r) {
    r.map("shear").quantity("cohesion", "kPa");
    r.map("shear").finish();
  };
  EXPECT_THAT(messages("shear:\n  cohesoin: 1 kPa\n", read),
              ElementsAre("f.yaml:2:3: unknown key 'cohesoin' in shear; did you mean 'cohesion'?"));
}

TEST(Config, DuplicateKeysAreFoundAtAnyDepth) {
  EXPECT_THAT(messages("a: 1\nb:\n  - {c: 1, c: 2}\na: 2\n", nothing),
              ElementsAre("f.yaml:3:12: duplicate key 'c' in b[0]; first given in line 3, remove one of the two",
                          "f.yaml:4:1: duplicate key 'a'; first given in line 1, remove one of the two"));
}

TEST(Config, SyntaxErrorHasItsPlace) {
  EXPECT_THAT(messages("a: 1\nb: [1, 2\nc: 3\n", nothing),
              ElementsAre("f.yaml:2:4: not valid YAML: the '[' that opens here is not closed, or a comma is missing "
                          "between two of its entries"));
}

TEST(Config, SyntaxErrorIsBlamedOnTheLineWhereItWasMade) {
  // Each text is wrong in its second line only; yaml-cpp gives up a line later or not at all.
  for (const char* text :
       {"a: 1\nb 2\nc: 3\n", "a: 1\n# note\nb 2 # with a: colon in the note\n\nc: 3\n", "a: 1\nb:2\nc: 3\n",
        "a: 1\nb\n  d: 2\nc: 3\n", "a: 1\n'b: 2\nc: 3\n", "a: 1\nb: \"2\nc: 3\n", "a: 1\nb 2\n",
        "a: 1\nb: {c: 1, d 2}\n", "a: 1\nb: {c: 1 d: 2}\n", "a: 1\nb: 2: 3\nc: 4\n"}) {
    const auto found = messages(text, nothing);
    ASSERT_EQ(found.size(), 1u) << text;
    const std::string second = std::string(text).find('#') == 5 ? "f.yaml:3:" : "f.yaml:2:";
    EXPECT_THAT(found[0], ::testing::StartsWith(second)) << text;
    EXPECT_THAT(found[0], ::testing::HasSubstr("not valid YAML: ")) << text;
  }
}

TEST(Config, WhatYamlAllowsIsNoSyntaxError) {
  for (const char* text : {"a: it's a word with an apostrophe\nb: 1\n",
                           "a: \"he said \\\"x\\\" # no note\"\nb: 'it''s'\n", "a: a text over\n  two lines\nb: 1\n",
                           "a: |\n  block with no colon\n  b 2\nc: 1\n", "a: http://x.org/y\nb: 1\n",
                           "a: [1,\n  2]\nb: {c: 1,\n  d: 2}\n", "front left: 1\n", "- a b\n- c d\n", "a:\nb: 1\n"})
    EXPECT_THAT(messages(text, nothing), ElementsAre()) << text;
}

TEST(Config, TabIndentIsExplained) {
  const auto found = messages("a:\n\tb: 1\n", [](const ConfigNode& r) { r.map("a").quantity("b", "1"); });
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0], ::testing::StartsWith("f.yaml:2:"));
  EXPECT_THAT(found[0], ::testing::HasSubstr("this line is indented with a tab: use spaces"));
}

TEST(Config, SecondDocumentIsRefused) {
  EXPECT_THAT(messages("a: 1\n---\nb: 1\n", nothing),
              ElementsAre("f.yaml:3:1: a second YAML document starts here; one file holds one document"));
}

TEST(Config, MissingFileFolderAndEmptyFile) {
  const auto folder = std::filesystem::temp_directory_path() / "grouser_config_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "empty.yaml") << "# nothing\n";
  const auto of = [](const std::filesystem::path& p) -> std::string {
    try {
      const ConfigDocument d = ConfigDocument::from_file(p);
      d.root().quantity("x", "m");
      d.check();
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(of(folder / "no.yaml"), (folder / "no.yaml").string() + ": the file does not exist");
  EXPECT_EQ(of(folder), folder.string() + ": this is a folder; a YAML file is wanted");
  EXPECT_EQ(of(folder / "empty.yaml"),
            (folder / "empty.yaml").string() + ":1:1: the file is empty; 'key: value' lines are wanted");
  std::filesystem::remove_all(folder);
}

TEST(Config, WrongKinds) {
  const auto read = [](const ConfigNode& r) {
    r.map("a").quantity("x", "m");
    r.list("b");
    r.quantity("c", "m");
    r.quantity("d", "m");
    r.list("e");
    r.text("f");
  };
  EXPECT_THAT(
      messages("a: 3\nb: 3\nc: [1 m]\nd:\ne: []\nf: {}\n", read),
      ElementsAre(
          "f.yaml:1:4: a: a map with 'key: value' lines is wanted here",
          "f.yaml:2:4: b: a list is wanted here: one '- ...' line per item",
          "f.yaml:3:1: c: a single value is wanted, not a list", "f.yaml:4:1: d: a value is missing after the ':'",
          "f.yaml:5:1: e: the list is empty; at least one item is wanted",
          "f.yaml:6:1: f: a single value is wanted, or {value: ..., source: ...}, or {assumed: ..., why: ...}"));
}

TEST(Config, TopLevelMustBeAMap) {
  EXPECT_THAT(messages("- a\n- b\n",
                       [](const ConfigNode& r) {
                         r.quantity("x", "m");
                         r.text("y");
                         r.finish();
                       }),
              ElementsAre("f.yaml:1:1: a map with 'key: value' lines is wanted here"));
}

TEST(Config, IntegerChoiceBoolean) {
  const auto read = [](const ConfigNode& r) {
    r.integer("a", 1, 8);
    r.integer("b", 1, 8);
    r.choice("c", {"smooth", "lugged"});
    r.boolean_or("d", true);
    r.integer("e", 1, 8);
  };
  EXPECT_THAT(messages("a: 2.5\nb: 9\nc: smoth\nd: maybe\n", read),
              ElementsAre("f.yaml:1:1: missing key 'e'; for example 'e: 1'",
                          "f.yaml:1:4: a: '2.5' is not a whole number; allowed is 1 to 8",
                          "f.yaml:2:4: b: '9' is out of range; allowed is 1 to 8",
                          "f.yaml:3:4: c: 'smoth' is not one of: smooth, lugged; did you mean 'smooth'?",
                          "f.yaml:4:4: d: 'maybe' is not one of: true, false"));
}

TEST(Config, MissingFileNamesTheNeighbour) {
  const auto folder = std::filesystem::temp_directory_path() / "grouser_config_files";
  std::filesystem::create_directories(folder / "sub");
  std::ofstream(folder / "wheel.obj") << "v 0 0 0\n";
  EXPECT_THAT(messages(
                  "f: whel.obj\ng: sub\nh: wheel.obj\n",
                  [](const ConfigNode& r) {
                    for (const char* k : {"f", "g", "h"}) r.existing_file(k);
                  },
                  "f.yaml", folder.string()),
              ElementsAre("f.yaml:1:4: f: file 'whel.obj' not found; looked for " + (folder / "whel.obj").string() +
                              "; did you mean 'wheel.obj'?",
                          "f.yaml:2:4: g: 'sub' is a folder; a file is wanted"));
  std::filesystem::remove_all(folder);
}

TEST(Config, SourcedAndAssumedValues) {
  const ConfigDocument d = ConfigDocument::from_text(
      "a: {value: 1 kPa, source: book}\nb: {assumed: 2 kPa, why: typical}\nc:\n  assumed: [1 m, 2 m]\n  why: guess\n",
      "f.yaml");
  const ConfigNode r = d.root();
  EXPECT_DOUBLE_EQ(r.quantity("a", "kPa"), 1000);
  EXPECT_DOUBLE_EQ(r.quantity("b", "kPa"), 2000);
  EXPECT_THAT(r.quantities("c", "m"), ElementsAre(1, 2));
  r.finish();
  d.check();
  ASSERT_EQ(d.assumptions().size(), 2U);
  EXPECT_EQ(d.assumptions()[0].file, "f.yaml");
  EXPECT_EQ(d.assumptions()[0].key, "b");
  EXPECT_EQ(d.assumptions()[0].value, "2 kPa");
  EXPECT_EQ(d.assumptions()[0].why, "typical");
  EXPECT_EQ(d.assumptions()[1].value, "[1 m, 2 m]");
}

TEST(Config, AssumedValueNeedsItsReason) {
  const auto read = [](const ConfigNode& r) {
    for (const char* k : {"a", "b", "c", "d"}) r.quantity(k, "kPa");
  };
  EXPECT_THAT(messages("a: {assumed: 1 kPa}\nb: {value: 1 kPa, assumed: 2 kPa}\nc: {value: 1 kPa, sorce: x}\nd: "
                       "{value: 7, source: x}\n",
                       read),
              ElementsAre("f.yaml:1:1: a: 'assumed' needs 'why: text' next to it",
                          "f.yaml:2:1: b: both 'value' and 'assumed' are given; a value is the one or the other",
                          "f.yaml:3:19: unknown key 'sorce' in c; did you mean 'source'?",
                          "f.yaml:4:12: d: '7' has no unit; a pressure is wanted, for example '7 kPa'"));
}

TEST(Config, ListsOfQuantities) {
  const ConfigDocument d = ConfigDocument::from_text("a: [1 m, 20 mm]\nb: 1, 2, 3 mm\ne: 5 m\n", "f.yaml");
  const ConfigNode r = d.root();
  EXPECT_THAT(r.quantities("a", "m", 2), ElementsAre(1, 0.02));
  EXPECT_THAT(r.quantities("b", "m"), ElementsAre(1e-3, 2e-3, 3e-3));
  EXPECT_THAT(r.quantities("e", "m"), ElementsAre(5));
  d.check();
}

TEST(Config, AUnitInAListBelongsToItsOwnItem) {
  const ConfigDocument d = ConfigDocument::from_text(
      "a: [0.1, 0.3, 50 %]\nb: [-0.3, 0, 30%]\nc: [20 %, 0.1]\nd: 10 %, 20 %\ne: 0.1, 0.2\n", "f.yaml");
  const ConfigNode r = d.root();
  EXPECT_THAT(r.quantities("a", "1"), ElementsAre(0.1, 0.3, 0.5));
  EXPECT_THAT(r.quantities("b", "1"), ElementsAre(-0.3, 0, 0.3));
  EXPECT_THAT(r.quantities("c", "1"), ElementsAre(0.2, 0.1));
  EXPECT_THAT(r.quantities("d", "1"), ElementsAre(0.1, 0.2));
  EXPECT_THAT(r.quantities("e", "1"), ElementsAre(0.1, 0.2));
  d.check();
}

TEST(Config, AListItemWithoutTheUnitThatItNeedsIsNamed) {
  const auto read = [](const ConfigNode& r) {
    r.quantities("a", "m", 3);
    r.quantities("b", "1");
  };
  EXPECT_THAT(messages("a: [1, 2, 3 cm]\nb: 0.1, 0.3, 50 %\n", read),
              ElementsAre("f.yaml:1:5: a[0]: '1' has no unit; a length is wanted, for example '1 m'",
                          "f.yaml:1:8: a[1]: '2' has no unit; a length is wanted, for example '2 m'",
                          "f.yaml:2:4: b: '0.1, 0.3, 50 %': is '%' the unit of the last number or of all? Write it at "
                          "every number that has it, in a list such as [0.1, 30 %]"));
}

TEST(Config, BadListsOfQuantities) {
  const auto read = [](const ConfigNode& r) {
    r.quantities("a", "m", 3);
    r.quantities("b", "m");
    r.quantities("c", "m", 2, Range::positive());
    r.quantities("d", "m", 2);
  };
  EXPECT_THAT(
      messages("a: [1 m, 2 m]\nb: [1, 2]\nc: [1 mm, -2 mm]\n", read),
      ElementsAre("f.yaml:1:1: a: 2 values given, 3 wanted", "f.yaml:1:1: missing key 'd'; for example 'd: [1 m, 1 m]'",
                  "f.yaml:2:5: b[0]: '1' has no unit; a length is wanted, for example '1 m'",
                  "f.yaml:2:8: b[1]: '2' has no unit; a length is wanted, for example '2 m'",
                  "f.yaml:3:11: c[1]: '-2 mm' is out of range; allowed is more than 0 mm"));
}

TEST(Config, AbsentNodesAreSafeAndSilent) {
  EXPECT_THAT(messages("a: 1\n",
                       [](const ConfigNode& r) {
                         const ConfigNode n = r.optional_map("gone").map("deeper");
                         EXPECT_FALSE(n.present());
                         EXPECT_TRUE(n.list("x").empty());
                         EXPECT_TRUE(n.items().empty());
                         EXPECT_TRUE(n.keys().empty());
                         EXPECT_EQ(n.text_or("x", "y"), "y");
                         EXPECT_EQ(n.quantity_or("x", 5, "m"), 5);
                         EXPECT_GT(n.quantity("x", "m", Range::positive()), 0);
                         EXPECT_EQ(n.integer("x", 3, 4), 3);
                         EXPECT_EQ(n.choice("x", {"p", "q"}), "p");
                         EXPECT_EQ(n.quantities("x", "m", 3).size(), 3U);
                         EXPECT_TRUE(n.existing_file("x").empty());
                         EXPECT_EQ(n.as_text(), "");
                         n.as_quantity("m");
                         n.finish();
                         n.error("lost");
                         n.error_at("x", "lost");
                         EXPECT_EQ(n.line(), 0);
                         EXPECT_EQ(n.file(), "");
                       }),
              IsEmpty());
}

TEST(Config, AnchorsAliasesAndMergeKeysDoNotCrash) {
  EXPECT_THAT(messages("a: &x {k: 1 m}\nb: *x\n",
                       [](const ConfigNode& r) {
                         EXPECT_EQ(r.map("a").quantity("k", "m"), 1);
                         EXPECT_EQ(r.map("b").quantity("k", "m"), 1);
                       }),
              IsEmpty());
  EXPECT_THAT(messages("a: &x {k: 1 m}\nb: {<<: *x}\n",
                       [](const ConfigNode& r) {
                         r.node("a");
                         r.map("b").finish();
                       }),
              ElementsAre("f.yaml:2:5: unknown key '<<' in b; no keys are known here"));
  // Ten levels of ten aliases each, and a list that holds itself: refused, not unrolled.
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string p = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + p;
    for (int k = 1; k < 10; ++k) bomb += ", " + p;
    bomb += "]\n";
  }
  EXPECT_THAT(messages(bomb, nothing), ElementsAre(::testing::HasSubstr(
                                           "more than a million entries once the aliases ('*name') are written out; no "
                                           "file here needs so many: write the values in place of the aliases")));
  EXPECT_LE(messages("a: &a [*a]\n", nothing).size(), 1U);
}

TEST(Config, AllErrorsOfAFileComeSortedInOneGo) {
  const std::string text =
      "soil: test\n"
      "bekker:\n"
      "  pressure:\n"
      "    n: nan\n"
      "    kc: 12\n"
      "    n: 1.1\n"
      "  shear:\n"
      "    K: -25 mm\n"
      "    phi: 30 m\n"
      "    cohesoin: 1 kPa\n"
      "    type: D\n";
  const auto read = [](const ConfigNode& r) {
    // In another order than the file has.
    const ConfigNode s = r.map("bekker").map("shear");
    s.choice("type", {"A", "B", "C"});
    s.quantity("phi", "deg");
    s.quantity("K", "mm", Range::positive());
    s.quantity_or("cohesion", 0, "kPa");
    s.finish();
    const ConfigNode p = r.map("bekker").map("pressure");
    p.quantity("kc", "kN");
    p.quantity("n", "1");
  };
  EXPECT_THAT(
      messages(text, read),
      ElementsAre("f.yaml:4:8: bekker.pressure.n: 'nan' is not a finite number; for example '1'",
                  "f.yaml:5:9: bekker.pressure.kc: '12' has no unit; a force is wanted, for example '12 kN'",
                  "f.yaml:6:5: duplicate key 'n' in bekker.pressure; first given in line 4, remove one of the two",
                  "f.yaml:8:8: bekker.shear.K: '-25 mm' is out of range; allowed is more than 0 mm",
                  "f.yaml:9:10: bekker.shear.phi: '30 m' is a length, but an angle is wanted, for example '1 deg'",
                  "f.yaml:10:5: unknown key 'cohesoin' in bekker.shear; did you mean 'cohesion'?",
                  "f.yaml:11:11: bekker.shear.type: 'D' is not one of: A, B, C"));
}

TEST(Config, ErrorTextHasOneLinePerError) {
  const ConfigError e({{"a.yaml", 1, 2, "x"}, {"b.h5", 0, 0, "y"}});
  EXPECT_STREQ(e.what(), "a.yaml:1:2: x\nb.h5: y");
  EXPECT_EQ(ConfigError("c.yaml", 3, 4, "z").diagnostics()[0].text(), "c.yaml:3:4: z");
}

TEST(Config, AbsorbedFilesReportTogether) {
  const ConfigDocument a = ConfigDocument::from_text("x: 1\n", "b.yaml"),
                       b = ConfigDocument::from_text("y: {assumed: 1 m, why: w}\nz: 2\n", "a.yaml");
  a.root().quantity("x", "m");
  b.root().quantity("y", "m");
  b.root().quantity("z", "m");
  a.absorb(b);
  a.absorb(b);  // twice the same file is the same errors
  EXPECT_EQ(a.assumptions().size(), 1U);
  try {
    a.check();
    FAIL();
  } catch (const ConfigError& e) {
    ASSERT_EQ(e.diagnostics().size(), 2U);
    EXPECT_EQ(e.diagnostics()[0].file, "a.yaml");
  }
}

TEST(Config, Suggestions) {
  const std::vector<std::string> known{"cohesion", "friction_angle", "K", "Kw"};
  EXPECT_EQ(did_you_mean("cohesoin", known), "cohesion");
  EXPECT_EQ(did_you_mean("Cohesion", known), "cohesion");
  EXPECT_EQ(did_you_mean("friction_angel", known), "friction_angle");
  EXPECT_EQ(did_you_mean("k", known), "K");
  EXPECT_EQ(did_you_mean("modulus", known), std::nullopt);
  EXPECT_EQ(did_you_mean("", known), std::nullopt);
}

}  // namespace
}  // namespace grouser
