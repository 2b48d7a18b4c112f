// Interpolation: exact where it must be, and what a literal interpolation in all dimensions gives.
#include "blend.h"

#include <gtest/gtest.h>

#include <random>

#include "literal.h"
#include "synthetic.h"

namespace grouser::test {
namespace {

TEST(Blend, IsExactForFunctionsThatAreLinearInEveryAxis) {
  sdem::Tables t = empty_tables();
  const TableFunction f = [](double w, double vx, double vz, double u, double v) {
    return std::pair{0.3 + w - 20 * vx + 7 * vz + 2 * u - 3 * v, 1 - 2 * w + vx * 5 + 30 * vz - u + 4 * v};
  };
  for (std::size_t p = 0; p < t.parts.size(); ++p) fill(t, static_cast<sdem::Part>(p), f);
  sdem::Blend blend(shared(t));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 1);
  const auto within = [&](double a, double b) { return a + (b - a) * any(random); };
  for (int k = 0; k < 2000; ++k) {
    const sdem::Velocity V{within(t.w.front(), t.w.back()), within(0, 0.035), within(-0.01, 0.01)};
    blend.set(V);
    const std::size_t p = static_cast<std::size_t>(k) % 6;
    const double u = within(t.parts[p].u.first, t.parts[p].u.last), v = within(t.parts[p].v.first, t.parts[p].v.last);
    const sdem::Pair got = blend.at(static_cast<sdem::Part>(p), u, v);
    const auto [x, z] = f(V.w, V.vx, V.vz, u, v);
    EXPECT_NEAR(got.x, x, 3e-6);  // values of some 5, single precision
    EXPECT_NEAR(got.z, z, 3e-6);
  }
}

TEST(Blend, IsTheLiteralInterpolationInFiveDimensions) {
  const auto t = shared(random_tables(3));
  sdem::Blend blend(t);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(0, 1);
  for (int k = 0; k < 2000; ++k) {
    const sdem::Velocity V{t->w.back() * any(random), 0.035 * any(random), -0.01 + 0.02 * any(random)};
    if (k % 5 == 0) blend.set(V);
    const std::size_t p = static_cast<std::size_t>(k) % 6;
    const sdem::Grid& g = t->parts[p];
    const double u = g.u.first + any(random) * (g.u.last - g.u.first),
                 v = g.v.first + any(random) * (g.v.last - g.v.first);
    const sdem::Velocity at = blend.velocity();
    const sdem::Pair got = blend.at(static_cast<sdem::Part>(p), u, v);
    const auto [x, z] = literal_value(*t, p, {at.w, at.vx, at.vz, u, v});
    EXPECT_NEAR(got.x, x, 1e-5);
    EXPECT_NEAR(got.z, z, 1e-5);
  }
}

TEST(Blend, NamesWhatLiesOutsideTheTables) {
  const sdem::Tables t = empty_tables();
  EXPECT_EQ(sdem::outside(t, {0.1, 0.01, 0.005}), "");
  EXPECT_EQ(sdem::outside(t, {0.1, 0.04, -0.02}),
            "vx = 0.04 m/s, tables hold 0 to 0.035; vz = -0.02 m/s, tables hold -0.01 to 0.01");
  EXPECT_EQ(sdem::outside(t, {-0.1, 0, 0}), "w = -0.1 rad/s, tables hold 0 to 0.349066");
}

}  // namespace
}  // namespace grouser::test
