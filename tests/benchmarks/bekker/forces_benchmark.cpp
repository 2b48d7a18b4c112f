// Cost of wheel forces, equilibria and batches on one core, each also as a ratio to adaptive Simpson quadrature with
// the C library's functions, and against the time of the functions alone. Least of many repeats on one fixed set of
// random wheels; the spread is the median over the least.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "functions_alone.h"
#include "grouser/bekker/forces.h"
#include "grouser/bekker/table.h"
#include "kernel.h"
#include "pieces.h"
#include "rows.h"

namespace {

using namespace grouser;
using namespace grouser::bekker;

constexpr int kRows = 1000;

/// Smooth wheels on virgin soil of type A, driven at slip 0.02 to 0.9 with slip angles within 23 degrees.
LoadCase load_row(std::mt19937_64& rng, ForceCase& at) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto u = [&](double lo, double hi) { return lo + (hi - lo) * uniform(rng); };
  ForceCase c;
  c.wheel = {u(0.05, 0.5), u(0.05, 0.3)};
  c.soil.n = u(0.4, 1.4);
  c.soil.modulus = std::pow(10, u(4.5, 6.5));
  c.soil.shear = {ShearLaw::Type::A, u(0, 4000), u(0.2, 0.7), std::pow(10, u(-3, -1.5)), 0.01, 0.7};
  c.soil.tan_phi = std::tan(c.soil.shear.friction_angle);
  c.slip = u(0.02, 0.9);
  c.slip_angle = u(-0.4, 0.4);
  c.arc.theta_f = u(0.2, 1.0);
  c.arc.theta_m = (c.soil.angles.a0 + c.soil.angles.a1 * c.slip) * c.arc.theta_f;
  c.soil.angles.b0 = u(0, 0.3) * static_cast<double>(rng() % 2);
  c.arc.theta_r = -c.soil.angles.b0 * c.arc.theta_f;
  at = c;
  return {c.wheel, c.soil, forces(c, Method::nonlinear, 1e-6).wrench.Fz, c.slip, c.slip_angle, 0};
}

/// The straightforward way: the six densities of eq 2.11 at a point with the C library's functions, adaptive Simpson on
/// each branch until the six components change by less than 1e-8 of the force (moments over r).
class Simpson {
 public:
  explicit Simpson(const ForceCase& c) : c_(c), kappa_(1 - c.slip), side_(kappa_ * std::tan(c.slip_angle)) {}
  using Six = std::array<double, 6>;
  Six integral() {
    Six sum{};
    const double cuts[] = {c_.arc.theta_r, c_.arc.theta_m, c_.arc.theta_f};
    double scale = 0;
    for (int i = 0; i < 2; ++i) {
      const double a = cuts[i], b = cuts[i + 1];
      const Six fa = density(a), fm = density(0.5 * (a + b)), fb = density(b);
      scale += std::abs((b - a) / 6 * (fa[2] + 4 * fm[2] + fb[2]));
    }
    for (int i = 0; i < 2; ++i) {
      const double a = cuts[i], b = cuts[i + 1];
      if (!(b > a)) continue;
      const Six fa = density(a), fm = density(0.5 * (a + b)), fb = density(b);
      add(a, b, fa, fm, fb, rule(a, b, fa, fm, fb), 1e-8 * scale, 40, sum);
    }
    for (int k = 0; k < 6; ++k) sum[k] *= c_.wheel.radius * c_.wheel.width * (k < 3 ? 1 : c_.wheel.radius);
    return sum;
  }

 private:
  Six density(double t) const {
    const double f = c_.arc.theta_f, m = c_.arc.theta_m, r0 = c_.arc.theta_r, r = c_.wheel.radius;
    const double te = t >= m ? t : f - (t - r0) * (f - m) / (m - r0);
    const double z = r * (std::cos(te) - std::cos(f)), sigma = z > 0 ? c_.soil.modulus * std::pow(z, c_.soil.n) : 0;
    const double jt = r * ((f - t) - kappa_ * (std::sin(f) - std::sin(t))), jl = r * side_ * (f - t);
    const double tau = (c_.soil.shear.cohesion + sigma * c_.soil.tan_phi) *
                       (1 - std::exp(-std::sqrt(jt * jt + jl * jl) / c_.soil.shear.K));
    const double vt = 1 - kappa_ * std::cos(t), v = std::sqrt(vt * vt + side_ * side_);
    const double tt = tau * vt / v, tl = tau * side_ / v, s = std::sin(t), c = std::cos(t);
    return {-sigma * s + tt * c, -tl, sigma * c + tt * s, -tl * c, -tt, -tl * s};
  }
  static Six rule(double a, double b, const Six& fa, const Six& fm, const Six& fb) {
    Six out;
    for (int k = 0; k < 6; ++k) out[k] = (b - a) / 6 * (fa[k] + 4 * fm[k] + fb[k]);
    return out;
  }
  void add(double a, double b, const Six& fa, const Six& fm, const Six& fb, const Six& whole, double tolerance,
           int depth, Six& sum) const {
    const double m = 0.5 * (a + b);
    const Six fl = density(0.5 * (a + m)), fr = density(0.5 * (m + b));
    const Six left = rule(a, m, fa, fl, fm), right = rule(m, b, fm, fr, fb);
    double gap = 0;
    for (int k = 0; k < 6; ++k) gap = std::max(gap, std::abs(left[k] + right[k] - whole[k]));
    if (depth == 0 || gap < 15 * tolerance) {
      for (int k = 0; k < 6; ++k) sum[k] += left[k] + right[k] + (left[k] + right[k] - whole[k]) / 15;
      return;
    }
    add(a, m, fa, fl, fm, left, 0.5 * tolerance, depth - 1, sum);
    add(m, b, fm, fr, fb, right, 0.5 * tolerance, depth - 1, sum);
  }
  ForceCase c_;
  double kappa_, side_;
};

/// Bisection on the entry angle with Simpson's Fz to 1e-8 of the load.
double simpson_solve(const LoadCase& l) {
  double lo = 0, hi = pi / 2;
  ForceCase c{l.wheel, l.soil, {}, l.slip, l.slip_angle, 0};
  for (int i = 0; i < 60; ++i) {
    c.arc.theta_f = 0.5 * (lo + hi);
    c.arc.theta_m = (l.soil.angles.a0 + l.soil.angles.a1 * l.slip) * c.arc.theta_f;
    c.arc.theta_r = -l.soil.angles.b0 * c.arc.theta_f;
    const double Fz = Simpson(c).integral()[2];
    if (std::abs(Fz - l.load) < 1e-8 * l.load) break;
    (Fz < l.load ? lo : hi) = c.arc.theta_f;
  }
  return c.arc.theta_f;
}

double sink = 0;  // printed at the end, so that nothing is optimised away

struct Time {
  double ns, spread;  ///< least, and median over least
};
template <class F>
Time time_of(F&& run, int rows, int repeats) {
  std::vector<double> t;
  for (int k = 0; k < repeats; ++k) {
    const auto start = std::chrono::steady_clock::now();
    run();
    t.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() / rows);
  }
  std::sort(t.begin(), t.end());
  return {t.front(), t[t.size() / 2] / t.front()};
}

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace

int main() {
  std::mt19937_64 rng(1);
  std::vector<ForceCase> cases(kRows);
  std::vector<LoadCase> loads;
  for (ForceCase& c : cases) loads.push_back(load_row(rng, c));
  std::vector<ForceResult> results(kRows);

  // Vectors of points that one pass over the set takes: what the functions alone are timed for.
  const FunctionsAlone alone = functions_alone();
  double front = 0, rear = 0;
  for (const ForceCase& c : cases) {
    const Arc arc(c);
    const Pieces pieces = pieces_of(arc, 1e-6);
    for (int i = 0; i < pieces.count; ++i)
      (pieces.at[i].piece.front ? front : rear) +=
          kRuleSizes[pieces.at[i].size] / static_cast<double>(alone.lanes) / kRows;
  }

  // The same of a batch: one row to a lane. All these rows are taken by the lanes.
  double front_rows = 0, rear_rows = 0;
  for (const ForceCase& c : cases) {
    Rows rows;
    for (int i = 0; i < Rows::kSize; ++i) rows.set(i, c);
    RowPlan plan;
    kernel().plan_rows(rows, c.soil.shear.type, false, plan);
    if (plan.front[0] < 0) continue;
    front_rows += kRowSizes[plan.front[0]] / static_cast<double>(alone.lanes) / kRows;
    rear_rows += kRowSizes[plan.rear[0]] / static_cast<double>(alone.lanes) / kRows;
  }

  const auto force_pass = [&](Method m, double tolerance) {
    return [&cases, m, tolerance] {
      for (const ForceCase& c : cases) sink += forces(c, m, tolerance).wrench.Fx;
    };
  };
  const auto solve_pass = [&](Method m) {
    return [&loads, m] {
      for (const LoadCase& l : loads) sink += solve(l, m, 1e-6).arc.theta_f;
    };
  };
  const Time simpson = time_of(
      [&] {
        for (const ForceCase& c : cases) sink += Simpson(c).integral()[0];
      },
      kRows, 5);
  const Time simpson_root = time_of(
      [&] {
        for (int i = 0; i < 50; ++i) sink += simpson_solve(loads[i]);
      },
      50, 3);
  const Time functions_front = time_of([&] { sink += alone.front(kRows); }, kRows, 100);
  const Time functions_rear = time_of([&] { sink += alone.rear(kRows); }, kRows, 100);
  const double functions = front * functions_front.ns + rear * functions_rear.ns;
  const double functions_rows = front_rows * time_of([&] { sink += alone.front_ten(kRows); }, kRows, 100).ns +
                                rear_rows * time_of([&] { sink += alone.rear_ten(kRows); }, kRows, 100).ns;
  const double functions_quadratic = functions_front.ns;  // five stresses, one vector

  double worst = 0;
  for (const ForceCase& c : cases) {
    const auto a = Simpson(c).integral();
    const WheelWrench b = forces(c, Method::nonlinear, 1e-6).wrench;
    worst = std::max(worst, std::hypot(a[0] - b.Fx, a[1] - b.Fy, a[2] - b.Fz) / std::hypot(a[0], a[1], a[2]));
  }

  std::printf("%s, %s kernel, gcc %s; one core, %d random wheels, least of repeats\n", processor().c_str(),
              kernel().name, __VERSION__, kRows);
  std::printf(
      "points of nonlinear forces at 1e-6: %.1f ahead of theta_m, %.1f behind; largest difference to Simpson %.1e of "
      "|F|\n",
      front * alone.lanes, rear * alone.lanes, worst);
  std::printf("points of a batch: %.1f and %.1f\n", front_rows * alone.lanes, rear_rows * alone.lanes);
  std::printf("%-34s %10s %8s %12s %12s\n", "", "ns", "spread", "Simpson/it", "it/functions");
  const auto line = [](const char* name, Time t, double baseline, double floor) {
    std::printf("%-34s %10.0f %8.2f %12.1f", name, t.ns, t.spread, baseline / t.ns);
    if (floor > 0) {
      std::printf(" %12.1f\n", t.ns / floor);
    } else {
      std::printf(" %12s\n", "-");
    }
  };
  line("adaptive Simpson 1e-8, forces", simpson, simpson.ns, 0);
  line("adaptive Simpson 1e-8, solve", simpson_root, simpson_root.ns, 0);
  line("quadratic forces", time_of(force_pass(Method::quadratic, 1e-6), kRows, 60), simpson.ns, functions_quadratic);
  line("quadratic solve", time_of(solve_pass(Method::quadratic), kRows, 30), simpson_root.ns, 0);
  line("nonlinear forces 1e-6", time_of(force_pass(Method::nonlinear, 1e-6), kRows, 60), simpson.ns, functions);
  line("nonlinear forces 1e-10", time_of(force_pass(Method::nonlinear, 1e-10), kRows, 20), simpson.ns, 0);
  line("nonlinear solve 1e-6", time_of(solve_pass(Method::nonlinear), kRows, 20), simpson_root.ns, 0);
  line("batch of nonlinear forces 1e-6", time_of([&] { forces(cases, Method::nonlinear, 1e-6, results); }, kRows, 60),
       simpson.ns, functions_rows);
  // One wheel on one soil, asked at the same random points again and again.
  TableSpec spec;
  spec.wheel = {0.13, 0.16};
  spec.soil.modulus = 2.541e5 / std::pow(0.05, 1.387);
  spec.soil.n = 1.387;
  spec.soil.shear = {ShearLaw::Type::A, 139.28, 0.606, 5.151e-4, 0, 1};
  spec.soil.tan_phi = std::tan(0.606);
  spec.slip = {0, 0.8};
  spec.load = {60, 230};
  spec.unloading_sinkage = {0, 0};
  const WheelTable table = WheelTable::build(spec);
  std::vector<std::array<double, 2>> asked(kRows);
  std::uniform_real_distribution<double> slips(0, 0.8), newtons(60, 230);
  for (auto& [slip, load] : asked) slip = slips(rng), load = newtons(rng);
  line("table query",
       time_of(
           [&] {
             TablePoint out;
             for (const auto& [slip, load] : asked) {
               table.query(slip, load, 0, out);
               sink += out.thrust;
             }
           },
           kRows, 100),
       simpson_root.ns, 0);
  std::printf(
      "functions alone: %.1f ns per vector of %d ahead of theta_m, %.1f behind; %.0f ns per wheel, %.0f in a batch\n",
      functions_front.ns, alone.lanes, functions_rear.ns, functions, functions_rows);
  std::printf("(checksum %.6g)\n", sink);
}
