#pragma once
// A registered model as the nominal model of a diagnosis: steady wheels by rolling them in the rig. Nothing here
// knows a model by name.
#include <map>
#include <unordered_map>
#include <vector>

#include "rig_driver.h"
#include "wheel_answer.h"

namespace grouser::diagnosis {

/// Wheels of one model. Steady answer of a wheel: the depth z at which the mean vertical force is the load,
///   Fz(z, p) = W,   dy/dp = dy/dp|z + dy/dz dz/dp,   dz/dp = (dW/dp - dFz/dp|z)/(dFz/dz)        (R1)
/// with p the soil, the slip, the load and the amplitudes of effects; a later pass rolls in the ruts of the earlier
/// ones, each at its own z(p).
///
/// An anchor is a point p of one condition at which (R1) was solved (Boost: bracket and TOMS 748) and whose slopes
/// at fixed depth are taken by
/// forward differences of 1e-3 of a scale, one roll each, when they are first asked for: the depth being fixed,
/// every node keeps its place and the
/// differences are smooth. Near an anchor (within `near` scales) a value is one roll at the depth that the anchor
/// foretells, put right to the
/// load by the anchor's slopes by z: error of second order in a load that is off by 2 % at most; else two rolls.
/// Slopes near an anchor are
/// the anchor's. Every answer is kept.
///
/// Answers depend on the earlier questions (to about 1e-5); a copy takes the memory along, so that the same
/// questions asked of two copies get the same
/// bits. One thread.
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

  /// Rolls so far.
  long rolls() const { return rolls_; }

 private:
  static constexpr int slip_at = soil_count, load_at = soil_count + 1, effect_at = soil_count + 2,
                       dimensions = soil_count + 2 + model_effects;
  using Point = std::array<double, dimensions>;
  /// drawbar, torque, vertical, rut.
  using Forces = Eigen::Vector4d;
  struct Answer {
    bool good = false;
    double z = 0;
    Forces y = Forces::Zero();
  };
  struct Anchor {
    Point p;
    Answer answer;
    Forces base = Forces::Zero();  ///< rolled at answer.z
    Forces by_z = Forces::Zero();  ///< earlier passes as they are
    std::map<int, Forces> by;      ///< at fixed depth of this pass, by coordinates of p
  };
  /// One wheel under one condition.
  struct Place {
    Seen condition;
    double radius = 0, width = 0, reference = 0, density = 0;
    bool operator<(const Place& o) const { return std::memcmp(this, &o, sizeof *this) < 0; }
  };

  void probe();
  Forces rolled(const Place& at, const Point& p, const std::vector<double>& depths, bool& good) const;
  Answer value(const Place& at, const Point& p) const;
  Answer solve(const Place& at, const Point& p, const std::vector<double>& earlier, double guess, Anchor* keep) const;
  std::optional<std::size_t> nearest(const Place& at, const Point& p, double within) const;
  std::size_t anchor(const Place& at, const Point& p) const;
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
  mutable std::map<Place, std::unordered_map<Seen, Answer, SeenHash>> values_;
  mutable long rolls_ = 0;
};

}  // namespace grouser::diagnosis
