// The whole law on two spheres: friction and rolling with their limits, every variant, against the equations written again
// (dissertation 3.9 to 3.20 with Mindlin's stiffness; LIGGGHTS' `epsd` for Cap::springs) and stepped in doubles.
#include <gtest/gtest.h>

#include <cmath>

#include "grouser/dem/solver.h"

namespace {

using namespace grouser;
using namespace grouser::dem;

struct Impact {
  double r[2] = {0.003, 0.006}, density = 2500, young = 7e7, poisson = 0.25, restitution = 0.4, friction = 0.3;
  Vec3 v[2] = {{0.3, 0.1, 0}, {-0.2, -0.05, 0.03}}, w[2] = {{0, 0, 40}, {0, 20, -10}};
  double rolling = 0.2;
  LawSettings law;
};
struct End {
  Vec3 v[2], w[2];
  double slid = 0, rolled_at_limit = 0, capped_at_one = 0, time = 0;  ///< [s] in contact; parts of it
};

constexpr double kStep = 1e-8, kGap = 1e-7;

Vec3 across(const Vec3& x, const Vec3& n) { return x - x.dot(n) * n; }

End by_hand(const Impact& c) {
  double m[2], inertia[2];
  for (int k = 0; k < 2; ++k) {
    m[k] = 4 * pi / 3 * std::pow(c.r[k], 3) * c.density;
    inertia[k] = 0.4 * m[k] * c.r[k] * c.r[k];
  }
  const double R = c.r[0] * c.r[1] / (c.r[0] + c.r[1]), M = m[0] * m[1] / (m[0] + m[1]);
  const double a0 = m[0] * c.r[0] * c.r[0], a1 = m[1] * c.r[1] * c.r[1], I = 1.4 * a0 * a1 / (a0 + a1);
  const double E = c.young / (2 * (1 - c.poisson * c.poisson));
  const bool printed = c.law.tangential == TangentialStiffness::printed;
  const double G = c.young / 4 / (printed ? (2 + c.poisson) * (1 - c.poisson) : (2 - c.poisson) * (1 + c.poisson));
  const double ln = std::log(c.restitution), beta = ln / std::sqrt(ln * ln + pi * pi);
  const bool springs = c.law.cap == Cap::springs;
  Vec3 x[2] = {Vec3::Zero(), Vec3(c.r[0] + c.r[1] + kGap, 0, 0)}, s = Vec3::Zero(), T = Vec3::Zero();
  End e;
  for (int k = 0; k < 2; ++k) e.v[k] = c.v[k], e.w[k] = c.w[k];
  bool touched = false;
  for (int step = 0; step < 1000000; ++step) {
    const Vec3 d = x[1] - x[0], n = d.normalized();
    const double delta = c.r[0] + c.r[1] - d.norm();
    if (touched && delta <= 0) break;
    if (delta > 0) {
      touched = true;
      e.time += kStep;
      const double a = std::sqrt(R * delta), kn = 4.0 / 3 * E * a, kt = 8 * G * a;
      const double gn = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(1.5 * kn * M);
      const double gt = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(kt * M);
      const double arm[2] = {c.r[0] - delta / 2, c.r[1] - delta / 2};
      const Vec3 centres = e.v[0] - e.v[1];
      const Vec3 u = centres + (arm[0] * e.w[0] + arm[1] * e.w[1]).cross(n), ut = across(u, n);
      const double Fn = kn * delta + gn * u.dot(n), limit = c.friction * std::fabs(Fn);
      s = across(s, n) + ut * kStep;
      Vec3 Ft = -(kt * s + gt * ut);
      if ((springs ? kt * s.norm() : Ft.norm()) > limit) {
        Ft = springs ? Vec3(-limit * s.normalized()) : Vec3(limit * Ft.normalized());
        s = -Ft / kt;
        e.slid += kStep;
      }
      double mu = c.rolling;
      if (c.law.rolling != RollingCoefficient::constant) {
        const Vec3 v = c.law.rolling == RollingCoefficient::rate ? ut : across(centres, n);
        mu = c.rolling * v.squaredNorm();
        if (mu > 1) mu = 1, e.capped_at_one += kStep;
      }
      const double kr = 2.25 * kn * mu * mu * R * R, gr = 2 * std::sqrt(kr * I), most = mu * R * std::fabs(Fn);
      const Vec3 wr = across(e.w[0] - e.w[1], n);
      T = across(T, n) - kr * wr * kStep;
      const bool yields = T.norm() > most;
      if (yields) T *= most / T.norm();
      Vec3 roll = T - (springs && yields ? 0.0 : gr) * wr;
      if (!springs && roll.norm() > most) roll *= most / roll.norm();
      e.rolled_at_limit += yields ? kStep : 0;
      const Vec3 F = -Fn * n + Ft;
      for (int k = 0; k < 2; ++k) {
        const double sign = k == 0 ? 1 : -1;
        e.v[k] += sign * kStep / m[k] * F;
        e.w[k] += kStep / inertia[k] * (arm[k] * n.cross(Ft) + sign * roll);
      }
    }
    for (int k = 0; k < 2; ++k) x[k] += kStep * e.v[k];
  }
  return e;
}

End by_solver(const Impact& c) {
  SolverSettings s;
  s.domain.hi = Vec3(0.06, 0.06, 0.06);
  s.gravity = Vec3::Zero();
  s.dt = kStep;
  s.precision = Precision::full;
  s.law = c.law;
  s.law.damping = Damping::explicit_;
  s.materials.materials[0] = {"spheres", c.young, c.poisson};
  PairProperties& p = s.materials.pairs[0];
  p.friction = c.friction;
  p.rolling = c.rolling;
  p.restitution = c.restitution;
  std::vector<GrainState> g(2);
  for (std::size_t k = 0; k < 2; ++k) {
    g[k].radius = c.r[k];
    g[k].density = c.density;
    g[k].v = c.v[k];
    g[k].w = c.w[k];
    g[k].x = Vec3(0.03, 0.03, 0.03);
  }
  g[1].x[0] += c.r[0] + c.r[1] + kGap;
  Solver solver(s, g);
  bool touched = false;
  for (long k = 0; k < 1000000; ++k) {
    solver.step(1);
    const bool touching = solver.counters().touching > 0;
    if (touched && !touching) break;
    touched = touching;
  }
  End e;
  const auto after = solver.grains();
  for (std::size_t k = 0; k < 2; ++k) e.v[k] = after[k].v, e.w[k] = after[k].w;
  return e;
}

/// The same steps of the same law: what differs is rounding and the order of operations, 1e-9 of the speeds; half of any term changes
/// the end by 1e-4 and more.
void expect_same(const Impact& c, const End& hand) {
  const End solver = by_solver(c);
  for (int k = 0; k < 2; ++k) {
    EXPECT_LT((solver.v[k] - hand.v[k]).norm(), 1e-6 * 0.5) << "sphere " << k;
    EXPECT_LT((solver.w[k] - hand.w[k]).norm(), 1e-6 * 40) << "sphere " << k;
  }
}

TEST(ContactLaw, IsTheOneOfTheEquationsWithFrictionAndRolling) {
  for (const Cap cap : {Cap::sum, Cap::springs})
    for (const auto stiffness : {TangentialStiffness::mindlin, TangentialStiffness::printed})
      for (const double friction : {0.25, 0.8}) {
        SCOPED_TRACE(friction);
        Impact c;
        c.law.cap = cap;
        c.law.tangential = stiffness;
        c.friction = friction;
        const End hand = by_hand(c);
        EXPECT_GT(hand.slid, 0.02 * hand.time);  // both sticking and sliding are there
        EXPECT_LT(hand.slid, 0.98 * hand.time);
        EXPECT_GT(hand.rolled_at_limit, 0);
        EXPECT_LT(hand.rolled_at_limit, 0.9 * hand.time);
        expect_same(c, hand);
      }
}

TEST(ContactLaw, HasTheRateDependentRollingOfTheEquations) {
  for (const auto rolling : {RollingCoefficient::rate, RollingCoefficient::rate_without_spin})
    for (const double coefficient : {10.0, 200.0}) {  // [s2/m2]: below the cap of 1 all along, and at it for a while
      SCOPED_TRACE(coefficient);
      Impact c;
      c.law.rolling = rolling;
      c.rolling = coefficient;
      const End hand = by_hand(c);
      if (coefficient < 100)
        EXPECT_EQ(hand.capped_at_one, 0);
      else
        EXPECT_GT(hand.capped_at_one, 0.02 * hand.time);
      expect_same(c, hand);
    }
}

}  // namespace
