#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <optional>

#include "grouser/bekker/forces.h"

namespace grouser::bekker {

namespace {

constexpr double kTorque = 1e-9;               // of |torque| + load r
constexpr double kFirst = 0.2;                 // of the slip that adds K to the sliding over the arc
constexpr double kLeast = 2e-5;                // first slip
constexpr double kTurn = 0.1;                  // of theta_f^2: a braked wheel's sliding turns over within the arc
constexpr double kGrowth = 1.4, kWide = 0.05;  // steps of slip
constexpr double kBend = 4;                    // times what three samples say of the way between two
constexpr double kStraight = 0.3;              // of the rise: less sag at half way, and a root between is the only one
constexpr int kDeepest = 26;                   // halvings of a step

constexpr int kMost = 64;  // slips a side

/// Slips from 0 to 1: steps grow from a share of the slip that matters at small slip, and shrink again towards the
/// locked wheel.
struct Slips {
  std::array<double, kMost> at;
  int count = 0;
  explicit Slips(double first) {
    at[count++] = 0;
    for (double s = first; s < 0.86; s += std::min((kGrowth - 1) * s, kWide)) at[count++] = s;
    for (double rest = 0.1; rest > 1e-3; rest *= 0.5) at[count++] = 1 - rest;
    at[count++] = 1;
  }
};

/// Excess of the wheel's torque over the wanted one at a slip side * x^2: under braking the torque goes with the root
/// of the slip.
struct Sample {
  double x, excess;
  bool valid;  ///< there is an equilibrium
};

/// Those taken so far on one side.
struct Track {
  std::array<Sample, kMost> at;
  int count = 0;
};

class FreeSlip {
 public:
  FreeSlip(const LoadCase& c, double torque, Method method, double tolerance)
      : case_(c), torque_(torque), method_(method), tolerance_(tolerance) {
    const double scale = std::abs(torque) + c.load * c.wheel.outer_radius();
    allowed_ = kTorque * scale;
    // Where the rules of the integral change from slip to slip the torque steps by less than the tolerance.
    step_ = method == Method::nonlinear ? std::max(kTorque, tolerance) * scale : allowed_;
  }

  Solution run() {
    if (!std::isfinite(torque_)) return named(ForceStatus::bad_argument);
    const Sample rest = at(0);
    carried_ = rest.valid;
    if (!rest.valid && last_.status == ForceStatus::bad_argument) return last_;
    if (meets(rest)) return last_;
    const ForceStatus still = last_.status;
    const double arc = rest.valid ? last_.arc.theta_f : 0.5, K = case_.soil.shear_displacement();
    const double builds = kFirst * K / (case_.wheel.outer_radius() * arc), turns = kTurn * arc * arc;
    slips_ = Slips(std::clamp(std::min(builds, turns), kLeast, 5e-3));
    towards_ = rest.excess < 0 || !rest.valid ? 1 : -1;
    for (Track& side : along_) side.at[side.count++] = rest;
    const int steps = slips_.count - 1;
    if (grows()) {
      for (const int k : {0, 1})
        for (int i = 0; i < steps; ++i)
          if (const auto found = in_step(k, i)) return answer(k, *found);
    } else {
      for (int i = 0; i < steps; ++i) {
        const auto near = in_step(0, i), far = in_step(1, i);
        if (near || far) return near && !(far && far->x < near->x) ? answer(0, *near) : answer(1, *far);
      }
    }
    return named(carried_ ? ForceStatus::torque_not_reached : still);
  }

 private:
  /// Driven, the torque of type A grows with slip, and braked with its size: the side to look at first is known.
  bool grows() const { return case_.soil.shear.type == ShearLaw::Type::A && case_.soil.lateral == Lateral::isotropic; }
  /// On side k, 0 being that towards the wanted torque, between the slips i and i + 1.
  std::optional<Sample> in_step(int k, int i) {
    side_ = k == 0 ? towards_ : -towards_;
    Track& s = along_[k];
    for (; s.count < std::min(i + 3, slips_.count); ++s.count) s.at[s.count] = at(std::sqrt(slips_.at[s.count]));
    carried_ |= s.at[i + 1].valid;
    return first_root(s.at[i], s.at[i + 1], bend(s, i), 0);
  }
  Solution answer(int k, const Sample& found) {
    side_ = k == 0 ? towards_ : -towards_;
    at(found.x);
    return last_;
  }
  Sample at(double x) {
    case_.slip = side_ * x * x;
    last_ = solve(case_, method_, tolerance_);
    const bool valid = last_.status == ForceStatus::ok || last_.status == ForceStatus::tolerance_not_met;
    return {x, -last_.wrench.My - torque_, valid};
  }
  bool meets(const Sample& s) const { return s.valid && std::abs(s.excess) <= allowed_; }
  Solution named(ForceStatus status) const {
    Solution s = last_;
    s.status = status;
    return s;
  }

  /// How far the torque between samples i and i + 1 may lie from the straight line, from parabolas with a neighbour.
  static double bend(const Track& track, int i) {
    const auto& s = track.at;
    const double width = s[i + 1].x - s[i].x;
    double most = 0;
    bool known = false;
    for (const int a : {i - 1, i}) {
      if (a < 0 || a + 2 >= track.count || !(s[a].valid && s[a + 1].valid && s[a + 2].valid)) continue;
      const double lower = (s[a + 1].excess - s[a].excess) / (s[a + 1].x - s[a].x);
      const double upper = (s[a + 2].excess - s[a + 1].excess) / (s[a + 2].x - s[a + 1].x);
      most = std::max(most, std::abs(upper - lower) / (s[a + 2].x - s[a].x) * 0.25 * width * width);
      known = true;
    }
    return known ? most : std::abs(s[i + 1].excess - s[i].excess);
  }

  /// The first slip from a on to b that meets the torque. Halves the way wherever the torque could turn on it by as
  /// much as is missing.
  std::optional<Sample> first_root(const Sample& a, const Sample& b, double sag, int depth) {
    if (meets(b) && depth == kDeepest) return b;
    if (!a.valid && !b.valid) return {};
    const bool both = a.valid && b.valid, crosses = both && (a.excess < 0) != (b.excess < 0);
    if (both && !crosses && std::min(std::abs(a.excess), std::abs(b.excess)) > kBend * sag) return {};
    if (depth == kDeepest) return crosses ? root(a, b) : std::nullopt;
    const Sample m = at(0.5 * (a.x + b.x));
    double below = 0;
    if (both && m.valid) {
      below = std::abs(m.excess - 0.5 * (a.excess + b.excess));
      if (crosses && below <= kStraight * std::abs(b.excess - a.excess))
        return (a.excess < 0) != (m.excess < 0) ? root(a, m) : root(m, b);
      below *= 0.5;  // of a smooth function a quarter
    } else {
      below = std::max({std::abs(a.excess), std::abs(b.excess), std::abs(m.excess)});
    }
    if (const auto found = first_root(a, m, below, depth + 1)) return found;
    if (meets(m)) return m;
    return first_root(m, b, below, depth + 1);
  }

  std::optional<Sample> root(const Sample& a, const Sample& b) {
    std::uintmax_t iterations = 60;
    Sample best{0, INFINITY, false};
    const auto excess = [&](double x) {
      const Sample s = at(x);
      if (s.valid && std::abs(s.excess) < std::abs(best.excess)) best = s;
      return s.excess;
    };
    const auto close = [&](double x, double y) { return std::abs(x - y) <= 1e-15 || meets(best); };
    for (const Sample& s : {a, b})
      if (std::abs(s.excess) < std::abs(best.excess)) best = s;
    if (!meets(best)) boost::math::tools::toms748_solve(excess, a.x, b.x, a.excess, b.excess, close, iterations);
    if (std::abs(best.excess) <= step_) return best;
    return {};  // the torque jumps over it
  }

  LoadCase case_;
  double torque_;
  Method method_;
  double tolerance_, allowed_, step_;
  double side_ = 1, towards_ = 1;
  bool carried_ = false;  ///< the load, at any slip
  Slips slips_{kLeast};
  std::array<Track, 2> along_;
  Solution last_;
};

}  // namespace

// Outwards from slip 0: the torques of types B and C have peaks on either side, and every law may jump where the
// equilibrium does.
Solution solve_free_slip(const LoadCase& given, double torque, Method method, double tolerance) noexcept {
  return FreeSlip(given, torque, method, tolerance).run();
}

}  // namespace grouser::bekker
