// The search behind `grouser soil calibrate`, on functions whose least value is known.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "soil_search.h"

namespace grouser::app {
namespace {

double bowl(const Point& x) {
  const double aim[] = {0.3, 0.7, 0.55};
  double sum = 0;
  for (std::size_t k = 0; k < x.size(); ++k) sum += static_cast<double>(k + 1) * (x[k] - aim[k]) * (x[k] - aim[k]);
  return std::sqrt(sum);
}

TEST(Search, FindsTheLowestPointOfASmoothFunctionWithFewValues) {
  for (const std::string& method : search_methods()) {
    SearchSettings s;
    s.method = method;
    s.first = 8;
    s.most = 60;
    std::set<Point> asked;
    Point best;
    double least = 1e9;
    search(3, s, [&](const std::vector<Point>& x) {
      std::vector<double> y;
      for (const Point& p : x) {
        asked.insert(p);
        y.push_back(bowl(p));
        if (y.back() < least) least = y.back(), best = p;
      }
      return y;
    });
    EXPECT_LE(asked.size(), 60u) << method;
    EXPECT_LT(least, 0.08) << method;
    for (const Point& p : asked)
      for (double c : p) EXPECT_TRUE(c >= 0 && c <= 1);
  }
}

TEST(Search, FillsTheSpaceEvenlyAndOtherwiseForAnotherSeed) {
  SearchSettings s;
  s.first = s.most = 16;
  std::vector<Point> one, two;
  const auto keep = [](std::vector<Point>& to) {
    return [&to](const std::vector<Point>& x) {
      to.insert(to.end(), x.begin(), x.end());
      return std::vector<double>(x.size(), 1.0);
    };
  };
  search(2, s, keep(one));
  search(2, s, keep(two));
  EXPECT_EQ(one, two);
  // A shifted net of 16 points leaves no quarter of the square with less than two of them.
  int quarter[4] = {};
  for (const Point& p : one) ++quarter[(p[0] < 0.5 ? 0 : 1) + (p[1] < 0.5 ? 0 : 2)];
  for (int n : quarter) EXPECT_GE(n, 2);
  s.seed = 2;
  two.clear();
  search(2, s, keep(two));
  EXPECT_NE(one, two);
}

TEST(Search, PassesOnWhatItsFunctionThrows) {
  SearchSettings s;
  int n = 0;
  const auto values = [&](const std::vector<Point>& x) {
    if (++n == 3) throw std::runtime_error("no more");
    return std::vector<double>(x.size(), bowl(x[0]));
  };
  EXPECT_THROW(search(2, s, values), std::runtime_error);
  EXPECT_EQ(n, 3);
  s.method = "newton";
  EXPECT_THROW(search(2, s, values), std::invalid_argument);
}

TEST(ParetoFront, KeepsWhatNothingBeatsInBoth) {
  const double nan = std::nan("");
  EXPECT_EQ(pareto_front({1, 2, 3, 2, nan}, {3, 2, 1, 3, 0}), (std::vector<bool>{true, true, true, false, false}));
}

TEST(PlaneThrough, GivesTheSlopesOfAPlaneAndNoneForTooFewPoints) {
  std::vector<Point> x;
  std::vector<double> y;
  for (double a : {0.0, 1.0, 2.0})
    for (double b : {0.0, 2.0}) {
      x.push_back({a, b});
      y.push_back(3 + 0.5 * a - 2 * b);
    }
  const std::vector<Slope> s = plane_through(x, y);
  ASSERT_EQ(s.size(), 2u);
  EXPECT_NEAR(s[0].value, 0.5, 1e-12);
  EXPECT_NEAR(s[1].value, -2, 1e-12);
  EXPECT_LT(s[0].half_width, 1e-10);
  EXPECT_TRUE(plane_through({{1, 2}, {2, 3}}, {1, 2}).empty());
}

}  // namespace
}  // namespace grouser::app
