#include "pieces.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker {

namespace {

constexpr double kSharpTurn = 0.7;  // of the arc: a turn spread wider than this needs no cut

constexpr double kLooseFade = 18;   // exp(-18) = 1.5e-8: type A for 1e-6
constexpr double kFadeMargin = 16;  // what exp(-j/K) has to fall below the tolerance: its tail is met by few points
constexpr double kThin = 8;         // layers per arc from which the layer is cut off
constexpr double kSpread = 200;     // points thinned by the exit's map times layers, for which 32 points do
constexpr double kThinnest = 0.35;  // of a piece: thicker layers need no cut
constexpr double kGone = 60;        // j/K: exp(-60) of what shear could be counts as nothing
constexpr double kLong = 0.55;      // [rad], too much of a bow for eight points
constexpr int kMostCuts = kMostPieces;

/// A point where the stresses are not smooth, and how strongly the rule has to crowd towards it on either side.
struct Cut {
  double theta;
  int below, above;
};

class Cuts {
 public:
  Cuts(const Arc& a, double tolerance) : a_(a), near_(tolerance < 1e-7 ? 4 : 3), loose_(tolerance >= 1e-6) {
    power_ = end_power(tolerance);
    set_sharpness();
    fades_ = loose_ && a.type == ShearLaw::Type::A ? kLooseFade : -std::log(tolerance) + kFadeMargin;
  }
  /// A driven wheel, smooth, on virgin soil, whose sliding does not turn sharply: nothing but theta_m cuts the arc.
  bool plain() const {
    if (a_.lugs || a_.zu > 0) return false;
    const double kappa = 1 - a_.e.t;
    if (a_.locked || kappa <= 0) return true;
    if (a_.e.l == 0 || a_.anisotropic) return kappa <= 1;
    // The imaginary part of turn_of against kSharpTurn of the arc, squared twice: no root on the usual path.
    const double w = kSharpTurn * (a_.theta_f - a_.theta_r), A = 2 * (1 - 1 / kappa), B = 2 * a_.e.l / kappa;
    const double limit = 2 * w * w + A;
    return kappa <= 1 && (limit <= 0 || A * A + B * B >= limit * limit);
  }
  /// The shear builds up over a share of the arc so small that its layer at the entry needs a piece of its own.
  /// Or the front branch is so short that it builds up behind theta_m, where the map of the exit spreads the points.
  bool layered() const {
    if (a_.locked) return false;
    if (sharp_ * (a_.theta_f - a_.theta_r) > kThin * fades_) return true;
    return power_ * sharp_ * (a_.theta_m - a_.theta_r) > kSpread && sharp_ * (a_.theta_f - a_.theta_m) < 2 * fades_;
  }
  Pieces two_pieces() const {
    Pieces out;
    out.count = 0;
    const double front = a_.theta_f - a_.theta_m, rear = a_.theta_m - a_.theta_r;
    const int joined = rear > 0 ? power_at_m() : power_;
    out.at[out.count++] = sized({0, front, true}, power_, joined);
    if (rear > 0) out.at[out.count++] = sized({0, rear, false}, power_, joined);
    return out;
  }
  Pieces all_pieces(bool layers) {
    const Arc& a = a_;
    add(a.theta_r, power_, power_);
    add(a.theta_m, power_at_m(), power_at_m());
    add(a.theta_f, power_, power_);
    if (a.lugs && a.concave) {
      add(a.theta_ca, power_, 1);
      add_level(0, a.r_ca, a.theta_ca, a.stretch_ca);
    }
    if (a.zu > 0) add_reloading();
    if (!a.locked) add_shear();
    sort();
    if (layers && !a.locked) add_layers();
    return pieces();
  }

 private:
  Pieces pieces() const {
    Pieces out;
    out.count = 0;
    for (int i = 0; i + 1 < count_; ++i) {
      const Cut &lo = cuts_[i], &hi = cuts_[i + 1];
      const double length = hi.theta - lo.theta;
      if (!(length > 0) || lo.theta < a_.theta_r || hi.theta > a_.theta_f) continue;
      const bool front = lo.theta >= a_.theta_m;
      if (a_.zu > 0 && untouched(0.5 * (lo.theta + hi.theta))) continue;
      out.at[out.count++] = front ? sized({a_.theta_f - hi.theta, length, true}, hi.below, lo.above)
                                  : sized({lo.theta - a_.theta_r, length, false}, lo.above, hi.below);
    }
    return out;
  }

  /// Where theta_m lies close behind the angle at which a surface comes out of the soil, the root of the pressure there
  /// is felt.
  int power_at_m() const {
    const bool out = a_.theta_m < -kMirror * a_.theta_f || (a_.concave && a_.theta_m < -kMirror * a_.theta_ca);
    return out ? power_ : 1;
  }
  MappedPiece sized(const Piece& piece, int p, int q) const {
    MappedPiece m{piece, p, q, 1, true};
    if (!loose_ || !gentle_) return m;
    m.size = m.piece.front ? front_size(m.piece) : rear_size(m.piece, p);
    if (m.p > 1 && m.q > 1) ++m.size;
    if (a_.anisotropic || a_.type != ShearLaw::Type::A || a_.zu > 0) ++m.size;  // sharper, or less regular ends
    m.verify = false;
    return m;
  }
  /// Points for 1e-6 where nothing turns within the arc. The shear stress builds up over the front branch like exp(-J
  /// x), with J the displacements K that the fastest point slides over the piece; on the rear branch that matters while
  /// it is not yet complete.
  int front_size(const Piece& p) const {
    if (!a_.anisotropic && sharp_ * p.start >= 0.5 * fades_) return 1;  // behind the layer
    return std::max(size_of(sharp_ * p.length), int(p.length > kLong));
  }
  /// The exit's power p spreads the points at the other end, where shear goes on building up; what was built up ahead
  /// of the piece is left out of the error.
  int rear_size(const Piece& p, int power) const {
    const double complete = a_.type == ShearLaw::Type::A ? 25 : 80, J = sharp_ * p.length;
    const double ahead = sharp_ * (a_.theta_f - a_.theta_r - p.start - p.length);
    const bool builds = a_.anisotropic || ahead < complete;  // j_l alone may be slow
    const int bow = int(p.length > kLong);
    return builds ? std::max({size_of(J), size_behind(power * J, ahead), bow}) : bow;
  }
  /// Rules for exp(-ahead - J x) to 1e-8, from the Bernstein ellipse that suits J best: index into kRuleSizes.
  static int size_behind(double J, double ahead) {
    return int(J >= 10 + 1.2 * ahead) + int(J >= 50 + 5 * ahead) + int(J >= 110 + 8 * ahead) +
           int(J >= 200 + 15 * ahead);
  }
  static int size_of(double J) { return int(J >= 5) + int(J >= 25) + int(J >= 100); }
  void set_sharpness() {
    if (a_.locked) return;
    const double kappa = 1 - a_.e.t, v = 1 - kappa * a_.cos_f;
    sharp_ = a_.r * a_.inv_K * std::sqrt(v * v + a_.e.l * a_.e.l);
    if (a_.anisotropic || a_.type != ShearLaw::Type::A) sharp_ *= 2;
  }

  void sort() {
    std::sort(cuts_.begin(), cuts_.begin() + count_, [](const Cut& x, const Cut& y) { return x.theta < y.theta; });
  }
  /// Where j is zero (the entry, the turn-over of braking) shear of types A and C builds up, that of type B passes by,
  /// within a few K of sliding, which at a large r/K is a thin layer; shear of type B also dies out within a layer from
  /// any angle where a part of the wheel begins to press. No number of points on the whole piece is safe for every
  /// thickness: a rule, and the next one that should check it, can both miss the layer. So it becomes a piece.
  void add_layers() {
    const int before = count_;
    const bool dies = a_.type == ShearLaw::Type::B;
    const double per_K = a_.r * a_.inv_K, kappa = 1 - a_.e.t;
    for (int i = 0; i < before && count_ + 4 < kMostCuts; ++i) {
      const double t = cuts_[i].theta;
      if (t < a_.theta_r || t > a_.theta_f) continue;
      const double vt = std::abs(1 - kappa * std::cos(t)), vl = std::abs(a_.e.l), bend = std::abs(kappa * std::sin(t));
      const double at_t = t < a_.theta_f ? std::abs(jt(t)) : 0, at_l = vl * (a_.theta_f - t);
      const auto layer = [&](double at, double speed, double turn) {
        const double grown = fades_ / per_K;
        if (dies ? at * per_K > kGone : at > 0.01 * grown) return;
        // speed d + turn d^2/2 = grown
        const double d = 2 * grown / (speed + std::sqrt(speed * speed + 2 * turn * grown));
        end_layer(t - d, before, true);
        if (at < 0.01 * grown) end_layer(t + d, before, false);
      };
      if (a_.anisotropic) {
        layer(at_t, vt, bend);
        if (vl > 0) layer(at_l, vl, 0);
      } else {
        layer(std::sqrt(at_t * at_t + at_l * at_l), std::sqrt(vt * vt + vl * vl), bend);
      }
    }
    sort();
  }

  /// A layer ends at theta, seen from above or below: a cut, unless it fills much of the stretch between the first
  /// `count` cuts in which it ends. That need not be the one in which it begins: theta_m may lie within the layer.
  void end_layer(double theta, int count, bool downwards) {
    for (int i = 0; i + 1 < count; ++i) {
      const double lo = cuts_[i].theta, hi = cuts_[i + 1].theta;
      if (!(theta > lo && theta < hi)) continue;
      const double within = downwards ? hi - theta : theta - lo;
      if (within < kThinnest * (hi - lo)) add(theta, downwards ? power_ : 1, downwards ? 1 : power_);
      return;
    }
  }

  void add(double theta, int below, int above) {
    for (int i = 0; i < count_; ++i)
      if (cuts_[i].theta == theta) {
        cuts_[i].below = std::max(cuts_[i].below, below);
        cuts_[i].above = std::max(cuts_[i].above, above);
        return;
      }
    cuts_[count_++] = {theta, below, above};
  }
  void add_inside(double theta, int power) {
    if (theta > a_.theta_r && theta < a_.theta_f) add(theta, power, power);
  }

  /// (theta_f - theta)^n becomes x^(p n) with a Gauss error that falls like N^(-2 p (n + 1)).
  int end_power(double tolerance) const {
    if (tolerance < 1e-8) return a_.n < 0.8 ? 4 : 3;
    return a_.n < 0.8 ? 3 : 2;
  }

  /// theta_e >= 0 at which the pressure has sunk to z, on a part of radius r that enters at theta_in; < 0: not reached.
  /// By the half angle: the arc cosine would be off by 1e-15 of a small angle's inverse, and its piece may be short.
  static double angle_at(double z, double r, double theta_in) {
    const double half = std::sin(0.5 * theta_in), square = half * half - 0.5 * z / r;
    return square > 0 ? 2 * std::asin(std::sqrt(square)) : -1;
  }
  void add_level(double z, double r, double theta_in, double stretch) {
    const double t = angle_at(z, r, theta_in);
    if (t < 0) return;
    // Where the wheel begins to press deep in the arc, shear of type B dies out within K from there.
    int power = sharp_ * (a_.theta_f - a_.theta_r) > 30 ? near_ : 1;
    // Close to the entry the root of the pressure there is felt.
    if (z == 0 || theta_in - t < 0.2 * (theta_in - a_.theta_m)) power = std::max(power, power_);
    for (const double at : {t, -t}) {  // theta_m may lie behind the bottom
      if (!(at > a_.theta_m && at < theta_in) || (z == 0 && at >= 0)) continue;
      add_inside(at, power);
      if (stretch > 0) add_inside(a_.theta_r + (theta_in - at) / stretch, power);
    }
  }
  /// Kinks of eq 2.12: where the virgin curve takes over and where the reloading wheel begins to press.
  void add_reloading() {
    const double z0 = a_.zu - a_.peak / a_.slope;
    for (const double z : {a_.zu, z0}) {
      if (z > 0) add_level(z, a_.r, a_.theta_f, a_.stretch);
      if (z > 0 && a_.lugs && a_.concave) add_level(z, a_.r_ca, a_.theta_ca, a_.stretch_ca);
    }
  }
  bool untouched(double theta) const {
    const double te = theta >= a_.theta_m ? theta : a_.theta_f - (theta - a_.theta_r) * a_.stretch;
    const double z = a_.r * (std::cos(te) - a_.cos_f);
    return z <= 0 || a_.peak - a_.slope * (a_.zu - z) < 0;
  }

  /// j_t/r = integral of 1 - kappa cos from theta to theta_f.
  double jt(double theta) const { return (a_.theta_f - theta) - (1 - a_.e.t) * (a_.sin_f - std::sin(theta)); }
  /// Root of jt in a..b, where it has opposite signs.
  double root(double a, double b) const {
    const bool rising = jt(a) < 0;
    double t = 0.5 * (a + b);
    for (int i = 0; i < 60; ++i) {
      const double f = jt(t);
      ((f < 0) == rising ? a : b) = t;
      const double slope = -1 + (1 - a_.e.t) * std::cos(t);
      double next = t - f / slope;
      if (!(next > a && next < b)) next = 0.5 * (a + b);
      const bool done = std::abs(next - t) < 1e-15;
      t = next;
      if (done) break;
    }
    return t;
  }

  struct Turn {
    double re, im;  ///< of 2 sin(theta/2), close to theta
    double angle() const { return re < 2 ? 2 * std::asin(0.5 * re) : pi; }
  };
  /// Complex root of cos theta = (1 + i e_l)/kappa.
  Turn turn_of(double kappa) const {
    const double A = 2 * (1 - 1 / kappa), B = 2 * std::abs(a_.e.l) / kappa, m = std::sqrt(A * A + B * B);
    if (A > 0) {
      const double re = std::sqrt(0.5 * (m + A));
      return {re, 0.5 * B / re};
    }
    const double im = std::sqrt(0.5 * (m - A));
    return {im > 0 ? 0.5 * B / im : 0, im};
  }
  /// The sliding velocity is least at cos theta = (1 + i e_l)/kappa: the direction turns there within the imaginary
  /// part of theta. Where j_t changes sign, j has a corner as wide as j_l there.
  void add_shear() {
    const double kappa = 1 - a_.e.t, vl = std::abs(a_.e.l), arc = a_.theta_f - a_.theta_r;
    if (!(kappa > 0)) return;
    const Turn root_at = turn_of(kappa);
    const double im = root_at.im, turn = root_at.angle();
    if (!a_.anisotropic && (vl > 0 || kappa > 1) && im < kSharpTurn * arc) {
      gentle_ = false;
      const int power = vl > 0 ? near_ : 1;
      for (const double t : {turn, -turn}) add_inside(t, power);
      // A turn just outside the arc is felt at its end.
      for (int i = 0; i < count_; ++i)
        if (std::abs(std::abs(cuts_[i].theta) - turn) < im) {
          cuts_[i].below = std::max(cuts_[i].below, power);
          cuts_[i].above = std::max(cuts_[i].above, power);
        }
    }
    if (!(kappa > 1)) return;
    gentle_ = false;
    // Braking: j_t grows from the entry to theta0, falls to -theta0 and grows again.
    const double theta0 = std::acos(std::min(1.0, 1 / kappa));
    double hi = std::min(theta0, a_.theta_f), above = hi < a_.theta_f ? jt(hi) : 0;
    for (const double end : {-theta0, a_.theta_r}) {
      const double lo = std::max(end, a_.theta_r);
      if (!(lo < hi)) break;
      const double below = jt(lo);
      if (above * below < 0) {
        const double t = root(lo, hi);
        const double width = a_.anisotropic ? 0 : vl * (a_.theta_f - t) / std::abs(1 - kappa * std::cos(t));
        if (width < kSharpTurn * arc) add_inside(t, width > 0 ? near_ : 2);
      }
      hi = lo;
      above = below;
    }
  }

  const Arc& a_;
  int near_, power_ = 2;
  double sharp_ = 0;    // J per radian
  bool loose_;          // 1e-6 or more is asked for
  bool gentle_ = true;  // the shear stress neither turns nor changes sign
  double fades_ = 0;    // j/K over which shear is complete, or gone (type B)
  std::array<Cut, kMostCuts> cuts_;
  int count_ = 0;
};

}  // namespace

Pieces pieces_of(const Arc& arc, double tolerance, bool layers) {
  Cuts cuts(arc, tolerance);
  return cuts.plain() && !(layers && cuts.layered()) ? cuts.two_pieces() : cuts.all_pieces(layers);
}

}  // namespace grouser::bekker
