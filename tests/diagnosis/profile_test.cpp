// Profile intervals against refits from many places.
#include "../../diagnosis/src/profile.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <random>

#include "support.h"

namespace grouser::diagnosis {
namespace {

/// Least objective with the amplitude held at `a`, from 40 random starts of the soil.
double least_rise(const Search& s, const Rival& r, double a, unsigned seed) {
  Candidate held = nominal_candidate();
  held.held.push_back({r.candidate.terms[0].input, a});
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  double best = INFINITY;
  for (int k = 0; k < 40; ++k) {
    Eigen::VectorXd x = r.fit.x.head(s.series().soil_parameters());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 0.3 * normal(random) * s.series().parameter(i).sd;
    const Fit f = s.series().fit(held, s.whitener(), x, r.fit.theta, 60);
    if (f.ok) best = std::min(best, f.objective());
  }
  return std::sqrt(std::max(best - r.fit.objective(), 0.0));
}

void expect_ends_of(Search& s, const std::string& id, unsigned seed) {
  for (const Rival& r : s.rivals()) {
    if (r.candidate.id != id || !r.refitted) continue;
    const double t =
        boost::math::quantile(boost::math::students_t(s.noise_dof(static_cast<double>(r.fit.x.size()))), 0.95);
    const auto ends = profile_interval(s, r.candidate, r.fit, 0);
    const double x = r.fit.x[s.series().soil_parameters()];
    EXPECT_LT(ends[0], x) << id;
    EXPECT_GT(ends[1], x) << id;
    for (const double end : ends) {
      if (end <= r.candidate.terms[0].lower || end >= r.candidate.terms[0].upper) continue;
      // The secant stops within 0.02; function_tolerance of the refits is 1e-5 of their squares.
      EXPECT_NEAR(least_rise(s, r, end, seed), t, 0.08) << id << " at " << end;
    }
    return;
  }
  FAIL() << id << " was not refitted";
}

// Six rows of Ding 2011, with cohesion on its bound: a step of the soil along the amplitude left the bounds, every refit beyond failed, and the interval ended at the
// value itself.
TEST(ProfileInterval, HasTwoEndsWhereASoilValueLiesOnItsBound) {
  const std::string folder = GROUSER_SOURCE_DIR "/examples/07_find_the_missing_effect";
  const DiagnosisCase c = read_case(folder + "/cases/hit_smooth.yaml");
  const RunTable t = read_runs(folder + "/data/hit_smooth.csv", c);
  Search s(c, t, t.runs);
  s.run();
  expect_ends_of(s, "slip_sinkage_exponent", 5);
}

TEST_F(DiagnoseTest, ProfileEndsAreWhereRefitsFromManyPlacesPutThem) {
  const DiagnosisCase c = given();
  const RunTable t = table(series([](auto& y, double, double, double w) { y[1] += 1.2 * w, y[0] -= 2; }, 4));
  Search s(c, t, t.runs);
  s.run();
  for (const char* id : {"torque_viscous", "drawbar_bias"}) expect_ends_of(s, id, 8);
}

}  // namespace
}  // namespace grouser::diagnosis
