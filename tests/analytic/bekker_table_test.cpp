// Lookup tables against the law they were made of, on disk, and at their limits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "grouser/bekker/table.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"

namespace grouser::bekker {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

SoilLaw soil(const std::string& name, double width) {
  return SoilLaw::of(*load_soil_file(fs::path(GROUSER_SOURCE_DIR) / "examples/soils" / (name + ".yaml")).bekker, width);
}

TableSpec dry_sand() {
  TableSpec s;
  s.title = "dry sand";
  s.wheel = {0.1, 0.1};
  s.soil = soil("dry_sand_wong_loose", 0.1);
  s.slip = {-0.6, 0.8};
  s.load = {10, 150};
  s.unloading_sinkage = {0, 0.015};
  s.error_bound = 3e-3;
  s.inputs = "table: dry sand\n";
  return s;
}

TableSpec small() {
  TableSpec s = dry_sand();
  s.slip = {0.1, 0.3};
  s.load = {50, 80};
  s.unloading_sinkage = {0, 0.005};
  s.error_bound = 0.02;
  return s;
}

/// Largest error at `count` random points, each output in the measure that TableSpec::error_bound states.
double largest_error(const WheelTable& t, int count, unsigned seed) {
  const TableSpec& s = t.spec();
  std::mt19937_64 engine(seed);
  const auto any = [&](TableRange r) { return std::uniform_real_distribution<>(r.lower, r.upper)(engine); };
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    const LoadCase c{s.wheel, s.soil, any(s.load), any(s.slip), 0, any(s.unloading_sinkage)};
    const Solution x = solve(c, s.method, 1e-8);
    TablePoint p;
    EXPECT_EQ(t.query(c.slip, c.load, c.unloading_sinkage, p), TableStatus::ok);
    EXPECT_EQ(x.status, ForceStatus::ok);
    for (const double e :
         {(p.drawbar() - x.wrench.Fx) / c.load, (p.torque + x.wrench.My) / (c.load * s.wheel.outer_radius()),
          p.entry_angle / x.arc.theta_f - 1, p.sinkage / x.sinkage - 1, p.unloading_sinkage / x.unloading_sinkage - 1})
      worst = std::max(worst, std::abs(e));
  }
  return worst;
}

const WheelTable& dry_sand_table() {
  static const WheelTable t = WheelTable::build(dry_sand(), 2);
  return t;
}

fs::path scratch(const std::string& name) {
  return fs::temp_directory_path() / ("grouser-table-" + std::to_string(getpid()) + "-" + name);
}

TEST(WheelTable, StaysInsideItsBoundAtTenThousandPointsOffItsGrid) {
  const WheelTable& t = dry_sand_table();
  EXPECT_LE(t.error_found(), dry_sand().error_bound);
  EXPECT_LE(largest_error(t, 10000, 20260101), dry_sand().error_bound);
}

TEST(WheelTable, ThrustAndResistanceAreTheIntegralsOfTheirStresses) {
  // Midpoint rule on the stresses themselves: error far below the table's bound.
  const TableSpec s = dry_sand();
  for (const double slip : {-0.4, -0.05, 0.0, 0.2, 0.7}) {
    TablePoint p;
    ASSERT_EQ(dry_sand_table().query(slip, 60, 0, p), TableStatus::ok);
    const ContactRange range = contact_range(s.soil, p.entry_angle, slip);
    const ShearState e = shear_state(kappa_of_slip(slip));
    constexpr int n = 20000;
    const double step = (range.theta_f - range.theta_r) / n;
    double thrust = 0, resistance = 0, torque = 0;
    for (int i = 0; i < n; ++i) {
      const double theta = range.theta_r + (i + 0.5) * step;
      const Stress x = stress_at(s.wheel, s.soil, range, e, theta);
      thrust += 0.01 * x.tau_t * std::cos(theta) * step;
      resistance += 0.01 * x.sigma * std::sin(theta) * step;
      torque += 0.001 * x.tau_t * step;
    }
    // The entry angle is the table's own, within its bound of the right one; the stresses grow with about its cube.
    const double tolerance = 4 * s.error_bound * 60;
    EXPECT_NEAR(p.thrust, thrust, tolerance) << slip;
    EXPECT_NEAR(p.resistance, resistance, tolerance) << slip;
    EXPECT_NEAR(p.torque, torque, 0.1 * tolerance) << slip;
  }
}

TEST(WheelTable, RefusesWhatLiesOutsideItsRangesAndNamesIt) {
  const WheelTable& t = dry_sand_table();
  const double nan = std::nan("");
  TablePoint p;
  p.thrust = 17;
  EXPECT_EQ(t.query(0.81, 50, 0, p), TableStatus::slip_out_of_range);
  EXPECT_EQ(t.query(-0.61, 50, 0, p), TableStatus::slip_out_of_range);
  EXPECT_EQ(t.query(nan, 50, 0, p), TableStatus::slip_out_of_range);
  EXPECT_EQ(t.query(0.2, 9.99, 0, p), TableStatus::load_out_of_range);
  EXPECT_EQ(t.query(0.2, 150.1, 0, p), TableStatus::load_out_of_range);
  EXPECT_EQ(t.query(0.2, nan, 0, p), TableStatus::load_out_of_range);
  EXPECT_EQ(t.query(0.2, 50, -1e-9, p), TableStatus::unloading_sinkage_out_of_range);
  EXPECT_EQ(t.query(0.2, 50, 0.01501, p), TableStatus::unloading_sinkage_out_of_range);
  EXPECT_EQ(t.query(0.2, 50, nan, p), TableStatus::unloading_sinkage_out_of_range);
  EXPECT_EQ(p.thrust, 17);
}

TEST(WheelTable, TakesTheEndsOfItsRanges) {
  const TableSpec s = dry_sand();
  for (const double slip : {s.slip.lower, 0.0, s.slip.upper})
    for (const double load : {s.load.lower, s.load.upper})
      for (const double zu : {0.0, s.unloading_sinkage.upper}) {
        TablePoint p;
        ASSERT_EQ(dry_sand_table().query(slip, load, zu, p), TableStatus::ok);
        const Solution x = solve({s.wheel, s.soil, load, slip, 0, zu}, s.method, 1e-8);
        EXPECT_NEAR(p.drawbar(), x.wrench.Fx, s.error_bound * load) << slip << " " << load << " " << zu;
        EXPECT_NEAR(p.sinkage, x.sinkage, s.error_bound * x.sinkage) << slip << " " << load << " " << zu;
      }
}

TEST(WheelTable, IsTheSameBitsForOneAndTwoThreads) {
  const WheelTable one = WheelTable::build(small(), 1), two = WheelTable::build(small(), 2);
  EXPECT_EQ(one.hash(), two.hash());
  TablePoint a, b;
  one.query(0.234, 61, 0.0031, a);
  two.query(0.234, 61, 0.0031, b);
  EXPECT_EQ(a.thrust, b.thrust);
  EXPECT_EQ(a.entry_angle, b.entry_angle);
}

TEST(WheelTable, ComesBackFromItsFileBitForBit) {
  const fs::path file = scratch("back.h5");
  const WheelTable& t = dry_sand_table();
  t.write(file, "0.1.0");
  const WheelTable r = WheelTable::read(file);
  EXPECT_EQ(r.hash(), t.hash());
  EXPECT_EQ(r.version(), "0.1.0");
  EXPECT_EQ(r.spec().inputs, t.spec().inputs);
  std::mt19937_64 engine(3);
  for (int i = 0; i < 2000; ++i) {
    const auto any = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(engine); };
    const double slip = any(-0.6, 0.8), load = any(10, 150), zu = any(0, 0.015);
    TablePoint p, q;
    t.query(slip, load, zu, p);
    r.query(slip, load, zu, q);
    ASSERT_EQ(p.thrust, q.thrust);
    ASSERT_EQ(p.resistance, q.resistance);
    ASSERT_EQ(p.torque, q.torque);
    ASSERT_EQ(p.entry_angle, q.entry_angle);
  }
  fs::remove(file);
}

std::string message_of(const fs::path& file) {
  try {
    WheelTable::read(file);
  } catch (const ResultsError& e) {
    return e.what();
  }
  return "no error";
}

TEST(WheelTable, NamesWhatIsWrongWithAFile) {
  const fs::path file = scratch("good.h5"), bad = scratch("bad.h5");
  WheelTable::build(small(), 1).write(file, "0.1.0");
  EXPECT_THAT(message_of(scratch("none.h5")), HasSubstr("none.h5: no such file"));

  fs::copy_file(file, bad, fs::copy_options::overwrite_existing);
  fs::resize_file(bad, fs::file_size(file) / 2);
  EXPECT_THAT(message_of(bad), HasSubstr("bad.h5: is truncated"));

  std::ofstream(bad) << "not a table\n";
  EXPECT_THAT(message_of(bad), HasSubstr("is not an HDF5 file"));

  // One number of a stress-free looking table, changed in place.
  std::vector<char> bytes(fs::file_size(file));
  std::ifstream(file, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const RunFile good(file);
  const double wanted = good.read("driving.deeper.far.thrust")[5];
  bool found = false;
  for (std::size_t i = 0; i + 8 <= bytes.size() && !found; ++i) {
    found = std::memcmp(&bytes[i], &wanted, 8) == 0;
    if (found) bytes[i + 6] = static_cast<char>(bytes[i + 6] ^ 1);
  }
  ASSERT_TRUE(found);
  std::ofstream(bad, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  EXPECT_EQ(message_of(bad), bad.string() +
                                 ": is damaged: its content does not match its stored hash; copy it again or "
                                 "build it again");

  {
    Recorder r = Recorder::create(bad, {"table", "", "", "", "0", 0});
    r.set_attribute("table_format", 99.0);
    r.close();
  }
  EXPECT_EQ(message_of(bad),
            bad.string() + ": is a table of format 99, and this program reads format 1; build the table again");
  {
    Recorder r = Recorder::create(bad, {"run", "", "", "", "0", 0});
    r.close();
  }
  EXPECT_EQ(message_of(bad), bad.string() + ": is a run, not a table; make one with 'grouser bekker table build'");
  fs::remove(file);
  fs::remove(bad);
}

TEST(WheelTable, OfVirginSoilNeedsNoUnloadingSlope) {
  TableSpec s = small();
  s.soil = soil("sandy_loam", 0.1);
  s.slip = {-0.5, 0.8};
  s.unloading_sinkage = {};
  s.error_bound = 1e-3;
  const WheelTable t = WheelTable::build(s, 2);
  EXPECT_LE(largest_error(t, 2000, 5), s.error_bound);
  s.unloading_sinkage = {0, 0.01};
  EXPECT_THROW(WheelTable::build(s), std::invalid_argument);
}

TEST(WheelTable, OfALuggedWheelStaysInsideItsBound) {
  TableSpec s = small();
  s.wheel = {0.08, 0.1, 0.005, 0.1};
  s.slip = {0, 0.6};
  s.error_bound = 5e-3;
  EXPECT_LE(largest_error(WheelTable::build(s, 2), 2000, 6), s.error_bound);
}

TEST(WheelTable, ThatWouldReachTheHubNamesThePlace) {
  TableSpec s = small();
  s.load = {50, 5000};
  try {
    WheelTable::build(s);
    FAIL() << "no error";
  } catch (const TableError& e) {
    EXPECT_THAT(e.what(), HasSubstr("no equilibrium at slip"));
    EXPECT_THAT(e.what(), HasSubstr("too_soft; narrow the ranges of the table"));
  }
}

TEST(WheelTable, OfALawThatJumpsAtSlipZeroMeetsItsBoundOnEitherSideOfIt) {
  // theta_m of eq 2.13 is 0 at slip 0 coming from braking and a0 theta_f coming from driving.
  TableSpec s = small();
  s.soil.theta_m_law = ThetaMLaw::wong_braking;
  s.slip = {-0.2, 0.2};
  s.unloading_sinkage = {0, 0};
  const WheelTable t = WheelTable::build(s, 2);
  EXPECT_LE(largest_error(t, 500, 3), s.error_bound);
  for (const double slip : {-1e-12, -1e-6, -1e-4, 0.0, 1e-12, 1e-4}) {
    TablePoint p;
    ASSERT_EQ(t.query(slip, 60, 0, p), TableStatus::ok);
    const Solution x = solve({s.wheel, s.soil, 60, slip, 0, 0}, s.method, 1e-8);
    EXPECT_NEAR(p.entry_angle, x.arc.theta_f, s.error_bound * x.arc.theta_f) << slip;
    EXPECT_NEAR(p.drawbar(), x.wrench.Fx, s.error_bound * 60) << slip;
  }
}

TEST(WheelTable, WhoseBoundNeedsTooManyPointsIsRefused) {
  TableSpec s = dry_sand();
  s.error_bound = 1e-5;
  s.largest_grid = 3000;
  EXPECT_THROW(WheelTable::build(s, 2), TableError);
}

}  // namespace
}  // namespace grouser::bekker
