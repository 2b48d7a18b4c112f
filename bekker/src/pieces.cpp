#include "pieces.h"

#include <algorithm>
#include <cmath>

namespace grouser::bekker {

namespace {

constexpr double kSharpTurn = 0.7;  // of the arc: a turn spread wider than this needs no cut

/// A point where the stresses are not smooth, and how strongly the rule has to crowd towards it on either side.
struct Cut {
  double theta;
  int below, above;
};

class Cuts {
 public:
  Cuts(const Arc& a, double tolerance) : a_(a), near_(tolerance < 1e-8 ? 4 : 3), loose_(tolerance >= 1e-6) {
    power_ = end_power(tolerance);
    set_sharpness();
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
  Pieces two_pieces() const {
    Pieces out;
    out.count = 0;
    const double front = a_.theta_f - a_.theta_m, rear = a_.theta_m - a_.theta_r;
    const int joined = rear > 0 ? 1 : power_;
    out.at[out.count++] = sized({0, front, true}, power_, joined);
    if (rear > 0) out.at[out.count++] = sized({0, rear, false}, power_, 1);
    return out;
  }
  Pieces all_pieces() {
    const Arc& a = a_;
    add(a.theta_r, power_, power_);
    add(a.theta_m, 1, 1);
    add(a.theta_f, power_, power_);
    if (a.lugs && a.concave) add(a.theta_ca, power_, 1);
    if (a.zu > 0) add_reloading();
    if (!a.locked) add_shear();
    std::sort(cuts_.begin(), cuts_.begin() + count_, [](const Cut& x, const Cut& y) { return x.theta < y.theta; });
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

  MappedPiece sized(const Piece& piece, int p, int q) const {
    MappedPiece m{piece, p, q, 1, true};
    if (!loose_ || !gentle_) return m;
    m.size = m.piece.front ? front_size(m.piece.length) : rear_size(m.piece.length);
    if (m.p > 1 && m.q > 1) ++m.size;
    if (a_.anisotropic || a_.type != ShearLaw::Type::A || a_.zu > 0) ++m.size;  // sharper, or less regular ends
    m.verify = false;
    return m;
  }
  /// Points for 1e-6 where nothing turns within the arc. The shear stress builds up over the front branch like exp(-J
  /// x), with J the displacements K that the fastest point slides over the piece; on the rear branch that matters while
  /// it is not yet complete.
  int front_size(double length) const { return size_of(sharp_ * length); }
  int rear_size(double length) const {
    const double complete = a_.type == ShearLaw::Type::A ? 25 : 80;
    return sharp_ * (a_.theta_f - a_.theta_m) < complete ? size_of(sharp_ * length) : 0;
  }
  static int size_of(double J) { return int(J >= 5) + int(J >= 25) + int(J >= 150); }
  void set_sharpness() {
    if (a_.locked) return;
    const double kappa = 1 - a_.e.t, v = 1 - kappa * a_.cos_f;
    sharp_ = a_.r * a_.inv_K * std::sqrt(v * v + a_.e.l * a_.e.l);
    if (a_.anisotropic || a_.type != ShearLaw::Type::A) sharp_ *= 2;
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

  /// theta_e at which the pressure has sunk to z, on a part of radius r whose entry has the cosine c; < 0: not reached.
  static double angle_at(double z, double r, double c) {
    const double cosine = c + z / r;
    return cosine < 1 ? std::acos(cosine) : -1;
  }
  void add_level(double z, double r, double theta_in, double cosine, double stretch) {
    const double t = angle_at(z, r, cosine);
    if (!(t > a_.theta_m && t < theta_in)) return;
    // Where the wheel begins to press deep in the arc, shear of type B dies out within K from there.
    const int power = sharp_ * (a_.theta_f - a_.theta_r) > 30 ? near_ : 1;
    add_inside(t, power);
    if (stretch > 0) add_inside(a_.theta_r + (theta_in - t) / stretch, power);
  }
  /// Kinks of eq 2.12: where the virgin curve takes over and where the reloading wheel begins to press.
  void add_reloading() {
    const double z0 = a_.zu - a_.peak / a_.slope;
    for (const double z : {a_.zu, z0}) {
      if (!(z > 0)) continue;
      add_level(z, a_.r, a_.theta_f, a_.cos_f, a_.stretch);
      if (a_.lugs && a_.concave) add_level(z, a_.r_ca, a_.theta_ca, a_.cos_ca, a_.stretch_ca);
    }
  }
  bool untouched(double theta) const {
    const double te = theta >= a_.theta_m ? theta : a_.theta_f - (theta - a_.theta_r) * a_.stretch;
    return a_.peak - a_.slope * (a_.zu - a_.r * (std::cos(te) - a_.cos_f)) < 0;
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
  std::array<Cut, 20> cuts_;
  int count_ = 0;
};

}  // namespace

Pieces pieces_of(const Arc& arc, double tolerance) {
  Cuts cuts(arc, tolerance);
  return cuts.plain() ? cuts.two_pieces() : cuts.all_pieces();
}

}  // namespace grouser::bekker
