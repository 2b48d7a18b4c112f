// Tables as a file: nothing is lost, and a file that is not what it says is refused by name.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <filesystem>
#include <fstream>

#include "synthetic.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;

class TablesFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("sdem_tables_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    file_ = folder_ / "tables.h5";
    sdem::Tables t = bekker_tables(1e6, 0.05, true);
    fill(t, sdem::Part::soil_right, [](double w, double vx, double vz, double u, double v) {
      return std::pair{w * u + vx, vz * v - u};
    });
    t.write(file_);
    written_ = std::move(t);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string refused() const {
    try {
      sdem::Tables::read(file_);
    } catch (const ResultsError& e) {
      return e.what();
    }
    return "read";
  }
  fs::path folder_, file_;
  sdem::Tables written_;
};

TEST_F(TablesFile, ReadsBackEveryBit) {
  const sdem::Tables t = sdem::Tables::read(file_);
  EXPECT_EQ(t.hash_text(), written_.hash_text());
  EXPECT_EQ(t.soil, written_.soil);
  EXPECT_EQ(t.vz, written_.vz);
  for (std::size_t p = 0; p < t.parts.size(); ++p) {
    EXPECT_EQ(t.parts[p].x, written_.parts[p].x);
    EXPECT_EQ(t.parts[p].z, written_.parts[p].z);
    EXPECT_EQ(t.parts[p].u.count, written_.parts[p].u.count);
  }
  EXPECT_FALSE(fs::exists(file_.string() + "." + std::to_string(getpid()) + ".part"));
}

TEST_F(TablesFile, EveryValueAndEveryInputCountsInTheHash) {
  const std::string hash = written_.hash_text();
  sdem::Tables t = written_;
  t.part(sdem::Part::wheel_bottom).z[1234] *= 1.0000002F;
  EXPECT_NE(t.hash_text(), hash);
  t = written_;
  t.soil += "friction 0.5\n";
  EXPECT_NE(t.hash_text(), hash);
  t = written_;
  t.bed_depth += 1e-12;
  EXPECT_NE(t.hash_text(), hash);
}

TEST_F(TablesFile, AChangedValueIsRefused) {
  const hid_t f = H5Fopen(file_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t d = H5Dopen2(f, "vx", H5P_DEFAULT);
  const double other[] = {0, 0.02, 0.036};
  ASSERT_GE(H5Dwrite(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, other), 0);
  H5Dclose(d);
  H5Fclose(f);
  EXPECT_EQ(refused(), file_.string() +
                           ": is damaged: its content does not match its stored hash; copy it again or build it again");
}

TEST_F(TablesFile, ATruncatedFileIsRefusedByName) {
  fs::resize_file(file_, fs::file_size(file_) * 2 / 3);
  EXPECT_NE(refused().find(file_.string() + ": "), std::string::npos) << refused();
  EXPECT_NE(refused(), "read");
}

TEST_F(TablesFile, AFileOfAnotherKindIsRefused) {
  Recorder r = Recorder::create(file_, {"bed", "", "", "", "", 0});
  r.close();
  EXPECT_NE(refused().find("is a bed, not tables of the surrogate; make them with 'grouser sdem build'"),
            std::string::npos)
      << refused();
}

TEST_F(TablesFile, ValuesThatAreNotFiniteAreNotWritten) {
  sdem::Tables t = written_;
  t.part(sdem::Part::soil_top).z[7] = std::nanf("");
  try {
    t.write(folder_ / "bad.h5");
    FAIL();
  } catch (const ResultsError& e) {
    EXPECT_NE(std::string(e.what()).find("soil_top has values that are not finite"), std::string::npos) << e.what();
  }
  EXPECT_FALSE(fs::exists(folder_ / "bad.h5"));
}

TEST(TableSizes, ArePublishedCellsWithoutTheAxisThatRepeats) {
  const sdem::Tables t = empty_tables();
  // 108 nodes, window of 0.39 m in cells of 4 mm, two components in float: some 98 x 98 cells.
  EXPECT_EQ(t.nodes(), 108u);
  double soil = 0;
  for (int p = 0; p < 4; ++p) soil += static_cast<double>(t.parts[static_cast<std::size_t>(p)].x.size());
  EXPECT_NEAR(soil / 108, 98 * 98, 0.06 * 98 * 98);  // borders between regions are in both
}

}  // namespace
}  // namespace grouser::test
