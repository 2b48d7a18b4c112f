// What is no text is refused by its name, and nothing that a terminal would obey gets into a message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"

namespace grouser {
namespace {

/// The one diagnostic of reading `bytes` as a table.
std::string csv_error(const std::string& bytes) {
  const auto file = std::filesystem::temp_directory_path() / ("grouser-text-test-" + std::to_string(getpid()) + ".csv");
  std::ofstream(file, std::ios::binary) << bytes;
  std::string what;
  try {
    CsvFile::read(file);
  } catch (const ConfigError& e) {
    what = e.what();
    what.erase(0, file.string().size());
  }
  std::filesystem::remove(file);
  return what;
}

TEST(Printable, KeepsTextOfAnyLanguageAndShowsTheRestAsNumbers) {
  EXPECT_EQ(printable("plain"), "plain");
  EXPECT_EQ(printable("Größe 45° \u03b8 \U0001F600"), "Größe 45° \u03b8 \U0001F600");
  EXPECT_EQ(printable("\x1b[31mred\a"), "\\x1b[31mred\\x07");
  EXPECT_EQ(printable("two\nlines\tand\rmore"), "two\\nlines\\tand\\rmore");
  EXPECT_EQ(printable("\u200b\u202e\ufeff"), "\\u200b\\u202e\\ufeff") << "no width, or other direction";
  EXPECT_EQ(printable("\xff\xc3(\xed\xa0\x80"), "\\xff\\xc3(\\xed\\xa0\\x80")
      << "no UTF-8, half a character, a surrogate";
}

TEST(Printable, AMessageOfAThousandCharactersKeepsItsEnd) {
  const Diagnostic d{"a.yaml", 1, 2, "'" + std::string(100000, 'x') + "' is wrong; write y"};
  EXPECT_LT(d.text().size(), 1500u);
  EXPECT_THAT(d.text(), testing::EndsWith("' is wrong; write y"));
  EXPECT_THAT(d.text(), testing::StartsWith("a.yaml:1:2: 'xxx"));
}

TEST(Tables, OfAnotherSeparatorAreToldSo) {
  EXPECT_EQ(csv_error("# note; with a semicolon\nx_m;z_mm\n0,5;1\n"),
            ":2:4: the cells are separated by ';'; separate them by commas, and write the decimal sign as a point");
  EXPECT_EQ(csv_error("x_m\tz_mm\n"),
            ":1:4: the cells are separated by tabs; separate them by commas, and write the decimal sign as a point");
  EXPECT_EQ(csv_error("\"a;b\",c\n1,2\n"), "") << "a semicolon in a quoted name separates nothing";
  EXPECT_EQ(csv_error("a,\tb\n1,\t2\n"), "") << "a tab behind a comma is a blank";
}

TEST(Tables, ThatAreNoTextAreCalledByTheirName) {
  EXPECT_EQ(csv_error("\x89PNG\r\n\x1a\n"), ":1:1: this is a PNG picture; a text file is wanted");
  EXPECT_EQ(csv_error("PK\x03\x04sheet"), ":1:1: this is a ZIP archive or office document; a text file is wanted");
  EXPECT_EQ(csv_error(std::string("a,b\n1,\0", 7)),
            ":2:3: byte \\x00 is no text; a text file is wanted, which is text in UTF-8");
  EXPECT_EQ(csv_error("winkel_\xb0,b\n1,2\n"), "") << "names of columns may be in Latin-1";
}

TEST(Yaml, WithAByteOrderMarkAndWindowsLineEndsIsReadWithItsPlaces) {
  const ConfigDocument d = ConfigDocument::from_text("\xEF\xBB\xBFsoil: \"a\"\r\nsource: 'b'\r\nx: 1 m\r\n", "t.yaml");
  EXPECT_EQ(d.root().text("soil"), "a");
  EXPECT_EQ(d.root().text("source"), "b");
  d.root().quantity("x", "kg");
  ASSERT_EQ(d.diagnostics().size(), 1u);
  EXPECT_THAT(d.diagnostics()[0].text(), testing::StartsWith("t.yaml:3:4: x: '1 m' is a length"));
}

TEST(Quantities, OfAbsurdMagnitudeAreRefusedWithTheirPlace) {
  const ConfigDocument d = ConfigDocument::from_text("a: 1e30 kPa\nb: 1e-300 m\nc: 0 m\nd: 1e17 m\n", "t.yaml");
  for (const char* key : {"a"}) d.root().quantity(key, "Pa");
  for (const char* key : {"b", "c", "d"}) d.root().quantity(key, "m");
  ASSERT_EQ(d.diagnostics().size(), 2u);
  EXPECT_EQ(
      d.diagnostics()[0].text(),
      "t.yaml:1:4: a: '1e30 kPa' is too large to be meant: allowed in SI units is 0, or 1e-100 to 1e18; check the "
      "exponent and the unit");
  EXPECT_EQ(
      d.diagnostics()[1].text(),
      "t.yaml:2:4: b: '1e-300 m' is too small to be meant: allowed in SI units is 0, or 1e-100 to 1e18; check the "
      "exponent and the unit");
}

}  // namespace
}  // namespace grouser
