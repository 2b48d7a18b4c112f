// grouser bekker forces, solve, table: files of cases in, files of results out, and what is said of wrong ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <vector>

#include "command.h"

namespace grouser::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string soil_columns = "c_Pa,phi_rad,n,K_m,kc,kphi,radius_m,width_m";
const std::string arc_columns = soil_columns + ",theta_f_rad,theta_m_rad,theta_r_rad,slip,beta_rad";
const std::string load_columns = soil_columns + ",load_N,a0,a1,b0,b1,slip,beta_rad";
const std::string sandy_loam = "1700,0.51,0.7,0.025,5300,1515000,0.08,0.075";

/// The file in the scratch folder.
fs::path file_of(const std::string& name, const std::string& text) {
  std::ofstream(scratch() / name) << text;
  return scratch() / name;
}

CommandResult bekker(const std::string& arguments) { return grouser_command("bekker " + arguments, scratch()); }

/// Cells of a results file by column, all rows.
std::map<std::string, std::vector<std::string>> columns_of(const std::string& file) {
  std::ifstream in(scratch() / file);
  std::vector<std::vector<std::string>> lines;
  for (std::string line; std::getline(in, line);) {
    lines.emplace_back();
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) lines.back().push_back(cell);
  }
  std::map<std::string, std::vector<std::string>> out;
  for (std::size_t r = 1; r < lines.size(); ++r)
    for (std::size_t c = 0; c < lines[0].size(); ++c) out[lines[0][c]].push_back(lines[r].at(c));
  return out;
}

double number(const std::string& text) { return std::stod(text); }

TEST(BekkerForces, OfAWheelWithoutShearStrengthAreTheHandChecked) {
  // n = 1, theta_m = theta_r = 0, c = phi = 0: sigma = k r (cos theta - cos theta_f), so
  // Fx = -r^2 b k (1 - cos tf)^2/2, Fz = r^2 b k (tf - sin tf cos tf)/2, My = 0.
  file_of("hand.csv", arc_columns + "\n0,0,1,0.01,0,1000000,0.1,0.2,0.5,0,0,0.2,0\n");
  const CommandResult r = bekker("forces hand.csv --tol 1e-12 --out hand_out.csv");
  ASSERT_EQ(r.code, 0) << r.err;
  auto c = columns_of("hand_out.csv");
  const double k = 0.01 * 0.2 * 1e6, one = 1 - std::cos(0.5);
  EXPECT_NEAR(number(c["Fx"][0]), -k * one * one / 2, 1e-9);
  EXPECT_NEAR(number(c["Fz"][0]), k * (0.5 - std::sin(0.5) * std::cos(0.5)) / 2, 1e-9);
  EXPECT_EQ(c["My"][0], "0");
  EXPECT_EQ(c["status"][0], "ok");
}

TEST(BekkerForces, PassOtherColumnsThroughAndWriteSeventeenDigits) {
  file_of("pass.csv", "# note\nname," + arc_columns + ",remark\nr 1," + sandy_loam +
                          ",0.52,0.26,0,0.30,0,\"a, b\"\n  r2 ," + sandy_loam + ",0.52,0.26,0,+0.3,0,x\n");
  ASSERT_EQ(bekker("forces pass.csv --out pass_out.csv").code, 0);
  std::ifstream in(scratch() / "pass_out.csv");
  std::string header, first, second;
  std::getline(in, header);
  std::getline(in, first);
  std::getline(in, second);
  EXPECT_EQ(header, "name," + arc_columns + ",remark,Fx,Fy,Fz,Mx,My,Mz,status");
  EXPECT_EQ(first.find("r 1," + sandy_loam + ",0.52,0.26,0,0.30,0,\"a, b\",-"), 0u) << first;
  EXPECT_EQ(second.find("  r2 ," + sandy_loam + ",0.52,0.26,0,+0.3,0,x,-"), 0u) << second;
  // 17 significant digits come back as the same double.
  const std::string fx =
      second.substr(second.find(",x,-") + 3, second.find(',', second.find(",x,-") + 4) - second.find(",x,-") - 3);
  EXPECT_GE(fx.size(), 17u);
}

TEST(BekkerForces, AreTheSameBitsForOneAndTwoThreads) {
  std::string text = arc_columns + ",zu_m,Au\n";
  for (int i = 0; i < 3000; ++i)
    text += sandy_loam + "," + std::to_string(0.2 + 1e-4 * i) + ",0.1,-0.05," + std::to_string(-1 + 6e-4 * i) +
            ",0.1,0.004,5e8\n";
  file_of("many.csv", text);
  ASSERT_EQ(bekker("forces many.csv --out one.csv").code, 0);
  ASSERT_EQ(bekker("forces many.csv --out two.csv --threads 2").code, 0);
  const std::string one = read_text(scratch() / "one.csv");
  EXPECT_GT(one.size(), text.size());
  EXPECT_TRUE(one == read_text(scratch() / "two.csv"));
}

TEST(BekkerForces, NameEveryErrorOfTheHeader) {
  file_of("head.csv",
          "c_Pa,phi_rad,n,K_m,kc,k_phi,radius_m,width_m,theta_f_rad,theta_m_rad,theta_r_rad,slip,slip,Fx\n1\n");
  const CommandResult r = bekker("forces head.csv --out none.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err,
            "head.csv:1:87: column 'slip' is there twice (columns 12 and 13); remove or rename one\n"
            "head.csv:1:92: column 'Fx' is one that this command writes; remove or rename it\n"
            "head.csv:1:23: missing column 'kphi'; did you mean it by 'k_phi'?\n"
            "head.csv:1:1: missing column 'beta_rad'; this command needs c_Pa,phi_rad,n,K_m,kc,kphi,radius_m,width_m,"
            "theta_f_rad,theta_m_rad,theta_r_rad,slip,beta_rad\n");
  EXPECT_FALSE(fs::exists(scratch() / "none.csv"));
}

TEST(BekkerForces, NameEveryWrongCellAndLeaveNoOutput) {
  file_of("cells.csv", arc_columns + ",shear_type,zu_m\n" +                           //
                           "1700,0.51,0.7,0.025,5300,1515000,0.08,0.075,0.5,0.2\n" +  //
                           "1700,nan,-0.7,0.025,5300,1515000,-0.08,0.075,0.5,0.2,0,1.3,0,,\n" +
                           "1700,0.51,0.7,,5300,1515000,0.08,0.075,0.5,0.6,0,0.3,0,A,0.01\n" +
                           "1700,0.51,0.7,,-530000,1515000,0.08,0.075,0.5,0.3,0,0.3,0,AB,0\n");
  const CommandResult r = bekker("forces cells.csv --out none.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err,
            "cells.csv:2:51: 10 cells where the header has 15; separate cells by commas\n"
            "cells.csv:3:34: radius_m: '-0.08' is out of range; allowed is more than 0\n"
            "cells.csv:3:10: n: '-0.7' is out of range; allowed is at least 0.05 and at most 4\n"
            "cells.csv:3:6: phi_rad: 'nan' is not a finite number; allowed is at least 0 and less than 1.5708\n"
            "cells.csv:3:56: slip: '1.3' is out of range; allowed is at least -1 and at most 1\n"
            "cells.csv:4:15: K_m: a number is wanted for shear type A\n"
            "cells.csv:4:44: theta_m_rad: must be less than theta_f_rad: the front branch would carry nothing\n"
            "cells.csv:4:58: zu_m: a soil that was loaded before needs an unloading slope: give ko or Au more than 0\n"
            "cells.csv:5:16: kc: the modulus kc/width_m + kphi = -5.55167e+06 is not positive\n"
            "cells.csv:5:59: shear_type: 'AB' is not one of A, B, C; did you mean 'A'?\n"
            "cells.csv:5:15: K_m: a number is wanted for shear type A\n");
  EXPECT_FALSE(fs::exists(scratch() / "none.csv"));
}

TEST(BekkerForces, RefuseLugsWithTheHubBelowTheSurface) {
  file_of("sunk.csv", arc_columns + ",lug_height_m,lug_ratio\n" + sandy_loam + ",1.6,0.5,0,0.3,0,,\n" + sandy_loam +
                          ",1.6,0.5,0,0.3,0,0.01,0.3\n");
  const CommandResult r = bekker("forces sunk.csv --out none.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("sunk.csv:3:"));
  EXPECT_THAT(r.err, HasSubstr("theta_f_rad: with lugs at most pi/2"));
  EXPECT_THAT(r.err, Not(HasSubstr("sunk.csv:2:")));
}

TEST(BekkerForces, StopListingErrorsAtTwentyAndCountTheRest) {
  std::string text = arc_columns + "\n";
  for (int i = 0; i < 3000; ++i) text += "x\n";
  file_of("wrong.csv", text);
  const CommandResult r = bekker("forces wrong.csv --out none.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("wrong.csv:21:1: and 2980 more errors in this file\n"));
}

TEST(BekkerForces, WillNotReplaceTheirCases) {
  file_of("keep.csv", arc_columns + "\n" + sandy_loam + ",0.52,0.26,0,0.3,0\n");
  const CommandResult r = bekker("forces keep.csv --out keep.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, "keep.csv: --out would replace the file of cases; name another file\n");
  EXPECT_EQ(bekker("forces no.csv --out x.csv").err, "no.csv: no such file; check the path\n");
}

TEST(BekkerSolve, CarriesTheLoadAndForcesAgree) {
  file_of("solve.csv", load_columns + ",zu_m,Au\n" + sandy_loam + ",60,0.18,0.32,0.1,0,0.3,0.1,,\n" + sandy_loam +
                           ",60,0.18,0.32,0,0,-0.2,0,0.01,5e8\n");
  const CommandResult r = bekker("solve solve.csv --tol 1e-10 --out solved.csv");
  ASSERT_EQ(r.code, 0) << r.err;
  auto s = columns_of("solved.csv");
  // The other command, at the angles found, gives the load back.
  std::string text = arc_columns + ",zu_m,Au\n";
  for (std::size_t i = 0; i < 2; ++i)
    text += sandy_loam + "," + s["theta_f_rad"][i] + "," + s["theta_m_rad"][i] + "," + s["theta_r_rad"][i] + "," +
            s["slip"][i] + "," + s["beta_rad"][i] + "," + s["zu_m"][i] + "," + s["Au"][i] + "\n";
  file_of("back.csv", text);
  ASSERT_EQ(bekker("forces back.csv --tol 1e-10 --out back_out.csv").code, 0);
  auto f = columns_of("back_out.csv");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(number(f["Fz"][i]), 60, 60e-9);
    EXPECT_NEAR(number(f["Fx"][i]), number(s["drawbar_N"][i]), 1e-7);
    EXPECT_NEAR(number(f["My"][i]), -number(s["torque_Nm"][i]), 1e-8);
    EXPECT_NEAR(number(s["sinkage_m"][i]), 0.08 * (1 - std::cos(number(s["theta_f_rad"][i]))), 1e-12);
  }
  EXPECT_EQ(number(s["unloading_sinkage_m"][1]), std::max(0.01, number(s["sinkage_m"][1])));
}

TEST(BekkerSolve, NamesRowsThatCannotCarryTheirLoad) {
  file_of("soft.csv",
          load_columns + "\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0\n" + sandy_loam + ",60000,0.18,0.32,0,0,0.3,0\n");
  const CommandResult r = bekker("solve soft.csv --out soft_out.csv");
  EXPECT_EQ(r.code, 0);
  EXPECT_EQ(r.err, "soft.csv: 1 of 2 rows: too_soft (the first in line 3)\n");
  auto s = columns_of("soft_out.csv");
  EXPECT_EQ(s["status"], (std::vector<std::string>{"ok", "too_soft"}));
  EXPECT_EQ(s["sinkage_m"][1], "nan");
}

TEST(BekkerSolve, FindsTheSlipOfAFreeWheelAgain) {
  file_of("driven.csv", load_columns + "\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0\n");
  ASSERT_EQ(bekker("solve driven.csv --out driven_out.csv").code, 0);
  const std::string torque = columns_of("driven_out.csv")["torque_Nm"][0];
  file_of("free.csv", soil_columns + ",load_N,a0,a1,b0,b1,beta_rad,torque_Nm\n" + sandy_loam + ",60,0.18,0.32,0,0,0," +
                          torque + "\n");
  const CommandResult r = bekker("solve free.csv --free-slip --out free_out.csv");
  ASSERT_EQ(r.code, 0) << r.err;
  EXPECT_NEAR(number(columns_of("free_out.csv")["slip"][0]), 0.3, 1e-6);
}

TEST(BekkerSolve, RefusesAColumnThatLooksLikeAnOptionalOneAndPassesOthersThrough) {
  file_of("typo.csv", load_columns + ",lug_hight_m,shear_Type\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0,0.005,B\n");
  CommandResult r = bekker("solve typo.csv --out typo_out.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("typo.csv:1:78: unknown column 'lug_hight_m'; did you mean 'lug_height_m'?"));
  EXPECT_THAT(r.err, HasSubstr("typo.csv:1:90: unknown column 'shear_Type'; did you mean 'shear_type'?"));
  EXPECT_FALSE(fs::exists(scratch() / "typo_out.csv"));
  file_of("own.csv", load_columns + ",wheel,run\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0,front left,7\n");
  r = bekker("solve own.csv --out own_out.csv");
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_EQ(columns_of("own_out.csv")["wheel"][0], "front left");
}

TEST(BekkerSolve, DemandsTheShareOfTheLugTips) {
  file_of("lugs.csv", load_columns + ",lug_height_m,lug_ratio\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0,0.005,\n" +
                          sandy_loam + ",60,0.18,0.32,0,0,0.3,0,0.005,0\n" + sandy_loam +
                          ",60,0.18,0.32,0,0,0.3,0,0,\n");
  const CommandResult r = bekker("solve lugs.csv --out lugs_out.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("lugs.csv:2:"));
  EXPECT_THAT(r.err, HasSubstr("lug_height_m: a wheel with lugs needs lug_ratio"));
  EXPECT_THAT(r.err, HasSubstr("lugs.csv:3:"));
  EXPECT_THAT(r.err, HasSubstr("lug_ratio: a wheel with lugs needs lug_ratio"));
  EXPECT_THAT(r.err, testing::Not(HasSubstr("lugs.csv:4:")));
}

TEST(BekkerSolve, NamesTheColumnOfAnArcThatIsTooLongAndALimitInDigitsThatCanBeRead) {
  file_of("rear.csv", load_columns + "\n" + sandy_loam + ",60,0.18,0.32,0.8,0.5,0.7,0\n");
  CommandResult r = bekker("solve rear.csv --out rear_out.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, "rear.csv:2:62: b1: b0 + b1 |slip| = 1.15 puts theta_r beyond -theta_f; at most 1 is allowed\n");
  r = bekker("solve rear.csv --tol 1e-15 --out rear_out.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("'1e-15' is not a number in the range 1e-13 to 0.01"));
}

TEST(BekkerOutput, FollowsLinksAndReplacesNeitherLinksNorDevices) {
  file_of("row.csv", load_columns + "\n" + sandy_loam + ",60,0.18,0.32,0,0,0.3,0\n");
  const fs::path target = file_of("target.csv", "old\n"), link = scratch() / "link.csv", null = scratch() / "null.csv",
                 full = scratch() / "full.csv";
  for (const auto& [at, to] : {std::pair{link, fs::path("target.csv")}, {null, "/dev/null"}, {full, "/dev/full"}}) {
    fs::remove(at);
    fs::create_symlink(to, at);
  }
  EXPECT_EQ(bekker("solve row.csv --out link.csv").code, 0);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(target)));
  EXPECT_EQ(columns_of("target.csv")["status"][0], "ok");
  EXPECT_EQ(bekker("solve row.csv --out null.csv").code, 0);
  EXPECT_TRUE(fs::is_symlink(null));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  const CommandResult r = bekker("solve row.csv --out full.csv");
  EXPECT_NE(r.code, 0);
  EXPECT_THAT(r.err, HasSubstr("full.csv: cannot be written: No space left on device"));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

const std::string table_yaml = "table: Small\nwheel: " + (source / "examples/wheels/wheel_s.yaml").string() +
                               "\nsoil: " + (source / "examples/soils/dry_sand_wong_loose.yaml").string() + "\n";

TEST(BekkerTable, IsBuiltShownAndAsked) {
  file_of("table.yaml", table_yaml + "slip: 0..0.4\nload: 20..60 N\nunloading_sinkage: 0..5 mm\nerror_bound: 0.01\n");
  CommandResult r = bekker("table build table.yaml --out table.h5 --threads 2");
  ASSERT_EQ(r.code, 0) << r.err;
  r = bekker("table info table.h5");
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("slip 0..0.4, load 20..60 N, unloading sinkage 0..5 mm\nerror bound 0.01, "));
  file_of("ask.csv", "id,slip,load_N,zu_m\na,0.2,40,0.001\nb,0.5,40,0\nc,0.2,61,0\nd,0.2,40,0.006\n");
  r = bekker("table query table.h5 ask.csv --out asked.csv");
  ASSERT_EQ(r.code, 0) << r.err;
  auto a = columns_of("asked.csv");
  EXPECT_EQ(a["status"], (std::vector<std::string>{"ok", "slip_out_of_range", "load_out_of_range",
                                                   "unloading_sinkage_out_of_range"}));
  EXPECT_EQ(a["thrust_N"][1], "nan");
  // Against solve, inside the bound of the table.
  file_of("ask_solve.csv",
          load_columns + ",zu_m,Au\n0,0.478,0.91,0.005,-660,754130,0.08,0.075,40,0.18,0.32,0,0,0.2,0,0.001,503e6\n");
  ASSERT_EQ(bekker("solve ask_solve.csv --out ask_solved.csv").code, 0);
  auto s = columns_of("ask_solved.csv");
  EXPECT_NEAR(number(a["drawbar_N"][0]), number(s["drawbar_N"][0]), 0.01 * 40);
  EXPECT_NEAR(number(a["sinkage_m"][0]), number(s["sinkage_m"][0]), 0.01 * number(s["sinkage_m"][0]));
}

TEST(BekkerTable, NamesEveryErrorOfItsFile) {
  file_of("wrong_table.yaml",
          table_yaml + "slip: 0.9..0.2\nload: 5..200\nunloading_sinkage: 0..-3 mm\nerorr_bound: 0.01\n");
  const CommandResult r = bekker("table build wrong_table.yaml --out none.h5");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err,
            "wrong_table.yaml:4:7: slip: the range '0.9..0.2' runs down; write the lower end first\n"
            "wrong_table.yaml:5:7: load: '5' has no unit; a force is wanted, for example '5 N'\n"
            "wrong_table.yaml:5:7: load: '200' has no unit; a force is wanted, for example '200 N'\n"
            "wrong_table.yaml:6:20: unloading_sinkage: '-3 mm' is out of range; allowed is at least 0 mm\n"
            "wrong_table.yaml:7:1: unknown key 'erorr_bound'; did you mean 'error_bound'?\n");
  EXPECT_FALSE(fs::exists(scratch() / "none.h5"));
}

TEST(BekkerTable, ThatCannotBeBuiltNamesThePlace) {
  file_of("soft_table.yaml", table_yaml + "slip: 0..0.4\nload: 20..6000 N\nerror_bound: 0.01\n");
  const CommandResult r = bekker("table build soft_table.yaml --out none.h5");
  EXPECT_EQ(r.code, 2);
  EXPECT_THAT(r.err, HasSubstr("soft_table.yaml: no equilibrium at slip "));
  EXPECT_THAT(r.err, HasSubstr("too_soft; narrow the ranges of the table\n"));
}

TEST(BekkerTable, MadeBySomethingElseIsRefused) {
  file_of("text.h5", "hello\n");
  file_of("q.csv", "slip,load_N\n0,1\n");
  const CommandResult r = bekker("table query text.h5 q.csv --out none.csv");
  EXPECT_EQ(r.code, 2);
  EXPECT_EQ(r.err, "text.h5: is not an HDF5 file; name a file that grouser wrote\n");
}

}  // namespace
}  // namespace grouser::test
