// Rates and intervals from answers and verdicts written by hand.
#include "score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "decides.h"
#include "hidden.h"
#include "set_files.h"
#include "wilson.h"

namespace blind {
namespace {

using nlohmann::json;

TEST(Wilson, GivesThePublishedIntervals) {
  // Newcombe 1998, Statistics in Medicine 17, table I, method 3, 95 %.
  const auto expect = [](int yes, int n, double low, double high) {
    const auto [a, b] = wilson({yes, n}, 0.95);
    EXPECT_NEAR(a, low, 5e-5);
    EXPECT_NEAR(b, high, 5e-5);
  };
  expect(81, 263, 0.2553, 0.3662);
  expect(15, 148, 0.0624, 0.1605);
  expect(0, 20, 0.0, 0.1611);
  expect(1, 29, 0.0061, 0.1718);
  EXPECT_EQ(wilson({0, 0}), (std::pair{0.0, 1.0}));
}

TEST(Median, HasTheBinomialOrderStatisticsAsInterval) {
  // n = 10, 90 %: 2nd and 9th value (98 % by 1/1024 sums: P(Bin < 2) = 11/1024, P(Bin < 3) = 56/1024 > 0.05).
  const Median m = median({10, 9, 8, 7, 6, 5, 4, 3, 2, 1});
  EXPECT_EQ(m.value, 5.5);
  EXPECT_EQ(m.low, 2);
  EXPECT_EQ(m.high, 9);
  EXPECT_TRUE(std::isnan(median({}).value));
  EXPECT_EQ(median({3}).low, 3);
}

TEST(Verdicts, ReadPairsListsAndTheMostProbable) {
  EXPECT_EQ(ids_of(json("lugs + exit_angle")), (std::set<std::string>{"exit_angle", "lugs"}));
  EXPECT_EQ(ids_of(json::array({"a", "b"})), (std::set<std::string>{"a", "b"}));
  EXPECT_TRUE(ids_of(json()).empty());
  const Said s = said_of({{"verdict", "class"},
                          {"posterior", {{"none", 0.9}, {"lugs", 0.06}, {"unknown", 0.03}, {"hard_pan", 0.01}}},
                          {"unknown", {{"variable", nullptr}, {"acts_through", "k"}}},
                          {"gain", {{"rmse_ratio", 0.4}}}});
  EXPECT_EQ(s.top, "lugs");
  EXPECT_TRUE(s.variable.empty());
  EXPECT_TRUE(s.acts_through.contains("k"));
  EXPECT_EQ(s.gain_ratio, 0.4);
  EXPECT_THROW(said_of({{"verdict", "certain"}}), std::runtime_error);
}

json hidden(const std::string& id, double x, double d) {
  const Effect& e = effect(id);
  return {{"id", id}, {"x", x}, {"unit", std::string(e.unit)}, {"d", d}, {"variables", e.variables}};
}

Scored set_of(const std::string& family, const std::string& plan, json effects, json said, json exact = json::array()) {
  Scored out;
  out.answer = {{"set", "set_0001"},
                {"family", family},
                {"plan", plan},
                {"effects", std::move(effects)},
                {"exact_class", std::move(exact)}};
  out.said = said_of(said);
  return out;
}

const Bar& find(const std::vector<Bar>& all, const std::string& name) {
  for (const Bar& b : all)
    if (b.name == name) return b;
  throw std::runtime_error(name);
}

TEST(Scorer, CountsWhatWasWrittenByHand) {
  std::vector<Scored> sets;
  const auto add = [&](int times, const Scored& s) { sets.insert(sets.end(), static_cast<std::size_t>(times), s); };
  const json quiet = {{"verdict", "adequate"}}, none = json::array();
  const auto named = [](const std::string& id) {
    return json{{"verdict", "named"}, {"cause", id}, {"posterior", {{id, 0.99}}}};
  };
  add(97, set_of("null_plain", "full", none, quiet));
  add(1, set_of("null_plain", "full", none, {{"verdict", "undecidable"}}));
  add(2, set_of("null_plain", "full", none, named("lugs")));
  const json at9 = json::array({hidden("exit_angle", 0.2, 9)}), at7 = json::array({hidden("exit_angle", 0.2, 7)});
  const json only = json::array({"exit_angle"});
  json right = named("exit_angle");
  right["parameters"] = {{"exit_angle", {{"value", 0.2}, {"ci90", {0.15, 0.25}}, {"unit", "1"}}}};
  json narrow = right;
  narrow["parameters"]["exit_angle"]["ci90"] = {0.21, 0.25};
  add(9, set_of("effect", "full", at9, right, only));
  add(1, set_of("effect", "full", at9, narrow, only));
  add(10,
      set_of("effect", "full", at9, {{"verdict", "class"}, {"posterior", {{"lugs", 0.6}, {"exit_angle", 0.4}}}}, only));
  add(4,
      set_of("effect", "full", at7, {{"verdict", "class"}, {"posterior", {{"exit_angle", 0.6}, {"lugs", 0.4}}}}, only));
  add(5, set_of("sensor", "slip", json::array({hidden("torque_offset", 0.3, 12)}), named("torque_offset"),
                json::array({"torque_offset", "torque_viscous"})));
  const json strange = json::array({hidden("dilatancy_peak", 0.1, 12)});
  add(6, set_of("outside", "full", strange, {{"verdict", "unknown"}, {"unknown", {{"variable", "slip"}}}}));
  add(2, set_of("outside", "full", strange, {{"verdict", "unknown"}, {"unknown", {{"variable", "load_N"}}}}));
  add(2, set_of("outside", "full", strange, named("lugs")));
  const json two = json::array({hidden("lugs", 0.01, 6), hidden("exit_angle", 0.2, 6.2)});
  add(3, set_of("pair", "full", two, named("exit_angle+lugs")));
  add(1, set_of("pair", "full", two, named("lugs")));

  const std::vector<Bar> all = bars(sets);
  const auto expect = [&](const std::string& name, int n, double figure) {
    EXPECT_EQ(find(all, name).n, n) << name;
    EXPECT_NEAR(find(all, name).figure, figure, 1e-12) << name;
  };
  expect("false alarm, null_plain", 100, 0.02);
  EXPECT_TRUE(find(all, "false alarm, null_plain").met());  // 2 of 100: from 0.0068
  expect("top-1, d 6-8", 4, 1.0);
  expect("top-1, d 8-15", 20, 0.5);
  EXPECT_FALSE(find(all, "top-1, d 8-15").met());
  expect("named and right, d 8-10", 20, 0.5);
  // 10 right, 2 alarms on nothing, 2 outside, 3 pairs right, 1 half right.
  expect("right when named", 18, 13.0 / 18);
  expect("right when named, slip sweep", 5, 1.0);
  expect("one name in an exactly confounded class", 5, 1.0);
  expect("unknown, d 10-15", 10, 0.8);
  expect("variable named when unknown", 8, 0.75);
  expect("pair exact, d 6 each", 4, 0.75);
  expect("90 % intervals cover", 10, 0.9);
  EXPECT_EQ(find(all, "unknown, d > 15").n, 0);
  EXPECT_FALSE(find(all, "unknown, d > 15").met());
}

TEST(Scorer, RecoversTheShareOfTheOraclesGain) {
  std::vector<Scored> sets;
  for (const double ratio : {0.5, 0.4, 0.52}) {
    Scored s = set_of("effect", "full", json::array({hidden("lugs", 0.01, 9)}),
                      {{"verdict", "adequate"}, {"gain", {{"rmse_ratio", ratio}}}});
    s.answer["gain"] = {{"rmse_ratio", 0.5}};
    sets.push_back(s);
  }
  EXPECT_NEAR(find(bars(sets), "gain recovered, median").figure, 1.0, 1e-12);
}

TEST(Experiments, ThatChangeTheRightVariableDecide) {
  // One speed: offset and viscous friction of the torque are the same until another speed is run.
  Dice dice(1);
  const std::vector<PlannedRun> runs = plan_runs(Plan::constant_speed, {}, dice);
  const std::string csv = csv_text(runs, std::vector<Eigen::Vector3d>(runs.size(), Eigen::Vector3d::Zero()),
                                   {2, 0.2, 0.0015}, {true, 0.135}, Wheel{});
  const Soil soil;
  const json answer = {{"noise_sd", {2, 0.2, 0.0015}},
                       {"preparation", {0, 0}},
                       {"effects", json::array({hidden("torque_offset", 0.4, 20)})},
                       {"soil",
                        {{"k", soil.k},
                         {"n", soil.n},
                         {"c", soil.c},
                         {"phi", soil.phi},
                         {"K", soil.K},
                         {"a0", soil.a0},
                         {"a1", soil.a1}}}};
  const auto length = [&](const json& condition) { return separation(answer, csv, "torque_viscous", condition); };
  // 0.4 N m at 0.3 rad/s is 1.2 N m at 0.9: 0.8 N m, four sd, four runs.
  ASSERT_TRUE(length({{"omega_rad_s", 0.9}}).has_value());
  EXPECT_NEAR(*length({{"omega_rad_s", 0.9}}), 8.0, 0.3);
  EXPECT_LT(*length({{"load_N", 225}}), 0.3);
  EXPECT_FALSE(length({{"bench", "wheel off the ground"}}).has_value());
}

}  // namespace
}  // namespace blind
