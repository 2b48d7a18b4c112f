#pragma once
// A registered model as the nominal model of a diagnosis: steady wheels by rolling them in the rig. Nothing here
// knows a model by name.
#include <map>
#include <vector>

#include "rig_driver.h"
#include "wheel_answer.h"

namespace grouser::diagnosis {

/// Wheels of one model. Steady answer of a wheel: the depth z at which the mean vertical force is the load,
///   Fz(z, p) = W,   dy/dp = dy/dp|z + dy/dz dz/dp,   dz/dp = (dW/dp - dFz/dp|z)/(dFz/dz)        (R1)
/// with p the soil, the slip, the load and the amplitudes of effects; a later pass rolls in the ruts of the earlier
/// ones, each at its own z(p).
///
/// An anchor is a point a of one condition at which (R1) was solved by rolling (Newton, else Boost's bracket and TOMS
/// 748). Its slopes are forward differences at fixed depth, one roll each, when they are first asked for: the depth
/// being fixed, every node keeps its place and the differences are smooth. Elsewhere
///   y(p) = y(a) + y'(a) (p - a),   y'(p) = y'(a)            (R2)
/// from the nearest anchor. A point further than one scale (soil: prior sd) from every anchor becomes one, up to
/// `most_anchors` of a condition, and `settle` makes one wherever it is wanted: fits descend on (R2) and are rolled where
/// they end. Half a scale off in every soil value at once (R2) misses by a fifth of the noise of the reference set-up.
///
/// Answers depend on the earlier questions; a copy takes the anchors along, so that the same questions asked of two
/// copies get the same bits. One thread.
class RigModel {
 public:
  /// soil, scale: prior means and standard deviations of the coordinates (scale 0: a default).
  RigModel(RigDriver driver, const bekker::EffectWheel& wheel, const std::array<SoilPrior, soil_count>& soil,
           bool sinkage_from_rut);

  const Looks& looks() const { return looks_; }
  /// The model declares the effect and the effect changes something in steady runs.
  bool has(int entry) const { return has_[static_cast<std::size_t>(entry)]; }
  bool declares(int entry) const { return declared_[static_cast<std::size_t>(entry)]; }
  bool feels(int soil_coordinate) const { return feels_[static_cast<std::size_t>(soil_coordinate)]; }
  /// What a reader must know: effects that the model has not, does not show, or that no list of causes has.
  const std::vector<std::string>& notes() const { return notes_; }

  /// run: condition as stated, beside which anchors are kept. t.theta: out: entry angle.
  void turn(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen, const Asked& asked, Turned& t) const;

  /// An anchor at this point, unless there is one: what is then said of it was rolled. False: no wheel there.
  bool settle(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen) const;

  /// Rolls so far, and anchors.
  long rolls() const { return rolls_; }
  long anchors() const;

 private:
  static constexpr int slip_at = soil_count, load_at = soil_count + 1, effect_at = soil_count + 2,
                       dimensions = soil_count + 2 + model_effects;
  using Point = std::array<double, dimensions>;
  /// drawbar, torque, vertical, rut.
  using Forces = Eigen::Vector4d;
  struct Anchor {
    Point p;
    bool good = false;
    double z = 0;
    Forces y = Forces::Zero();     ///< at the load
    Forces base = Forces::Zero();  ///< rolled at z
    Forces by_z = Forces::Zero();  ///< earlier passes as they are
    std::map<int, Forces> by;      ///< at fixed depth of this pass, by coordinates of p
  };
  /// One wheel under one condition.
  struct Place {
    Seen condition;
    double radius = 0, width = 0, reference = 0, density = 0;
    bool operator<(const Place& o) const { return std::memcmp(this, &o, sizeof *this) < 0; }
  };

  /// Where a question belongs.
  struct Asking {
    Place at;
    Point p;
  };

  static Asking asking(const bekker::EffectWheel& wheel, const Run& run, const Seen& seen);
  void probe();
  Forces rolled(const Place& at, const Point& p, const std::vector<double>& depths, bool& good) const;
  void solve(const Place& at, const std::vector<double>& earlier, const Anchor* beside, Anchor& a) const;
  /// Distance in scales.
  double distance(const Place& at, const Point& p, const Point& q) const;
  std::optional<std::size_t> nearest(const Place& at, const Point& p) const;
  std::size_t anchor(const Place& at, const Point& p) const;
  std::size_t anchor_for(const Place& at, const Point& p) const;
  bool earlier(const Place& at, const Point& p, std::vector<double>& depths) const;
  bool slope(const Place& at, std::size_t anchor, int coordinate, Forces& total, double& dz) const;

  RigDriver driver_;
  std::array<SoilPrior, soil_count> prior_;
  bekker::EffectWheel wheel_;
  bool from_rut_;
  Point scale_{};
  Looks looks_;
  std::array<bool, model_effects> has_{}, declared_{};
  std::array<bool, soil_count> feels_{};
  std::vector<std::string> notes_;
  mutable std::map<Place, std::vector<Anchor>> anchors_;
  mutable long rolls_ = 0;
};

}  // namespace grouser::diagnosis
