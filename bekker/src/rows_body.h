// Included by kernel_body.h: arcs of several wheels in the lanes.
#include "rows.h"
#include "stress.h"

namespace grouser::bekker {
namespace {

/// The part of Arc that a driven smooth wheel on virgin soil has.
struct RowArc {
  static constexpr bool kFeatures = false;
  static constexpr bool kTenDigits = true;
  ShearLaw::Type type;
  bool anisotropic;
  Lanes r, theta_f, theta_m, theta_r, modulus, n, cohesion, tan_phi, inv_K, Kr, hump{};
  Lanes sin_half, cos_half, sin_f, cos_f;
  struct {
    Lanes t, l;
  } e;

  RowArc(const Rows& rows, int first, ShearLaw::Type shear, bool sideways) : type(shear), anisotropic(sideways) {
    const auto of = [&](Rows::Value v) { return load(&rows.value[v][first]); };
    r = of(Rows::radius);
    theta_f = of(Rows::theta_f);
    theta_m = of(Rows::theta_m);
    theta_r = of(Rows::theta_r);
    modulus = of(Rows::modulus);
    n = of(Rows::exponent);
    cohesion = of(Rows::cohesion);
    tan_phi = of(Rows::tan_phi);
    inv_K = of(Rows::inv_K);
    e = {of(Rows::e_t), of(Rows::e_l)};
    if (type == ShearLaw::Type::C) {
      constexpr double euler = 2.718281828459045235;
      Kr = of(Rows::Kr);
      hump = euler * (1 / (Kr * (1 - 1 / euler)) - 1);
    }
    const SinCos<Lanes> half = sin_cos_half(0.5 * theta_f);
    sin_half = half.sin;
    cos_half = half.cos;
    sin_f = 2 * half.sin * half.cos;
    cos_f = (half.cos - half.sin) * (half.cos + half.sin);
  }
};

constexpr double kRowPower = 0.8;  // of n: below it the entry takes the third power

template <bool kFront>
GROUSER_INLINE void add_row_points(const RowArc& a, const RowRule& rule, Lanes (&sum)[6], Lanes (&null)[3]) {
  const Lanes length = kFront ? a.theta_f - a.theta_m : a.theta_m - a.theta_r;
  const Lanes stretch = kFront ? splat(1) : (a.theta_f - a.theta_m) / length, arc = a.theta_f - a.theta_r;
  const Bits third = a.n < kRowPower;
  for (int i = 0; i < rule.n; ++i) {
    const Lanes s = length * select(third, splat(rule.x[1][i]), splat(rule.x[0][i]));
    const Lanes w = length * select(third, splat(rule.w[1][i]), splat(rule.w[0][i]));
    const Place<Lanes> place = kFront ? Place<Lanes>{s, s, s} : Place<Lanes>{arc - s, s * stretch, s};
    const StressPoint<Lanes> p = stress_of<false>(a, place, kFront);
    const Lanes sigma = w * p.sigma, t = w * p.tau_t, l = w * p.tau_l;
    add_wrench(p, sigma, t, l, sum);
    null[0] += rule.null[i] * sigma;
    null[1] += rule.null[i] * t;
    null[2] += rule.null[i] * l;
  }
}

void integrate_rows(const Rows& rows, ShearLaw::Type type, bool anisotropic, const RowRule& front, const RowRule& rear,
                    RowSums& out) {
  for (int first = 0; first < Rows::kSize; first += kLanes) {
    const RowArc a(rows, first, type, anisotropic);
    Lanes sum[6] = {}, ahead[3] = {}, behind[3] = {};
    add_row_points<true>(a, front, sum, ahead);
    add_row_points<false>(a, rear, sum, behind);
    const Lanes force = sqrt_of(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    const Lanes moment = sqrt_of(sum[3] * sum[3] + sum[4] * sum[4] + sum[5] * sum[5]);
    const auto rough = [&](const Lanes(&null)[3], double limit) {
      const Lanes shear = abs_of(null[1]) + abs_of(null[2]);
      return (abs_of(null[0]) + shear > limit * force) | (shear > limit * moment + 1e-32 * force);
    };
    const Bits bad = rough(ahead, front.limit) | rough(behind, rear.limit);
    const Lanes rb = a.r * load(&rows.value[Rows::width][first]), rrb = rb * a.r;
    for (int i = 0; i < 6; ++i) store(&out.wrench[i][first], (i < 3 ? rb : rrb) * sum[i]);
    for (int i = 0; i < kLanes; ++i) out.smooth[first + i] = bad[i] == 0;
  }
}

/// How many of `limits` x reaches.
template <std::size_t kCount>
GROUSER_INLINE Lanes reached(Lanes x, const double (&limits)[kCount]) {
  Lanes count{};
  for (const double limit : limits) count += select(x >= limit, splat(1), splat(0));
  return count;
}

// Chosen so that a piece errs by less than 2e-7 of the force or moment (bekker/README.md).
constexpr double kFrontLimits[] = {5, 25, 150, 400, 1500, 6000, 20000};    // K slid over the piece, from 10 points on
constexpr double kRearLimits[] = {2.5, 2.5, 15, 100, 1e3, 1e4, 1e5, 1e6};  // from 8 points on
// The exit's map doubles that at theta_m: rules for exp(-ahead - 2 behind x), from 10 points on, at ahead = 0 and
// more of them for each unit of it.
constexpr double kBuildLimits[] = {5, 8, 12, 25, 40, 57, 100, 220}, kBuildGains[] = {0.6, 1, 1.5, 2.5, 3.2, 4, 7, 12};
constexpr double kTurnLimits[] = {5.2755, 3.9418, 3.2929, 2.6972, 2.4375, 2.3008, 2.1673, 2.0738};  // 2 cosh(13/n)

constexpr double kDying = 200;  // twice the K slid over the arc, of type B, from which a row goes alone
constexpr double kEven[] = {2, 4, 6, 8};

GROUSER_INLINE Lanes build_class(Lanes behind, Lanes ahead) {
  Lanes count{};
  for (int i = 0; i < kRowClasses; ++i)
    count += select(behind >= kBuildLimits[i] + kBuildGains[i] * ahead, splat(1), splat(0));
  return count;
}

/// The class that the turn of the shear direction asks for on theta in lo..hi. Its complex root +-re + i im lies on an
/// ellipse about the piece with rho the sum of the half axes, and the error falls like rho^(-2 n).
GROUSER_INLINE Lanes turn_class(Lanes lo, Lanes hi, Lanes re, Lanes im) {
  const Lanes scale = 2 / (hi - lo), x = scale * abs_of(abs_of(0.5 * (lo + hi)) - re), y = scale * im;
  const Lanes twice = sqrt_of((x - 1) * (x - 1) + y * y) + sqrt_of((x + 1) * (x + 1) + y * y);  // rho + 1/rho
  return static_cast<double>(kRowClasses) - reached(twice, kTurnLimits);
}

void plan_rows(Rows& rows, ShearLaw::Type type, bool anisotropic, RowPlan& plan) {
  const bool steep = anisotropic || type != ShearLaw::Type::A;
  for (int first = 0; first < Rows::kSize; first += kLanes) {
    const Lanes kappa = 1 - load(&rows.value[Rows::e_t][first]);
    const SinCos<Lanes> beta = sin_cos_half(load(&rows.value[Rows::e_l][first]));
    store(&rows.value[Rows::e_l][first], kappa * beta.sin / beta.cos);
    const RowArc a(rows, first, type, anisotropic);

    const Lanes v = 1 - kappa * a.cos_f, side = abs_of(a.e.l);
    const Lanes sharp = (steep ? 2.0 : 1.0) * a.r * a.inv_K * sqrt_of(v * v + side * side);
    const Lanes third = select(a.n < kRowPower, splat(1.7), splat(1));
    const Lanes ahead = sharp * (a.theta_f - a.theta_m), behind = third * sharp * (a.theta_m - a.theta_r);
    const double bump = steep ? 1 : 0, complete = anisotropic ? 1e300 : (steep ? 120 : 40);
    Lanes front = 1 + bump + reached(ahead, kFrontLimits);
    const Lanes rest = select(a.theta_m - a.theta_r >= 0.8, splat(2), splat(0));
    const Lanes built = max_of(reached(behind, kRearLimits), build_class(behind, ahead));
    Lanes rear = bump + select(ahead >= complete, rest, built);
    if (steep) {  // fewer groups
      front = 1 + 2 * reached(front, kEven);
      rear = 1 + 2 * reached(rear, kEven);
    }
    if (!anisotropic) {
      // 2 sin(theta/2) of the root of cos theta = (1 + i e_l)/kappa; spinning on the spot and e_l = 0 never turn.
      const Lanes inverse = 1 / max_of(kappa, splat(1e-3)), A = 2 - 2 * inverse, B = 2 * side * inverse;
      const Lanes im2 = max_of(0.5 * (sqrt_of(A * A + B * B) - A), splat(1e-300));
      const Lanes im = select(side > 0, sqrt_of(im2), splat(1e3)), re = 0.5 * B / im;
      front = max_of(front, turn_class(a.theta_m, a.theta_f, re, im));
      rear = max_of(rear, turn_class(a.theta_r, a.theta_m, re, im));
    }
    // Where the shear of type B dies out near the entry, what is left of the moment comes from that layer alone, which
    // is cut off in the single-row way.
    const bool dies = type == ShearLaw::Type::B;
    const Lanes slid = sharp * (a.theta_f - a.theta_r);
    for (int i = 0; i < kLanes; ++i) {
      const bool fits = front[i] < kRowClasses && rear[i] < kRowClasses && !(dies && slid[i] > kDying);
      plan.front[first + i] = fits ? static_cast<signed char>(front[i]) : -1;
      plan.rear[first + i] = fits ? static_cast<signed char>(rear[i]) : -1;
    }
  }
}

}  // namespace
}  // namespace grouser::bekker
