// What is said of tables with mistakes, and of tables from which nothing can be told.
#include <gmock/gmock.h>

#include "support.h"

namespace grouser::diagnosis {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(DiagnoseTest, MistakesOfATableAreNamedWithPlaceAndRemedy) {
  EXPECT_THAT(refusal("slip,slip_radius_m,load,drawbar_N\n0.1,0.13,115,3\n"),
              AllOf(HasSubstr("data.csv:1:20"), HasSubstr("has no unit"), HasSubstr("load_N")));
  EXPECT_THAT(refusal("slip,load_N,drawbar_N\n0.1,115,3\n"),
              AllOf(HasSubstr("slip_radius_m"), HasSubstr("two meanings")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n0.1,0.13,115,nan\n"),
              AllOf(HasSubstr("data.csv:2:14"), HasSubstr("not a finite number"), HasSubstr("leave the cell empty")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n30,0.13,115,3\n"),
              AllOf(HasSubstr("outside -1..1"), HasSubstr("fraction")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_kg\n0.1,0.13,115,3\n"),
              AllOf(HasSubstr("data.csv:1:"), HasSubstr("not a unit of drawbar")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N\n0.1,0.13,115\n"), HasSubstr("nothing was measured"));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,batch,replicate,drawbar_N\n0.1,0.13,115,a,1,3\n0.1,0.13,115,a,1,3\n"),
              AllOf(HasSubstr("data.csv:3:"), HasSubstr("already in line 2")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,replicate,drawbar_N\n0.1,0.13,115,1,3\n0.1,0.13,115,1,4\n"),
              AllOf(HasSubstr("data.csv:3:"), HasSubstr("already in line 2")));
  EXPECT_THAT(refusal("slip,slip_radius_m,load_N,drawbar_N\n"), HasSubstr("no runs below the header"));
}

TEST_F(DiagnoseTest, UnitsThatNoWheelHasAreRefused) {
  const std::string header = "slip,slip_radius_m,load_N,sinkage_m\n";
  EXPECT_THAT(refusal(header + "0.1,0.13,115,12.5\n"),
              AllOf(HasSubstr("data.csv:2:14"), HasSubstr("diameter"), HasSubstr("sinkage_mm")));
  EXPECT_THAT(refusal(header + "0.1,0.13,115,-0.012\n0.2,0.13,115,-0.013\n"), HasSubstr("counts downwards"));
  EXPECT_EQ(refusal(header + "0.1,0.13,115,-0.001\n0.2,0.13,115,0.013\n"), "accepted");  // a wheel may ride up
  EXPECT_THAT(refusal(header + "0.1,130,115,0.012\n"), AllOf(HasSubstr("data.csv:2:5"), HasSubstr("check the unit")));
  EXPECT_EQ(refusal(header + "0.1,0.14,115,0.012\n"), "accepted");  // over lugs
  EXPECT_THAT(refusal("slip,slip_def,slip_radius_m,load_N,sinkage_m\n0.1,rim,0.13,115,0.012\n"),
              AllOf(HasSubstr("data.csv:1:6"), HasSubstr("slip_def"), HasSubstr("not known")));
}

TEST_F(DiagnoseTest, ARunCopiedIsPointedAt) {
  const std::string text =
      "slip,slip_radius_m,load_N,drawbar_N,torque_Nm\n0.1,0.13,115,3,1\n0.2,0.13,115,4,2\n0.1,0.13,115,3,1.1\n"
      "0.2,0.13,115,4,2\n";
  EXPECT_THAT(table(text).notes, ::testing::Contains(HasSubstr("to the last digit: 5 of 3;")));
}

// Twelve runs at one slip and one load: no soil value can be found from a column that never changes.
TEST_F(DiagnoseTest, ConditionsThatNeverChangeAreUndecidableWithARunThatWouldDecide) {
  std::string text = "slip,slip_radius_m,load_N,drawbar_N,drawbar_sd_N\n";
  for (int i = 0; i < 12; ++i) text += "0.3,0.13,115," + std::to_string(20 + i % 3) + ",2\n";
  const Diagnosis d = diagnose(given(), table(text), {});
  EXPECT_EQ(d.verdict, "undecidable") << d.sentence;
  ASSERT_FALSE(d.next.empty());
  EXPECT_FALSE(d.next[0].condition.empty() && d.next[0].bench_check.empty());
  EXPECT_THAT(d.notes, ::testing::Contains(AllOf(HasSubstr("slip"), HasSubstr("never changes"))));
}

TEST_F(DiagnoseTest, AChannelThatNeverChangesIsSaidToBeSo) {
  std::string text = "slip,slip_radius_m,load_N,drawbar_N,torque_Nm\n";
  for (int i = 0; i < 12; ++i)
    text += std::to_string(-0.5 + 0.1 * i) + ",0.13,115," + std::to_string(-30 + 5 * i) + ",4.2\n";
  EXPECT_THAT(refusal(text),
              AllOf(HasSubstr("data.csv:2:"), HasSubstr("torque_Nm"), HasSubstr("the same in every row")));
}

TEST_F(DiagnoseTest, OneRunIsUndecidableAndSaysWhatToMeasure) {
  const Diagnosis d = diagnose(given(), table("slip,slip_radius_m,load_N,drawbar_N\n0.3,0.13,115,20\n"), {});
  EXPECT_EQ(d.verdict, "undecidable");
  ASSERT_FALSE(d.next.empty());
  EXPECT_GT(d.next[0].runs + (d.next[0].bench_check.empty() ? 0 : 1), 0);
  EXPECT_THAT(d.sentence, HasSubstr("too few"));
  EXPECT_THAT(d.sentence, ::testing::Not(HasSubstr("nan")));
}

TEST_F(DiagnoseTest, EveryMistakeOfATableComesAtOnce) {
  const std::string all =
      refusal("slip,slip_radius_m,load_N,drawbar_N,drawbar_sd_N\n0.1,0.13,115,3,0\n0.2,0.13,-5,3,2\n7,0.13,115,x,2\n");
  EXPECT_THAT(all, AllOf(HasSubstr("data.csv:2:"), HasSubstr("data.csv:3:"), HasSubstr("data.csv:4:")));
}

}  // namespace
}  // namespace grouser::diagnosis
