#include "grouser/terrain/state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "results/temporary_folder.h"

namespace grouser {
namespace {

using test::message_of;
using testing::HasSubstr;

enum class Mode : std::uint8_t { off, on };

/// One field of every kind.
struct Sample {
  double x = 1.5;
  bool flag = true;
  std::string text = "soil";
  Pose pose{{1, 2, 3}, Quat(0.5, 0.5, -0.5, 0.5)};
  Twist twist{{4, 5, 6}, {7, 8, 9}};
  std::vector<double> reals{1, -0.0, std::nan("7")};
  std::vector<std::int64_t> integers{1, 2};
  std::vector<std::uint8_t> bytes{3};
  int count = -4;
  Mode mode = Mode::on;
  Mat3 matrix = Mat3::Random();

  void traverse(State& s) {
    s.field("x", x);
    s.field("flag", flag);
    s.field("text", text);
    auto g = s.group("body");
    s.field("pose", pose);
    s.field("twist", twist);
    s.field("reals", reals);
    s.field("integers", integers);
    s.field("bytes", bytes);
    s.field("count", count);
    s.field("mode", mode);
    s.field("matrix", matrix);
  }
};

State saved(Sample& x) {
  State s;
  x.traverse(s);
  return s;
}

TEST(State, LoadedObjectEqualsTheSavedOne) {
  Sample a;
  State s = saved(a);
  Sample b;
  b = Sample{0, false, "", {}, {}, {}, {}, {}, 0, Mode::off, Mat3::Zero()};
  s.rewind(State::Mode::load);
  b.traverse(s);
  s.finish();
  const State again = saved(b);
  EXPECT_FALSE(State::first_difference(s, again));
  EXPECT_EQ(s.hash(), again.hash());
  EXPECT_EQ(b.text, "soil");
  EXPECT_EQ(b.pose.q.w(), 0.5);
  EXPECT_EQ(b.mode, Mode::on);
}

TEST(State, HashSeesEveryBit) {
  Sample a;
  const std::uint64_t h = saved(a).hash();
  Sample b = a;
  b.reals[1] = 0.0;  // equal to -0.0 as a number
  EXPECT_NE(saved(b).hash(), h);
  Sample c = a;
  c.reals[2] = std::nan("8");
  EXPECT_NE(saved(c).hash(), h);
  Sample d = a;
  d.twist.w.z() = std::nextafter(9.0, 10.0);
  EXPECT_NE(saved(d).hash(), h);
  EXPECT_EQ(saved(a).hash_text().size(), 16u);
}

TEST(State, HashIsTheSameOnEveryMachine) {
  // FNV-1a (Fowler, Noll, Vo): an empty input gives the offset basis.
  EXPECT_EQ(State().hash(), 1469598103934665603ull);
}

TEST(State, ComparisonNamesTheFirstFieldThatDiffers) {
  Sample a, b = a;
  b.integers[1] = 5;
  b.count = 9;
  const auto d = State::first_difference(saved(a), saved(b));
  ASSERT_TRUE(d);
  EXPECT_EQ(d->field, "body/integers");
  EXPECT_EQ(d->index, 1u);
  EXPECT_EQ(d->left, "2");
  EXPECT_EQ(d->right, "5");
}

TEST(State, ComparisonNamesSizesAndMissingFields) {
  Sample a, b = a;
  b.reals.push_back(1);
  auto d = State::first_difference(saved(a), saved(b));
  ASSERT_TRUE(d);
  EXPECT_EQ(d->field, "body/reals");
  EXPECT_EQ(d->left, "size 3");
  State longer = saved(a);
  double extra = 1;
  longer.field("extra", extra);
  d = State::first_difference(saved(a), longer);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->field, "extra");
  EXPECT_EQ(d->left, "absent");
}

TEST(State, WrongOrderIsRefusedByName) {
  double x = 1, y = 2;
  State s;
  s.field("x", x);
  s.field("y", y);
  s.rewind(State::Mode::load);
  EXPECT_EQ(message_of<StateError>([&] { s.field("y", y); }), "state has field 'x' where 'y' is expected");
}

TEST(State, WrongKindAndSizeAreRefused) {
  double x = 1;
  int i = 0;
  Vec3 v;
  State s;
  s.field("x", x);
  s.rewind(State::Mode::load);
  EXPECT_THAT(message_of<StateError>([&] { s.field("x", i); }), HasSubstr("'x'"));
  s.rewind(State::Mode::load);
  EXPECT_EQ(message_of<StateError>([&] { s.field("x", v); }), "state field 'x' has another size");
}

TEST(State, FieldsLeftOverAndFieldsMissingAreRefused) {
  double x = 1, y = 2;
  State s;
  {
    auto g = s.group("a");
    s.field("x", x);
  }
  s.rewind(State::Mode::load);
  EXPECT_EQ(message_of<StateError>([&] { s.finish(); }), "state holds a field 'a/x' that nobody reads");
  {
    auto g = s.group("a");
    s.field("x", x);
  }
  EXPECT_NO_THROW(s.finish());
  EXPECT_EQ(message_of<StateError>([&] { s.field("y", y); }), "state ends before field 'y'");
}

}  // namespace
}  // namespace grouser
