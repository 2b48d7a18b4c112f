// Series: the response against exact answers, its slopes against differences, verdicts on sets made by other numerics, errors of files.
#include "grouser/diagnosis/time_series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "../../diagnosis/src/time_lag.h"
#include "grouser/terrain/config.h"
#include "time_generator.h"

namespace grouser::diagnosis {
namespace {

namespace fs = std::filesystem;

/// One channel that ramps from 0 to 1 between 5 and 5.3 s; one input that scales it.
TimeTrack ramp() {
  TimeTrack t;
  t.channels = 1, t.parameters = 1, t.spacing = 0.1;
  t.target.resize(201, 2);
  for (int i = 0; i <= 200; ++i) {
    t.t.push_back(0.1 * i);
    t.speed.push_back(0.03);
    t.turn.push_back(0.02 * i);
    const double u = std::clamp((0.1 * i - 5) / 0.3, 0.0, 1.0);
    t.target(i, 0) = u, t.target(i, 1) = u;
  }
  t.rows = t.t;
  return t;
}

/// First-order lag of the ramp, exact.
double lagged(double t, double tau) {
  const auto after = [&](double x) { return x <= 0 ? 0.0 : x - tau * (1 - std::exp(-x / tau)); };
  return (after(t - 5) - after(t - 5.3)) / 0.3;
}

// The integrator is asked for 1e-5; a ramp's corner costs a few times that.
TEST(SeriesResponse, OfRelaxationOrFilterIsTheExactLagOfARamp) {
  for (const bool travel : {true, false}) {
    TimeDynamics d;
    (travel ? d.sigma : d.tau) = travel ? 0.03 * 1.7 : 1.7;
    TimeResponse r;
    ASSERT_TRUE(respond(ramp(), d, {}, false, r));
    for (int i = 0; i <= 200; ++i) EXPECT_NEAR(r.y(i, 0), lagged(0.1 * i, 1.7), 2e-4) << i;
  }
}

TEST(SeriesResponse, OfADelayIsTheRampLater) {
  TimeDynamics d;
  d.delay = 0.73;
  TimeResponse r;
  ASSERT_TRUE(respond(ramp(), d, {}, false, r));
  for (int i = 0; i <= 200; ++i) EXPECT_NEAR(r.y(i, 0), std::clamp((0.1 * i - 0.73 - 5) / 0.3, 0.0, 1.0), 1e-12) << i;
}

TEST(SeriesResponse, OfAFreeStartDecaysOverTravel) {
  TimeTrack t = ramp();
  t.target.setZero();
  TimeDynamics d;
  d.sigma = 0.06;
  TimeResponse r;
  ASSERT_TRUE(respond(t, d, {2.0}, false, r));
  for (int i = 0; i <= 200; i += 10) EXPECT_NEAR(r.y(i, 0), 2 * std::exp(-0.03 * 0.1 * i / 0.06), 2e-4) << i;
}

// Slopes by CVODES against central differences of the answer. The integrator's error of some 4e-5 becomes 2e-3 in each value of a
// difference over 2e-2, in the worst row several times that; slopes are of order one.
TEST(SeriesResponse, SlopesAreThoseOfDifferences) {
  TimeDynamics d;
  d.sigma = 0.04, d.tau = 0.6, d.delay = 0.25, d.lugs = 6, d.ripple = {0.2, -0.1};
  d.shape_scales = {0.3, 2.0}, d.shape = {0.2, -0.1};
  const TimeTrack track = ramp();
  TimeResponse r;
  ASSERT_TRUE(respond(track, d, {0.1}, true, r));
  const double h = 1e-2;
  const auto check = [&](int column, const char* name, auto change) {
    TimeDynamics up = d, down = d;
    TimeTrack more = track, less = track;
    std::vector<double> above{0.1}, below{0.1};
    change(up, more, above, h), change(down, less, below, -h);
    TimeResponse p, q;
    ASSERT_TRUE(respond(more, up, above, false, p) && respond(less, down, below, false, q));
    double worst = 0, mean = 0;
    for (int i = 0; i <= 200; ++i) {
      const double off = std::abs(r.slopes(i, column) - (p.y(i, 0) - q.y(i, 0)) / (2 * h));
      worst = std::max(worst, off), mean += off / 201;
    }
    EXPECT_LT(worst, 2e-2) << name;
    EXPECT_LT(mean, 2e-3) << name;
  };
  check(0, "input", [](TimeDynamics&, TimeTrack& t, auto&, double x) { t.target.col(0) *= 1 + x; });
  check(1, "start", [](TimeDynamics&, TimeTrack&, auto& s, double x) { s[0] += x; });
  check(2, "ln sigma", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.sigma *= std::exp(x); });
  check(3, "ln tau", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.tau *= std::exp(x); });
  check(4, "ln delay", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.delay *= std::exp(x); });
  check(5, "ripple sin", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.ripple[0] += x; });
  check(6, "ripple cos", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.ripple[1] += x; });
  check(8, "second lag of a free shape", [](TimeDynamics& v, TimeTrack&, auto&, double x) { v.shape[1] += x; });
}

class SeriesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("grouser_series_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
    write_case(hidden::case_text());
  }
  void TearDown() override { fs::remove_all(folder_); }
  void write_case(const std::string& text) { std::ofstream(folder_ / "case.yaml") << text; }
  TimeDiagnosis diagnosed(const std::string& csv) {
    std::ofstream(folder_ / "data.csv") << csv;
    const TimeCase c = read_time_case(folder_ / "case.yaml");
    return diagnose_time(c, read_time_table(folder_ / "data.csv", c), {});
  }
  std::string refusal(const std::string& csv) {
    try {
      diagnosed(csv);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path folder_;
};

TEST_F(SeriesTest, WithNothingHiddenHasNoCause) {
  const TimeDiagnosis t = diagnosed(hidden::make(hidden::What::nothing, 0, 11).csv);
  EXPECT_EQ(t.d.verdict, "adequate") << t.d.sentence;
}

TEST_F(SeriesTest, AtTwoSpeedsNamesARelaxationLengthAndItsSize) {
  const hidden::Set set = hidden::make(hidden::What::relaxation, 150, 12);
  const TimeDiagnosis t = diagnosed(set.csv);
  ASSERT_EQ(t.d.verdict, "named") << t.d.sentence;
  EXPECT_EQ(t.d.cause, "relaxation_length");
  const Interval& i = t.d.parameters.at("relaxation_length");
  // Twice the 90 % interval on each side: one set must not fail by chance.
  EXPECT_NEAR(i.value, set.size, 2 * (i.high - i.low));
}

TEST_F(SeriesTest, AtOneSpeedCannotTellRelaxationFromFilterAndSaysWhatWould) {
  hidden::Plan plan;
  plan.travel = {0.05};
  const TimeDiagnosis t = diagnosed(hidden::make(hidden::What::relaxation, 150, 13, plan).csv);
  ASSERT_EQ(t.d.verdict, "class") << t.d.sentence;
  EXPECT_THAT(t.d.members, ::testing::UnorderedElementsAre("relaxation_length", "filter"));
  ASSERT_FALSE(t.d.next.empty());
  EXPECT_GT(std::abs(std::log(t.d.next[0].condition.at("travel_speed_m_s") / 0.05)), 0.5) << "another speed decides";
  // What simulated rows and refits reach, not what slopes foretell.
  ASSERT_TRUE(t.d.next[0].simulated.has_value());
  EXPECT_LE(t.d.next[0].chance, *t.d.next[0].simulated);
  EXPECT_GT(t.d.next[0].chance, 0.9);
}

TEST_F(SeriesTest, MistakesOfFilesAreSaidWithTheirPlace) {
  const std::string header = "batch,time_s,slip,slip_radius_m,load_N,omega_rad_s,drawbar_N\n";
  EXPECT_THAT(refusal("batch,slip,slip_radius_m,load_N,omega_rad_s,drawbar_N\n1,0.1,0.13,115,0.3,4\n"),
              ::testing::HasSubstr("column 'time_s' is missing"));
  EXPECT_THAT(refusal(header + "1,0,0.1,0.13,115,0.3,4\n1,0,0.1,0.13,115,0.3,4\n"),
              ::testing::AllOf(::testing::HasSubstr("data.csv:3:1"), ::testing::HasSubstr("time does not rise"),
                               ::testing::HasSubstr("fewer than 12")));
  write_case(hidden::case_text() + "  effects: [dealy]\n");
  EXPECT_THAT(refusal(header), ::testing::HasSubstr("did you mean 'delay'?"));
}

TEST_F(SeriesTest, WithoutAnyStepIsUndecidable) {
  std::string csv = "time_s,omega_rad_s,travel_speed_m_s,load_N,drawbar_N,drawbar_sd_N\n";
  for (int i = 0; i < 40; ++i)
    csv += std::to_string(0.1 * i) + ",0.3,0.0351,115," + std::to_string(4 + 2 * std::sin(7.1 * i * i)) + ",2\n";
  const TimeDiagnosis t = diagnosed(csv);
  EXPECT_EQ(t.d.verdict, "undecidable") << t.d.sentence;
  ASSERT_FALSE(t.d.next.empty());
}

}  // namespace
}  // namespace grouser::diagnosis
