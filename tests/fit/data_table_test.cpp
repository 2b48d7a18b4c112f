#include "grouser/diagnosis/data_table.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace grouser::diagnosis {
namespace {

std::filesystem::path folder() {
  static const auto f = [] {
    const auto p = std::filesystem::temp_directory_path() / ("grouser-fit-table-" + std::to_string(getpid()));
    std::filesystem::create_directories(p);
    std::ofstream(p / "t.csv") << "# a note\nsoil,test,force_N,depth_mm,moment_Nm,group,plain\nA,1,10,2.5,3,\"x, "
                                  "y\",7\nA,2,20,5,4,z,8\nB,1,x,7.5,5,z,9\n";
    return p;
  }();
  return f;
}

struct Loaded {
  ConfigDocument document;
  DataTable table;
};

Loaded load(const std::string& yaml) {
  Loaded l{ConfigDocument::from_text("file: t.csv\n" + yaml, "fit.yaml", folder()), {}};
  l.table = DataTable::load(l.document.root());
  return l;
}

std::string messages(const Loaded& l) {
  std::string text;
  for (const Diagnostic& d : l.document.diagnostics())
    text += d.text().substr(d.text().find("t.csv") == std::string::npos ? 0 : 0) + "\n";
  return text;
}

TEST(DataTable, ConvertsByTheUnitInTheHeaderOrTheFile) {
  const Loaded l = load("where: {soil: A}\nd: depth_mm\nf: {column: plain, unit: kN}\nm: moment_Nm\nc: 2 kN\n");
  const ConfigNode n = l.document.root();
  EXPECT_EQ(l.table.quantity(n, "d", "m"), (std::vector<double>{2.5e-3, 5e-3}));
  EXPECT_EQ(l.table.quantity(n, "f", "N"), (std::vector<double>{7000, 8000}));
  EXPECT_EQ(l.table.quantity(n, "m", "N m"), (std::vector<double>{3, 4}));
  EXPECT_EQ(l.table.quantity(n, "c", "N"), (std::vector<double>{2000, 2000}));
  EXPECT_EQ(messages(l), "");
}

TEST(DataTable, KeepsRowsByNumberTextAndQuotedCell) {
  EXPECT_EQ(load("where: {test: 1.0}\n").table.size(), 2u);
  EXPECT_EQ(load("where: {soil: [A, B]}\nskip: {test: 1}\n").table.size(), 1u);
  const Loaded l = load("where: {group: \"x, y\"}\n");
  ASSERT_EQ(l.table.size(), 1u);
  EXPECT_EQ(l.table.line(0), 3);
}

TEST(DataTable, NamesTheCellThatIsNoNumber) {
  const Loaded l = load("f: force_N\n");
  EXPECT_TRUE(l.table.quantity(l.document.root(), "f", "N").empty());
  EXPECT_NE(messages(l).find("t.csv:5:5: column 'force_N': 'x' is not a finite number"), std::string::npos)
      << messages(l);
}

TEST(DataTable, NamesTheUnknownColumnAndTheNearestOne) {
  const Loaded l = load("d: depht_mm\n");
  l.table.quantity(l.document.root(), "d", "m");
  EXPECT_NE(messages(l).find("has no column 'depht_mm'; did you mean 'depth_mm'?"), std::string::npos) << messages(l);
}

TEST(DataTable, RefusesAUnitOfAnotherQuantityAndAColumnWithoutOne) {
  const Loaded wrong = load("d: {column: depth_mm, unit: N}\n");
  wrong.table.quantity(wrong.document.root(), "d", "m");
  EXPECT_NE(messages(wrong).find("'N' is not a unit of this quantity; it is measured in m"), std::string::npos)
      << messages(wrong);
  const Loaded none = load("d: plain\n");
  none.table.quantity(none.document.root(), "d", "m");
  EXPECT_NE(messages(none).find("the unit of column 'plain' is not in its name"), std::string::npos) << messages(none);
}

TEST(DataTable, SaysThatNoRowIsLeft) {
  EXPECT_NE(messages(load("where: {soil: C}\n")).find("no row of"), std::string::npos);
}

}  // namespace
}  // namespace grouser::diagnosis
