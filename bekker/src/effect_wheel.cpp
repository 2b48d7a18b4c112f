#include "grouser/bekker/effect_wheel.h"

#include <algorithm>

#include "gauss_rule.h"
#include "load_root.h"

namespace grouser::bekker {

namespace effect_detail {

const Rule& rule() {
  static const Rule r = [] {
    const GaussRule& g = gauss_rule(kPoints);
    Rule out{};
    for (std::size_t i = 0; i < kPoints; ++i) {
      out.x[i] = g.x[i];
      out.w[i] = g.w[i];
      out.x2[i] = g.x[i] * g.x[i];
      out.w2[i] = 2 * g.x[i] * g.w[i];
    }
    return out;
  }();
  return r;
}

namespace {

constexpr double kNear = 4, kFar = 18;  // |j|/K where a layer is cut
constexpr double kRoom = 1.6;  // a layer that takes more than 1/kRoom of the way to the next cut is left in one piece

/// Path slid from the entry to u behind it, and its slope.
struct Path {
  const Shape& s;
  double at(double u) const {
    return s.shear_radius * u - 2 * s.kappa_r * std::sin(0.5 * u) * std::cos(s.theta_f - 0.5 * u);
  }
  double slope(double u) const { return s.shear_radius - s.kappa_r * std::cos(s.theta_f - u); }
};

/// u in lo..hi with j(u) = level, j monotone there. A fixed number of steps, so that the place moves smoothly with the state.
double where(const Path& j, double level, double lo, double hi, int steps) {
  const bool rising = j.at(hi) > j.at(lo);
  double u = 0.5 * (lo + hi);
  for (int i = 0; i < steps; ++i) {
    const double f = j.at(u) - level;
    ((f > 0) == rising ? hi : lo) = u;
    const double slope = j.slope(u), next = u - f / slope;
    u = slope != 0 && next > lo && next < hi ? next : 0.5 * (lo + hi);
  }
  return u;
}

struct Cut {
  double u;
  End end;
};

class Cuts {
 public:
  void add(double u, End end) {
    int i = n_++;
    for (; i > 0 && cut_[static_cast<std::size_t>(i - 1)].u > u; --i)
      cut_[static_cast<std::size_t>(i)] = cut_[static_cast<std::size_t>(i - 1)];
    cut_[static_cast<std::size_t>(i)] = {u, end};
  }
  int size() const { return n_; }
  const Cut& operator[](int i) const { return cut_[static_cast<std::size_t>(i)]; }

 private:
  std::array<Cut, 16> cut_{};
  int n_ = 0;
};

/// Layers on the way from j(a) = 0 towards b.
void add_layers(const Path& j, double a, double b, Cuts& cuts) {
  const double end = std::abs(j.at(b)), sign = j.at(b) > 0 ? 1 : -1;
  for (const double level : {kNear, kFar}) {
    if (end < kRoom * level * j.s.K) return;
    const double u = where(j, sign * level * j.s.K, std::min(a, b), std::max(a, b), 12);
    cuts.add(u, {Anchor::entry, u});
  }
}

}  // namespace

Layout layout_of(const Shape& s) noexcept {
  Cuts cuts;
  cuts.add(0, {Anchor::entry, 0});
  const double u_m = s.theta_f - s.theta_m, u_r = s.theta_f - s.theta_r;
  cuts.add(u_m, {Anchor::theta_m, 0});
  cuts.add(u_r, {Anchor::exit, 0});
  const bool locked = std::isinf(s.kappa_r);
  double u_turn = 1e300, u_back = 1e300;
  if (!locked) {
    const Path j{s};
    const double turn = s.kappa_r > s.shear_radius ? std::acos(s.shear_radius / s.kappa_r) : -1;
    if (turn > s.theta_r && turn < s.theta_f && turn >= 0) {  // slides forward at the entry, backward below
      u_turn = s.theta_f - turn;
      cuts.add(u_turn, {Anchor::turn, 0});
      add_layers(j, 0, u_turn, cuts);
      double last = u_r;
      if (-turn > s.theta_r) {
        u_back = s.theta_f + turn;
        cuts.add(u_back, {Anchor::mirrored_turn, 0});
        last = u_back;
      }
      if (j.at(last) < 0) {
        const double u0 = where(j, 0, u_turn, last, 60);
        cuts.add(u0, {Anchor::entry, u0});
        add_layers(j, u0, u_turn, cuts);
        add_layers(j, u0, last, cuts);
        if (last < u_r && j.at(u_r) > 0) {
          const double u1 = where(j, 0, last, u_r, 60);
          cuts.add(u1, {Anchor::entry, u1});
          add_layers(j, u1, u_r, cuts);
        }
      }
    } else if (turn >= s.theta_f && -turn > s.theta_r) {
      u_back = s.theta_f + turn;
      cuts.add(u_back, {Anchor::mirrored_turn, 0});
      add_layers(j, 0, u_back, cuts);
    } else {
      add_layers(j, 0, u_r, cuts);
    }
  }
  Layout out;
  const double least = 1e-12 * u_r;
  for (int i = 0; i + 1 < cuts.size(); ++i) {
    const Cut &a = cuts[i], &b = cuts[i + 1];
    if (!(b.u - a.u > least) || out.count == static_cast<int>(out.piece.size())) continue;
    const double middle = 0.5 * (a.u + b.u);
    Piece& p = out.piece[static_cast<std::size_t>(out.count++)];
    p = {a.end, b.end, middle > u_m, i == 0, false, 1};
    p.root_to = p.rear && i + 2 == cuts.size();
    if (!locked) p.direction = s.shear_radius > s.kappa_r * std::cos(s.theta_f - middle) ? 1 : -1;
  }
  return out;
}

}  // namespace effect_detail

namespace {

constexpr double kHub = 1.57079632679489661923;

/// From the pressure alone: a parabola over the arc.
double first_guess(const EffectWheel& w, const WheelState<double>& q) {
  const double share = std::min(q.a0 + q.a1 * std::abs(q.slip), 0.95);
  const double depth = 0.5 * w.radius * (1 - share * share), mean = 0.6;
  const double scale = w.radius * w.width * mean * q.k * std::pow(depth / w.reference_width, q.n);
  return std::min(std::pow(q.load / scale, 1 / (2 * q.n + 1)), 1.2);
}

}  // namespace

ForceStatus effect_equilibrium(const EffectWheel& w, const EffectCondition& run, const WheelState<double>& q,
                               double guess, double& theta_f, WheelAnswer<double>& answer) noexcept {
  const bool good = q.k > 0 && q.n > 0.02 && q.n < 20 && q.c >= 0 && q.phi >= 0 && q.phi < 1.5 && q.K > 0 &&
                    q.load > 0 && q.slip >= -1 && q.slip < 1 && q.slip == q.slip;
  if (!good) return ForceStatus::bad_argument;
  bool reached = true;
  double top = kHub;
  if (q.on(Effect::hard_pan) && q.of(Effect::hard_pan) * w.radius > 1)  // the pan stops the wheel above its hub
    top = 0.9999 * std::acos(1 - 1 / (q.of(Effect::hard_pan) * w.radius));
  const auto ratio = [&](double theta) {
    reached = effect_forces(w, run, q, theta, answer);
    return reached ? answer.Fz / q.load : 0.0;
  };
  RootRange range;
  range.hi = top;
  range.guess = std::min(guess > 0 ? guess : first_guess(w, q), 0.999 * top);
  range.exponent = 2 * q.n + 1;
  range.tolerance = 1e-9;
  const LoadRoot root = load_root(ratio, range);
  theta_f = root.theta;
  if (!reached) return ForceStatus::no_pressure;
  return root.end == RootEnd::not_reached ? ForceStatus::too_soft : ForceStatus::ok;
}

}  // namespace grouser::bekker
