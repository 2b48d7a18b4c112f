// Tables read row by row: what comes out, and that nothing is said otherwise than where the whole file is held.
#include "grouser/terrain/csv_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace grouser {
namespace {

using testing::ElementsAre;

class StreamedTable : public testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("grouser-csv-stream-test-" + std::to_string(getpid()) + ".csv");
  }
  void TearDown() override { std::filesystem::remove(file_); }
  void write(const std::string& bytes) const { std::ofstream(file_, std::ios::binary) << bytes; }

  /// "LINE:cell|cell" per row, then the errors without the file's name.
  struct Content {
    std::vector<std::string> columns, rows, errors;
  };
  static std::string text(const CsvRecords::Row& r) {
    std::string t = std::to_string(r.line);
    for (const CsvCell& c : r.cells) t += '|' + c.text + '@' + std::to_string(c.column);
    return t;
  }
  std::vector<std::string> told(const FileErrors& errors) const {
    std::vector<std::string> out;
    try {
      errors.check();
    } catch (const ConfigError& e) {
      for (const Diagnostic& d : e.diagnostics())
        out.push_back(std::to_string(d.line) + ":" + std::to_string(d.column) + ": " + d.message);
    }
    return out;
  }
  Content streamed() const {
    FileErrors errors(file_);
    CsvStream csv(file_, errors);
    Content c{csv.columns(), {}, {}};
    for (CsvRecords::Row r; csv.next(r);) c.rows.push_back(text(r));
    c.errors = told(errors);
    return c;
  }
  Content held() const {
    FileErrors errors(file_);
    const CsvRecords csv = CsvRecords::read(file_, errors);
    Content c{csv.columns, {}, {}};
    for (const CsvRecords::Row& r : csv.rows) c.rows.push_back(text(r));
    c.errors = told(errors);
    return c;
  }
  std::filesystem::path file_;
};

TEST_F(StreamedTable, KeepsPlacesThroughNotesBlankLinesAndQuotes) {
  write("\xEF\xBB\xBF# note\r\nx, y\r\n\r\n1,\"2,5\"\r\n# other\n 3 ,4");
  const Content c = streamed();
  EXPECT_THAT(c.columns, ElementsAre("x", "y"));
  EXPECT_THAT(c.rows, ElementsAre("4|1@1|2,5@3", "6|3@2|4@5"));
  EXPECT_THAT(c.errors, ElementsAre());
}

TEST_F(StreamedTable, SaysWhatTheWholeFileSays) {
  for (const char* bytes :
       {"x,y\n1,2\n3\n4,5,6\n7,8\n", "x,y\n1,\"2\n3,4\n", "x;y\n1;2\n", "x\ty\n1\t2\n", "", "# only a note\n\n",
        "\x89PNG\r\n\x1a\n", "\xFF\xFEx", "x,y", "x,y\n\n\n", "x,y\n%PDF,GIF8\n", "a,,b\n1,,2\n"}) {
    write(bytes);
    const Content s = streamed(), h = held();
    EXPECT_EQ(s.columns, h.columns) << bytes;
    EXPECT_EQ(s.rows, h.rows) << bytes;
    EXPECT_EQ(s.errors, h.errors) << bytes;
  }
}

TEST_F(StreamedTable, BytesThatAreNoTextAreNamedWhereTheyStand) {
  write(std::string("x,y\n1,2\n3,\0\n5,6\n", 16));
  const Content c = streamed();
  EXPECT_THAT(c.rows, ElementsAre("2|1@1|2@3"));
  EXPECT_THAT(c.errors, ElementsAre("3:3: byte \\x00 is no text; a text file is wanted, which is text in UTF-8"));
}

TEST_F(StreamedTable, AMissingFileAndAFolderAreErrors) {
  std::filesystem::remove(file_);
  EXPECT_EQ(streamed().errors, held().errors);
  FileErrors errors(std::filesystem::temp_directory_path());
  EXPECT_FALSE(CsvStream(std::filesystem::temp_directory_path(), errors).column("x"));
  EXPECT_THAT(told(errors), ElementsAre("0:0: this is a folder; a file is wanted"));
}

}  // namespace
}  // namespace grouser
